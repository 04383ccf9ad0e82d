"""``demo``: a synthetic dataset."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import progress_bar
from corsmal.commands.engines import Workers


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the new dataset.")],
    *,
    containers: Annotated[
        list[int] | None,
        typer.Option(
            "--container",
            help="Number of a container, 1 to 15; repeat for several; default: all, or 1 to 9 with --training.",
            min=1,
        ),
    ] = None,
    recordings: Annotated[int, typer.Option(help="Number of recordings of each container.", min=1)] = 2,
    width: Annotated[int, typer.Option(help="Width of the videos in pixels, a multiple of 32.", min=32)] = 640,
    training: Annotated[
        bool, typer.Option("--training", help="Write training data: more varied scenes, none of them the demo's.")
    ] = False,
    frame_step: Annotated[int, typer.Option(help="Keep only every n-th frame of the videos.", min=1)] = 1,
    seed: Annotated[int, typer.Option(help="Random seed for the scenes.", min=0)] = 0,
    workers: Workers = None,
) -> None:
    """Write the demo: a synthetic dataset in the layout of the real one, with the true masks in DIR/truth.

    An interrupted run resumes.
    """
    from corsmal.synthetic import write_demo

    if width % 32:
        raise typer.BadParameter(f"must be a multiple of 32, got {width}", param_hint="--width")
    with progress_bar("recordings") as progress:
        write_demo(
            folder,
            seed=seed,
            recordings_per_container=recordings,
            containers=containers,
            training=training,
            frame_step=frame_step,
            size=(width, width * 9 // 16),
            progress=lambda state: progress(state.fraction * state.total, state.total),
            workers=workers,
        )
