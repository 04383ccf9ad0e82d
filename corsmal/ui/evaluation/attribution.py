"""Which stage the errors come from: the run again with one stage after the other replaced by the truth."""

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.engines.local import local_engine
from corsmal.evaluation import METRICS, attribution_table, estimates_table
from corsmal.evaluation.attribution import AS_IT_IS
from corsmal.evaluation.tables import AVERAGE
from corsmal.figures.heatmaps import blame_figure
from corsmal.runs.attribution import STAGES, attribute_run, known_stages, load_attribution
from corsmal.runs.run import Run
from corsmal.ui import shared
from corsmal.ui.evaluation.downloads import downloads
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.jobs import Job, Priority
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.one_of import one_of


def attribution_section(judged: Judged) -> None:
    """How much of each error goes away with each stage's mistakes."""
    run, dataset = judged.run, judged.dataset
    key = f"attribution {run.key}"
    if follow(key):
        return
    rows = load_attribution(run, store=shared.store())
    if rows is None:
        _offer(key, run, dataset)
        return
    replaced = {stage: estimates_table(found) for stage, found in rows.items()}
    table = attribution_table(run.table, replaced, dataset.table, protocol=judged.protocol)
    changed = table[table["stage"] != AS_IT_IS]
    st.markdown(
        "How much of the error goes away when one stage is **replaced by the truth**: 100 % when nothing is left of "
        "it, negative when it grows."
    )
    linked_plot(
        blame_figure(
            _long(changed[changed["container"] == AVERAGE]),
            rows="stage",
            columns="metric",
            value="removed",
            label="removed",
        ),
        key="attribution_average",
        label="Part of the average error that goes away with each stage",
        height_px=100 + 44 * changed["stage"].nunique(),
        revision=run.name,
    )
    metric = one_of("By container", METRIC_NAMES, key="attribution_metric", default="capacity_mape", field="metric")
    by_container = changed[changed["container"] != AVERAGE]
    linked_plot(
        blame_figure(by_container, rows="container", columns="stage", value=f"{metric}_removed", label="removed"),
        key="attribution_containers",
        label=f"Part of the error in {METRIC_NAMES[metric]} that goes away, by container",
        height_px=90 + 30 * by_container["container"].nunique(),
        revision=f"{run.name} {metric}",
    )
    if not set(STAGES) <= set(rows):
        st.caption("The true masks and the true best frame are known only for synthetic recordings.")
    st.dataframe(table.drop(columns="container_id"), hide_index=True, key=f"attribution table {run.name}")
    downloads(table, name=f"{run.name}_attribution")


def _long(averages: pd.DataFrame) -> pd.DataFrame:
    """A row per stage and metric."""
    named = averages.rename(columns={f"{metric}_removed": METRIC_NAMES[metric] for metric in METRICS})
    return named.melt("stage", list(METRIC_NAMES.values()), var_name="metric", value_name="removed")


def _offer(key: str, run: Run, dataset: Dataset) -> None:
    if is_read_only():
        st.caption(f":material/lock: The errors of this run were not attributed to stages. {READ_ONLY}")
        return
    stages = known_stages(dataset[row["recording_id"]] for row in run.rows if row["recording_id"] in dataset)
    st.info(
        f"Estimate the run again with one stage after the other replaced by the truth: {', '.join(stages)} and filling."
        + (" The true masks and the true best frame are known only for synthetic recordings." * (stages != STAGES)),
        icon=":material/troubleshoot:",
    )
    if st.button("Attribute errors to stages", type="primary", icon=":material/troubleshoot:", key="start_attribution"):
        store = shared.store()

        def work(job: Job) -> None:
            attribute_run(
                run,
                dataset,
                store=store,
                engine=local_engine(len(run.rows), gives_way=True),
                progress=job.advance,
                cancelled=job.cancelled,
            )

        shared.jobs().start(key, "Replacing stages", work, priority=Priority.SHOWN)
        st.rerun()
