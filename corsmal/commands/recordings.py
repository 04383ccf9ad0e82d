"""Commands on datasets: make one, detect in one, estimate."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import FeatureFolder, Ids, Root, Weights, chosen, complain, progress_bar, say
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, has_gpu, run
from corsmal.errors import CorsmalError


def demo(
    folder: Annotated[Path, typer.Argument(help="Where to write the synthetic dataset.")],
    recordings: Annotated[int, typer.Option(help="Recordings of each of the fifteen containers.", min=1)] = 2,
    seed: Annotated[int, typer.Option(help="Another seed, another demo.", min=0)] = 0,
) -> None:
    """Write a synthetic dataset in the dataset's own layout, with its truth beside it."""
    from corsmal.synthetic.writing.dataset import write_demo  # noqa: PLC0415 - commands load what they need

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
    *,
    weights: Weights = None,
    demo_weights: Annotated[bool, typer.Option("--demo-weights", help="Use the demo's own small network.")] = False,
    every: Annotated[int, typer.Option(help="Search coarsely first: every so many frames.", min=1)] = 1,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Find the containers in recordings' frames and keep the detections in the store; what is there stays."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.engines.engine import in_turn  # noqa: PLC0415 - commands load what they need
    from corsmal.engines.tasks import DetectTask  # noqa: PLC0415 - commands load what they need
    from corsmal.store import Store  # noqa: PLC0415
    from corsmal.weights import find_weights  # noqa: PLC0415

    recordings, store = chosen(open_dataset(root), ids), Store()
    store.check_writable()
    gpu = engine == "local" and has_gpu()
    chosen_engine = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(recordings), gpu=gpu)
    task = DetectTask(
        store.root.resolve(),
        method="small" if demo_weights else "coco",
        weights=find_weights("detector", weights).path if demo_weights else weights and weights.resolve(),
        every=every,
    )
    # opened before the work begins: weights that cannot be used are one sentence, not one for every recording
    if chosen_engine is in_turn:
        task.open()
    else:
        task = replace(task, digest=task.detector("cpu").digest)
    rows = run(task, recordings, chosen_engine)
    failed = [row for row in rows if row["status"] == "failed"]
    for row in failed:
        complain(row["recording_id"], row["notes"])
    if failed:
        say(f"{len(failed)} of {len(recordings)} recordings failed.")
        raise typer.Exit(1)


def estimate(
    root: Root,
    ids: Ids = None,
    *,
    out: Annotated[Path, typer.Option(help="The table: .csv, .json or .parquet.")] = Path("estimates.csv"),
    preset: Annotated[str, typer.Option(help="Parameters of the fit: paper, lode or tuned.")] = "paper",
    wall: Annotated[float | None, typer.Option(help="Of round containers, mm; default: the preset's.")] = None,
    filling: Annotated[Path | None, typer.Option(help="Weights of the filling network; default: the demo's.")] = None,
    mass: Annotated[Path | None, typer.Option(help="Weights of the mass network; default: the demo's.")] = None,
    features: FeatureFolder = None,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Estimate everything about recordings whose containers were detected; a run that was stopped goes on."""
    from corsmal.dataset import open_dataset  # noqa: PLC0415
    from corsmal.engines.tasks import EstimateTask  # noqa: PLC0415 - commands load what they need
    from corsmal.estimation import training_means  # noqa: PLC0415
    from corsmal.evaluation import estimates_table, write_estimates  # noqa: PLC0415
    from corsmal.parameters import SHAPE_PRESETS  # noqa: PLC0415
    from corsmal.store import Store  # noqa: PLC0415
    from corsmal.weights import find_weights  # noqa: PLC0415

    if preset not in SHAPE_PRESETS:
        raise typer.BadParameter(f"there are the presets {', '.join(SHAPE_PRESETS)}", param_hint="--preset")
    dataset, store = open_dataset(root), Store()
    recordings = chosen(dataset, ids)
    try:
        store.check_writable()
    except CorsmalError as error:
        complain("Nothing will be kept for the next run", error)
    task = EstimateTask(
        store.root.resolve(),
        shape=SHAPE_PRESETS[preset] if wall is None else replace(SHAPE_PRESETS[preset], wall_mm=wall),
        means=tuple(training_means(dataset.table).items()),
        filling=find_weights("filling", filling).path,
        mass=find_weights("mass", mass).path,
        features=None if features is None else features.resolve(),
    )
    task = replace(task, key=task.predictors().key)
    chosen_engine = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(recordings), gpu=False)
    table = estimates_table(run(task, recordings, chosen_engine))
    write_estimates(table, out)
    counts = table["status"].value_counts()
    say(f"{out}: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
