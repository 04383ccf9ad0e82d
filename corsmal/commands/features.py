"""``features``: what the fused filling network is given of the videos."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import Ids, Root, complain, progress_bar, say
from corsmal.errors import CorsmalError, FileError


def features(
    root: Root,
    out: Annotated[Path, typer.Argument(metavar="FEATURES", help="Folder for the arrays, ID.npy.")],
    ids: Ids = None,
    *,
    around_container: Annotated[
        bool,
        typer.Option("--around-container", help="Show the network the square around the detected container only."),
    ] = False,
    weights: Annotated[
        Path | None,
        typer.Option(help="Weights of R(2+1)D-18; default: torchvision's for Kinetics, downloaded on first use."),
    ] = None,
    device: Annotated[str | None, typer.Option(help="Such as cuda:0; default: a GPU when there is one.")] = None,
) -> None:
    """Compute features of the videos, a row per 16 frames, for --features of `train`, `evaluate` and `estimate`."""
    import numpy as np

    from corsmal.dataset import open_dataset
    from corsmal.files import writing
    from corsmal.filling.clips import ClipNetwork
    from corsmal.stages.sight import recording_sight
    from corsmal.store import Store

    dataset, store, network = open_dataset(root), Store(), ClipNetwork(weights, device=device)
    wanted, written = tuple(ids or dataset.ids), 0
    with progress_bar("recordings") as progress:
        for done, name in enumerate(wanted, start=1):
            try:
                sight = recording_sight(dataset[name], network, store=store, around_container=around_container)
            except CorsmalError as error:
                complain(name, error)
            else:
                with writing(out / f"{name}.npy", advice="choose another folder") as part, part.open("wb") as file:
                    np.save(file, sight)
                written += 1
            progress(done, len(wanted))
    if not written:
        raise FileError(dataset.root, "has no recording whose videos can be read")
    say(f"{out}: {written} of {len(wanted)} recordings")
