"""``attribute``: which stage causes which part of the errors."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from corsmal.commands import Root, show
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, resumable_progress
from corsmal.commands.runs import open_run
from corsmal.files import writing

if TYPE_CHECKING:
    from corsmal.dataset import Dataset
    from corsmal.engines.engine import Engine
    from corsmal.parameters import ShapeParameters
    from corsmal.runs import Run


def attribute(
    root: Root,
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Name of the run; not for --ablation.")] = None,
    *,
    ablation: Annotated[
        bool,
        typer.Option("--ablation", help="Compare all presets, and tuned without each of its parts (synthetic data)."),
    ] = False,
    scatter: Annotated[
        Path | None, typer.Option(help="HTML file for a plot of View Scores against errors (synthetic data).")
    ] = None,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Show how much of a run's errors goes away when one stage is replaced by the truth."""
    from corsmal.dataset import open_dataset
    from corsmal.evaluation import ablation_table, estimates_table
    from corsmal.runs.attribution import ablate
    from corsmal.store import Store

    if name is None and not ablation:
        raise typer.BadParameter("name a run, or give --ablation", param_hint="NAME")
    dataset = open_dataset(root)
    chosen = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(dataset))
    if ablation:
        with resumable_progress(len(dataset)) as progress:
            rows = ablate(dataset, store=Store(), engine=chosen, progress=progress)
        tables = {condition: estimates_table(found) for condition, found in rows.items()}
        show("MAPE in %, and % of the truths inside their 90 % intervals", ablation_table(tables, dataset.table))
    if name is not None:
        _, run = open_run(root, name)
        _show_attribution(run, dataset, chosen)
        if scatter is not None:
            _write_scatter(dataset, run.settings.shape, scatter)


def _show_attribution(run: "Run", dataset: "Dataset", engine: "Engine") -> None:
    import numpy as np
    import pandas as pd

    from corsmal.evaluation import METRICS, attribution_table, estimates_table, stage_sentences
    from corsmal.evaluation.attribution import AS_IT_IS
    from corsmal.runs.attribution import attribute_run, load_attribution
    from corsmal.store import Store

    store = Store()
    rows = load_attribution(run, dataset, store=store)
    if rows is None:
        with resumable_progress(len(run.rows)) as progress:
            rows = attribute_run(run, dataset, store=store, engine=engine, progress=progress)
    replaced = {stage: estimates_table(found) for stage, found in rows.items()}
    table = attribution_table(run.table, replaced, dataset.table, rng=np.random.default_rng(0))
    before = table.drop_duplicates(["container", "metric"]).assign(stage=AS_IT_IS, after=lambda rows: rows["before"])
    values = pd.concat([before, table]).pivot_table(
        index=["container", "stage"], columns="metric", values="after", sort=False
    )
    shown = values.reindex(columns=list(METRICS))
    show("MPF1 and MAPE in %, with one stage replaced by the truth", shown)
    for sentence in stage_sentences(table).values():
        typer.echo(sentence)


def _write_scatter(dataset: "Dataset", shape: "ShapeParameters", path: Path) -> None:
    from corsmal.figures.scores import score_error_figure
    from corsmal.runs.view_scores import score_errors

    scores = score_errors(dataset, shape=shape)
    correlation = scores["rank"].corr(scores["error_rank"])
    typer.echo(f"View Score against error of a frame, rank correlation within recordings: {correlation:+.2f}")
    with writing(path, advice="choose another file") as part:
        score_error_figure(scores).write_html(part, include_plotlyjs=True, config={"showSendToCloud": False})
