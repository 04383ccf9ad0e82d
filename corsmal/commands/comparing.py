"""``evaluate compare``: the paper's method and its authors' program side by side."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from corsmal.commands import Ids, Root, chosen, show
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, resumable_progress
from corsmal.errors import NotFoundError

if TYPE_CHECKING:
    import pandas as pd


def compare(
    root: Root,
    ids: Ids = None,
    *,
    out: Annotated[
        Path | None,
        typer.Option(help="File: .csv for all errors by container and condition, .md for the tables of averages."),
    ] = None,
    engine: EngineName = "local",
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Compare capacity and dimensions by all presets, and by the paper with one rule of its authors' program at a time.

    Detections are needed: beside the videos, or from `detect`.
    """
    import numpy as np
    import pandas as pd

    from corsmal.dataset import open_dataset
    from corsmal.evaluation import estimates_table
    from corsmal.evaluation.escaping import csv_file
    from corsmal.evaluation.rules import PUBLISHED, SHAPE_METRICS, height_sentence, rule_effects, side_by_side
    from corsmal.files import writing
    from corsmal.parameters import SHAPE_PRESETS
    from corsmal.runs.rules import ALONE, RULES, comparable, compare_rules
    from corsmal.store import Store

    if out is not None and out.suffix not in (".csv", ".md"):
        raise typer.BadParameter("the name must end in .csv or .md", param_hint="--out")
    dataset, store = open_dataset(root), Store()
    wanted = {recording.id for recording in chosen(dataset, ids)}
    recordings = [recording for recording in comparable(dataset, store=store) if recording.id in wanted]
    if not recordings:
        raise NotFoundError("no recording has detections and calibrations of two views: detect first (`detect ROOT`)")
    chosen_engine = choose_engine(engine, workers=workers, scheduler=scheduler, recordings=len(recordings))
    with resumable_progress(len(recordings)) as progress:
        rows = compare_rules(recordings, store=store, engine=chosen_engine, progress=progress)
    tables = {name: estimates_table(found) for name, found in rows.items()}
    table = side_by_side(tables, dataset.table)
    columns = [PUBLISHED, *SHAPE_PRESETS]
    for metric in SHAPE_METRICS:
        own = table[(table["metric"] == metric) & table["condition"].isin(columns)]
        wide = own.pivot_table(index="container", columns="condition", values="error", sort=False)
        show(f"{metric}: MAPE in %, {len(recordings)} recordings", wide.reindex(columns=columns))
    averages = _averages(table, recordings=len(recordings))
    for title, found in averages.items():
        show(title, found)
    switched = {rule: tables[f"{ALONE}{rule}"] for rule in RULES}
    effects = rule_effects(tables["paper"], switched, dataset.table, rng=np.random.default_rng(0))
    changes = effects.assign(change=effects["after"] - effects["before"]).pivot_table(
        index="rule", columns="metric", values="change", sort=False
    )
    show("The paper with one rule of the program: change of the MAPE in points", pd.DataFrame(changes))
    typer.echo(height_sentence(table, height_rule=f"{ALONE}height rule"))
    if out is not None:
        with writing(out, advice="choose another file") as part:
            part.write_text(csv_file(table) if out.suffix == ".csv" else _markdown(averages), encoding="utf-8")


def _averages(table: "pd.DataFrame", *, recordings: int) -> "dict[str, pd.DataFrame]":
    """Tables of averages by title: with one rule switched at a time, and with one after the other."""
    from corsmal.evaluation.rules import PUBLISHED, average_errors
    from corsmal.parameters import SHAPE_PRESETS
    from corsmal.runs.rules import ALONE, IN_TURN, RULES

    alone = [PUBLISHED, *SHAPE_PRESETS, *(f"{ALONE}{rule}" for rule in RULES)]
    in_turn = ["paper", *(f"{IN_TURN}{rule}" for rule in RULES)]
    return {
        f"One rule of the program at a time: averages over containers in %, recordings: {recordings}": (
            average_errors(table, alone)
        ),
        "One rule after the other, from the paper to the program": average_errors(table, in_turn),
    }


def _markdown(tables: "dict[str, pd.DataFrame]") -> str:
    from corsmal.evaluation.exporting import export_table
    from corsmal.evaluation.rules import average_texts

    texts = {title: export_table(average_texts(table), table_format="markdown") for title, table in tables.items()}
    return "\n".join(
        f"{title}; MAPE and, in brackets, the mean signed error:\n\n{text}" for title, text in texts.items()
    )
