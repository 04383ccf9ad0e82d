"""``evaluate compare``: the paper's method and its authors' program side by side."""

from pathlib import Path
from typing import Annotated

import typer

from corsmal.commands import Ids, Root, chosen, show
from corsmal.commands.engines import EngineName, Scheduler, Workers, choose_engine, resumable_progress
from corsmal.errors import NotFoundError


def compare(
    root: Root,
    ids: Ids = None,
    *,
    out: Annotated[Path | None, typer.Option(help="File for all errors by container and condition: .csv.")] = None,
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
    from corsmal.evaluation.tables import AVERAGE
    from corsmal.files import writing
    from corsmal.parameters import SHAPE_PRESETS
    from corsmal.runs.rules import ALONE, IN_TURN, RULES, comparable, compare_rules
    from corsmal.store import Store

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
    averages = table[table["container"] == AVERAGE]
    steps = ["paper", *(f"{IN_TURN}{rule}" for rule in RULES)]
    for title, values in (("MAPE", "error"), ("mean signed error", "signed")):
        wide = averages.pivot_table(index="condition", columns="metric", values=values, sort=False)
        show(f"From the paper to the program, one rule after the other: {title} in %", wide.reindex(steps))
    switched = {rule: tables[f"{ALONE}{rule}"] for rule in RULES}
    effects = rule_effects(tables["paper"], switched, dataset.table, rng=np.random.default_rng(0))
    changes = effects.assign(change=effects["after"] - effects["before"]).pivot_table(
        index="rule", columns="metric", values="change", sort=False
    )
    show("The paper with one rule of the program: change of the MAPE in points", pd.DataFrame(changes))
    typer.echo(height_sentence(table, height_rule=f"{ALONE}height rule"))
    if out is not None:
        with writing(out, advice="choose another file") as part:
            part.write_text(csv_file(table), encoding="utf-8")
