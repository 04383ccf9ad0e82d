"""Which stage the errors come from: the run again with one stage after the other replaced by the truth."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.errors import ArgumentError
from corsmal.evaluation import METRICS, blame_table, error_table, estimates_table, with_true
from corsmal.evaluation.attribution import KnownStage
from corsmal.evaluation.tables import AVERAGE
from corsmal.figures.heatmaps import blame_figure
from corsmal.runs.attribution import STAGES, blame_rows, load_blame
from corsmal.runs.run import Run
from corsmal.stages import true_views
from corsmal.store import Store
from corsmal.ui import data
from corsmal.ui.evaluation import cached as evaluation
from corsmal.ui.evaluation.cached import METRIC_NAMES
from corsmal.ui.evaluation.downloads import downloads
from corsmal.ui.evaluation.runs import follow
from corsmal.ui.jobs import Job
from corsmal.ui.linked_plot import linked_plot

HEARD: KnownStage = "filling"


def blame_section(run: Run, dataset: Dataset) -> None:
    """How much of each error goes away with each stage's mistakes."""
    key = f"blame {run.key}"
    if follow(key):
        return
    kept = load_blame(run, store=data.store())
    if kept is None:
        _offer(key, run, dataset)
        return
    table = blamed(run, dataset, kept)
    stages = list(dict.fromkeys(table["stage"]))
    st.markdown(
        "How much of the error goes away when one stage is **replaced by the truth**: 100 % when nothing is left of "
        "it, negative when it grows."
    )
    linked_plot(
        blame_figure(
            _long(table[table["container"] == AVERAGE]),
            rows="stage",
            columns="metric",
            value="removed",
            label="removed",
        ),
        key="blame_average",
        label="Part of the average error that goes away with each stage",
        height_px=100 + 44 * len(stages),
        revision=run.name,
    )
    metric = st.segmented_control(
        "By container",
        list(METRICS),
        default="capacity_mape",
        required=True,
        format_func=METRIC_NAMES.__getitem__,
        key="blame_metric",
    )
    by_container = table[table["container"] != AVERAGE]
    linked_plot(
        blame_figure(by_container, rows="container", columns="stage", value=f"{metric}_removed", label="removed"),
        key="blame_containers",
        label=f"Part of the error in {METRIC_NAMES[str(metric)]} that goes away, by container",
        height_px=90 + 30 * by_container["container"].nunique(),
        revision=f"{run.name} {metric}",
    )
    if stages[0] != STAGES[0]:
        st.caption("An annotation knows dimensions and filling alone; masks and the best frame are known of the demo.")
    st.dataframe(table.drop(columns="container_id"), hide_index=True, key=f"blame table {run.name}")
    downloads(table, name=f"{run.name}_blame")


def blamed(run: Run, dataset: Dataset, replaced: Mapping[str, list[dict[str, Any]]]) -> pd.DataFrame:
    """The blame table of a run.

    Args:
        run: the run as it is.
        dataset: gives the annotation.
        replaced: from ``blame_rows``.

    Raises:
        ArgumentError: the annotation knows nothing of the run's recordings.
    """
    tables = {stage: estimates_table(replaced[stage]) for stage in STAGES if stage in replaced}
    tables[HEARD] = with_true(evaluation.estimates(run), dataset.table, HEARD)
    errors = {stage: error_table(table, dataset.table) for stage, table in tables.items()}
    return blame_table({"as it is": evaluation.errors(run, dataset)} | errors)


def _long(averages: pd.DataFrame) -> pd.DataFrame:
    """A row per stage and metric."""
    parts = [
        averages[["stage"]].assign(metric=METRIC_NAMES[metric], removed=averages[f"{metric}_removed"])
        for metric in METRICS
    ]
    return pd.concat(parts, ignore_index=True)


def _offer(key: str, run: Run, dataset: Dataset) -> None:
    has_masks = dataset[run.rows[0]["recording_id"]].is_synthetic
    stages = f"{', '.join(STAGES)} and {HEARD}" if has_masks else f"{STAGES[-1]} and {HEARD}"
    st.info(
        f"Estimate the run again with one stage after the other replaced by the truth: {stages}."
        + ("" if has_masks else " Masks and the best frame are known of the demo alone."),
        icon=":material/troubleshoot:",
    )
    if st.button("Find the stage to blame", type="primary", icon=":material/troubleshoot:", key="start_blame"):
        store = data.store()
        data.jobs().start(key, "Replacing stages", lambda job: _work(job, run, dataset, store, has_masks=has_masks))
        st.rerun()


def _work(job: Job, run: Run, dataset: Dataset, store: Store, *, has_masks: bool) -> None:
    job.advance(0, len(run.rows))
    predictors = evaluation.make_predictors(dataset, run.shape)
    if predictors.key != run.predictors_key:
        raise ArgumentError("the networks' weights or the annotation changed since the run was made: make a new run")
    blame_rows(
        run,
        dataset,
        predictors,
        store=store,
        true_views=true_views if has_masks else None,
        progress=job.advance,
        cancelled=job.cancelled,
    )
