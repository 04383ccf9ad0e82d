"""The paper's method and its authors' program side by side, and which rule makes which difference."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.digests import digest
from corsmal.engines.engine import Row
from corsmal.engines.local import local_engine
from corsmal.evaluation import estimates_table
from corsmal.evaluation.attribution_words import is_clear
from corsmal.evaluation.rules import (
    PUBLISHED,
    SHAPE_METRICS,
    average_errors,
    height_sentence,
    rule_effects,
    side_by_side,
)
from corsmal.figures.attribution import stage_figure
from corsmal.parameters import SHAPE_PRESETS
from corsmal.runs.rules import ALONE, IN_TURN, RULES, comparable, compare_rules, load_rules
from corsmal.ui import shared
from corsmal.ui.caching import cached
from corsmal.ui.evaluation.downloads import downloads
from corsmal.ui.evaluation.judged import METRIC_NAMES, has_truth
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.job import Job, Priority
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.one_of import one_of

PRESET_COLUMNS = [PUBLISHED, *SHAPE_PRESETS]


def rules_section(dataset: Dataset) -> None:
    """Errors by preset and container, and what each rule changes; a button begins where they were not computed."""
    if not has_truth(dataset):
        return
    key = f"rules {dataset.root}"
    if follow(key):
        return
    rows = load_rules(dataset, store=shared.store())
    if rows is None:
        _offer(key, dataset)
        return
    table, effects = _compared(dataset.table, rows)
    st.info(height_sentence(table, height_rule=f"{ALONE}height rule"), icon=":material/height:")
    _containers(table)
    _effects(effects)
    _in_turn(table)
    downloads(table, name="paper_and_program")


def _key(annotation: pd.DataFrame, rows: Mapping[str, list[Row]]) -> str:
    return digest(pd.util.hash_pandas_object(annotation).to_numpy(), rows)


@cached(8, key=_key, spinner="Computing intervals")
def _compared(annotation: pd.DataFrame, rows: Mapping[str, list[Row]]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The errors of all conditions side by side, and what each rule by itself changes."""
    tables = {name: estimates_table(found) for name, found in rows.items()}
    switched = {rule: tables[f"{ALONE}{rule}"] for rule in RULES}
    effects = rule_effects(tables["paper"], switched, annotation, rng=np.random.default_rng(0))
    return side_by_side(tables, annotation), effects


def _containers(table: pd.DataFrame) -> None:
    """One quantity's errors: a row per container, a column per preset, the published ones first."""
    names = {metric: METRIC_NAMES[metric] for metric in SHAPE_METRICS}
    metric = one_of("Error of", names, key="rules_metric", default="height_mape", field="metric")
    rows = table[(table["metric"] == metric) & table["condition"].isin(PRESET_COLUMNS)]
    wide = rows.pivot_table(index="container", columns="condition", values="error", sort=False)
    counts = rows[rows["condition"] == "paper"].set_index("container")["recordings"]
    wide = wide.reindex(index=list(dict.fromkeys(table["container"])), columns=PRESET_COLUMNS)
    wide.insert(0, "recordings", counts.reindex(wide.index))
    st.dataframe(
        wide.style.format(precision=1, na_rep="–").format("{:.0f}", subset=["recordings"]),
        key="rules_containers",
        placeholder="–",
        height="content",
    )
    st.caption(
        "MAPE in %. The published average is that of all nine containers, on the real dataset; `released` is the "
        "authors' program, `lode` the method that it is based on."
    )


def _effects(effects: pd.DataFrame) -> None:
    """A panel per quantity: its error by the paper, and with each rule of the program switched by itself."""
    st.subheader("Which rule makes which difference")
    rows = effects.to_dict("records")
    shown = effects.assign(
        stage=effects["metric"].map(METRIC_NAMES),
        label=effects["rule"],
        is_clear=[is_clear(row) for row in rows],
        told=[_told(row) for row in rows],
    )
    linked_plot(
        stage_figure(shown, after="with the program's rule"),
        key="rules_effects",
        label="Errors by the paper, and with each rule of the program switched by itself",
        height_px=110 + 30 * len(RULES),
        revision="rules",
    )
    st.caption(
        "Averages over containers in %. A ring is the paper's error, a point that with one rule of the program: green "
        "where it is clearly smaller, red where clearly larger, faded where the 95 % interval of a paired bootstrap "
        "over recordings contains 0."
    )


def _told(row: Mapping[Any, Any]) -> str:
    text = f"{row['rule']}: {METRIC_NAMES[row['metric']]} {row['before']:.1f} → {row['after']:.1f} %"
    if pd.notna(row["low"]):
        text += f"<br>less by {row['gone']:.1f} points (95 % interval {row['low']:.1f} to {row['high']:.1f})"
    return text.replace("-", "−")


def _in_turn(table: pd.DataFrame) -> None:
    """The average errors on the way from the paper to the program, one rule after the other."""
    with st.expander("One rule after the other, from the paper to the program", icon=":material/table:"):
        steps = ["paper", *(f"{IN_TURN}{rule}" for rule in RULES)]
        found = average_errors(table, steps).rename_axis(None)
        found.columns = pd.Index(
            [name for label in (METRIC_NAMES[each] for each in SHAPE_METRICS) for name in (label, f"{label}, signed")]
        )
        st.dataframe(found.style.format(precision=1, na_rep="–"), key="rules_in_turn", height="content")
        st.caption("Averages over containers in %: MAPE, and the mean signed error. The last row is `released`.")


def _offer(key: str, dataset: Dataset) -> None:
    store = shared.store()
    recordings = comparable(dataset, store=store)
    if not recordings:
        st.info(
            "No recording has detections and calibrations of two views: there is nothing to compare. Detect first "
            "(*New run* under *Results*, or `python -m corsmal detect ROOT`).",
            icon=":material/search_off:",
        )
        return
    if is_read_only():
        st.caption(f":material/lock: The rules were not compared on this dataset. {READ_ONLY}")
        return
    st.info(
        f"Estimate the {len(recordings)} recordings with detections by each preset, and by the paper's method with one "
        "rule of its authors' program after the other.",
        icon=":material/rule:",
    )
    if st.button("Compare the rules", type="primary", icon=":material/rule:", key="start_rules"):

        def work(job: Job) -> None:
            engine = local_engine(len(recordings), gives_way=True)
            compare_rules(recordings, store=store, engine=engine, progress=job.advance, cancelled=job.cancelled)

        shared.jobs().start(key, "Comparing rules", work, priority=Priority.SHOWN)
        st.rerun()
