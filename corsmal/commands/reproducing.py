"""``reproduce``: the paper's evaluation from a dataset to its tables by one command."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from corsmal.commands import (
    PRESET_HELP,
    DetectFirst,
    FeatureOptions,
    MatchViews,
    Offsets,
    Root,
    progress_bar,
    say,
    shape_preset,
    view_matching,
)
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine
from corsmal.parameters import FillingPreset
from corsmal.quantities import duration_text

if TYPE_CHECKING:
    from corsmal.runs.reproduction_settings import PlannedStep


def reproduce(
    root: Root,
    *,
    out: Annotated[Path, typer.Option(help="Folder for networks, tables and the report.")],
    test: Annotated[list[Path] | None, typer.Option(help="Folder of a test set; repeat for several.")] = None,
    protocol: Annotated[
        Literal["held-out", "paper"],
        typer.Option(
            help="held-out: no recording is judged by a network that was trained on it or chosen by it; paper: as "
            "published, epochs are chosen on the recordings that are judged."
        ),
    ] = "held-out",
    folds: Annotated[
        Literal["spread", "containers"],
        typer.Option(help="spread: networks know the containers from other recordings; containers: they do not."),
    ] = "spread",
    seeds: Annotated[int, typer.Option(help="Number of cross-validations, with the seeds 0, 1, …", min=1)] = 1,
    preset: Annotated[str, typer.Option(help=PRESET_HELP)] = "paper",
    networks: Annotated[
        FillingPreset,
        typer.Option(
            help="Preset of both networks. released: networks, front end, masks and training of the authors' program; "
            "with --preset released, too, all of it is reproduced. fused: the filling's from --features of sound "
            "and of the videos, the mass network's as tuned."
        ),
    ] = "paper",
    features: FeatureOptions = None,
    detector: DetectFirst = None,
    match: MatchViews = None,
    offset: Offsets = None,
    quick: Annotated[bool, typer.Option("--quick", help="Train for a few epochs only, for a first look.")] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Print the steps with their estimated times and stop.")] = False,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Reproduce the paper's tables: detection, geometry, cross-validation, final networks, Table 2, submissions.

    Every step is kept: an interrupted command resumes, and a second one with the same options computes nothing.
    """
    from corsmal.dataset import open_dataset
    from corsmal.filling.sight import FeatureFolders
    from corsmal.runs.reproduction import StepProgress
    from corsmal.runs.reproduction import reproduce as run
    from corsmal.runs.reproduction_settings import ReproductionSettings
    from corsmal.runs.reproduction_settings import plan as planned
    from corsmal.stages.settings import find_detector

    folders = FeatureFolders.of(features or [])
    settings = ReproductionSettings(
        protocol=protocol,
        folds=folds,
        seeds=seeds,
        shape=shape_preset(preset),
        networks=networks,
        features=None if folders.sound is None else folders.sound.resolve(),
        sight=None if folders.sight is None else folders.sight.resolve(),
        detector=None if detector is None else find_detector(detector),
        is_quick=quick,
        matching=view_matching(match, offset),
    )
    dataset, tests = open_dataset(root), test or []
    _say_plan(planned(dataset, settings, [open_dataset(folder) for folder in tests]))
    if plan:
        return
    chosen_engine = choose_engine(
        engine, workers=workers, scheduler=scheduler, recordings=len(dataset), detects=detector is not None
    )
    with progress_bar("reproduction, %") as bar:

        def report(state: StepProgress) -> None:
            bar(round(100 * state.share), 100, f"{state.step}, {duration_text(state.left_s)} left, %")

        found = run(root, out=out, settings=settings, tests=tests, engine=chosen_engine, progress=report)
    for note in found.notes:
        say(note)
    averages = found.table2[found.table2["container_id"].isna()].set_index("metric")
    typer.echo(averages[["value", "low", "high", "recordings", "failures", "published"]].round(1).to_string())
    say(f"Report: {found.report}")


def _say_plan(steps: "list[PlannedStep]") -> None:
    for step in steps:
        say(f"{step.name}: {step.what}, about {duration_text(step.seconds)}")
    say(f"Together about {duration_text(sum(step.seconds for step in steps))} on two cores where nothing is kept yet.")
