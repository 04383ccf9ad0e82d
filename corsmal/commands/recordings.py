"""Commands on datasets: make one, detect in one, estimate."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import (
    FeatureFolder,
    Ids,
    Root,
    Weights,
    chosen,
    complain,
    make_detector,
    progress_bar,
    say,
)
from corsmal.errors import CorsmalError


def demo(
    folder: Annotated[Path, typer.Argument(help="Where to write the synthetic dataset.")],
    recordings: Annotated[int, typer.Option(help="Recordings of each of the fifteen containers.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Another seed, another demo.", min=0)] = 0,
) -> None:
    """Write a synthetic dataset in the dataset's own layout, with its truth beside it."""
    from corsmal.demo.writing import write_demo  # noqa: PLC0415 - commands load what they need

    with progress_bar("recordings") as progress:
        write_demo(
            folder,
            seed=seed,
            recordings_per_container=recordings,
            progress=lambda state: progress(state.done, state.total),
        )


def detect(
    root: Root,
    ids: Ids = None,
    weights: Weights = None,
    demo_weights: Annotated[bool, typer.Option("--demo-weights", help="Use the demo's own small network.")] = False,
    every: Annotated[int, typer.Option(help="Search coarsely first: every so many frames.", min=1)] = 1,
) -> None:
    """Find the containers in recordings' frames and keep the detections in the store."""
    from corsmal.batch import detect_recording  # noqa: PLC0415
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    dataset, store = open_dataset(root), Store()
    recordings = chosen(dataset, ids)
    detector = make_detector(weights, is_demo=demo_weights)
    failed = 0
    for recording in recordings:
        try:
            with progress_bar(f"{recording.id}, frames") as progress:
                detect_recording(recording, detector, store=store, every=every, progress=progress)
        except CorsmalError as error:
            failed += 1
            complain(recording.id, error)
    if failed:
        say(f"{failed} of {len(recordings)} recordings failed.")
        raise typer.Exit(1)


def estimate(
    root: Root,
    ids: Ids = None,
    *,
    out: Annotated[Path, typer.Option(help="The table: .csv, .json or .parquet.")] = Path("estimates.csv"),
    preset: Annotated[str, typer.Option(help="Parameters of the fit, such as paper or lode.")] = "paper",
    filling: Annotated[Path | None, typer.Option(help="Weights of the filling network; default: the demo's.")] = None,
    mass: Annotated[Path | None, typer.Option(help="Weights of the mass network; default: the demo's.")] = None,
    features: FeatureFolder = None,
) -> None:
    """Estimate everything about recordings whose containers were detected; a run that was stopped goes on."""
    from corsmal.batch import Predictors, estimate_recordings  # noqa: PLC0415
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.demo import FILLING_WEIGHTS, MASS_WEIGHTS  # noqa: PLC0415
    from corsmal.estimation import training_means  # noqa: PLC0415
    from corsmal.evaluation import estimates_table, write_estimates  # noqa: PLC0415
    from corsmal.filling import FillingPredictor  # noqa: PLC0415
    from corsmal.mass import MassPredictor  # noqa: PLC0415
    from corsmal.parameters import SHAPE_PRESETS  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415

    if preset not in SHAPE_PRESETS:
        raise typer.BadParameter(f"there are the presets {', '.join(SHAPE_PRESETS)}", param_hint="--preset")
    dataset = open_dataset(root)
    predictors = Predictors(
        shape=SHAPE_PRESETS[preset],
        means=training_means(dataset.table),
        filling=FillingPredictor(filling or FILLING_WEIGHTS),
        mass=MassPredictor(mass or MASS_WEIGHTS),
        features=features,
    )
    with progress_bar("recordings") as progress:
        rows = estimate_recordings(chosen(dataset, ids), predictors, store=Store(), progress=progress)
    table = estimates_table(rows)
    write_estimates(table, out)
    counts = table["status"].value_counts()
    say(f"{out}: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
