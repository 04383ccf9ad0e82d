"""``estimate``: from recordings to a table of estimates."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import FeatureFolder, Ids, Root, chosen, complain, say
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, run
from corsmal.errors import CorsmalError


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
    from corsmal.dataset import open_dataset
    from corsmal.engines.tasks import EstimateTask
    from corsmal.estimation import training_means
    from corsmal.evaluation import estimates_table, write_estimates
    from corsmal.parameters import SHAPE_PRESETS
    from corsmal.store import Store
    from corsmal.weights import find_weights

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
