"""Which stage the errors come from: the run again with one stage after the other replaced by the truth."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.engines.local import local_engine
from corsmal.evaluation import estimates_table, stage_sentences
from corsmal.evaluation.attribution import SMALL_POINTS
from corsmal.evaluation.attribution_words import STAGE_NAMES, gone_text, is_clear
from corsmal.evaluation.tables import AVERAGE
from corsmal.figures.attribution import stage_figure
from corsmal.figures.heatmaps import share_figure
from corsmal.runs.attribution import STAGES, attribute_run, known_stages, load_attribution
from corsmal.runs.run import Run
from corsmal.ui import shared
from corsmal.ui.evaluation.downloads import downloads, pin_figure
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.job import Job, Priority
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.messages import plain
from corsmal.ui.one_of import one_of

UNKNOWN_MASKS = (
    "The true masks and the true best frame are known only for synthetic recordings, and for those whose masks were "
    "corrected by hand in two views of a frame (*Frames*)."
)


def attribution_section(judged: Judged) -> None:
    """How much of each error goes away with each stage's mistakes."""
    run, dataset = judged.run, judged.dataset
    key = f"attribution {run.key}"
    if follow(key):
        return
    rows = load_attribution(run, dataset, store=shared.store())
    if rows is None:
        _offer(key, run, dataset)
        return
    table = judged.attributed({stage: estimates_table(found) for stage, found in rows.items()})
    st.markdown("Every stage in turn is **replaced by the truth**, and what follows from it is estimated again:")
    sentences = stage_sentences(table)
    st.markdown("\n".join(f"- **{STAGE_NAMES[stage]}.** {plain(text)}" for stage, text in sentences.items()))
    shown = _for_people(table)
    averages = shown[shown["container"] == AVERAGE]
    figure = stage_figure(averages)
    linked_plot(
        figure,
        key="attribution_average",
        label="Average errors as they are and with each stage replaced by the truth",
        height_px=120 + 30 * averages["label"].nunique(),
        revision=run.name,
    )
    st.caption(
        "Averages over containers, in % (of level and type: what MPF1 lacks to 100). A share is the part of the error "
        f"that goes away, between 0 and 100 %; an error below {SMALL_POINTS:g} % is given in "
        "points only. Intervals are 95 % intervals of a paired bootstrap over "
        "recordings; *no clear change*: the interval contains 0."
    )
    told = {STAGE_NAMES[stage]: text for stage, text in sentences.items()}
    pin_figure(judged, figure, title="Errors with each stage replaced by the truth", key="attribution", numbers=told)
    _by_container(shown, run)
    if not set(STAGES) <= set(rows):
        st.caption(UNKNOWN_MASKS)
    _table(shown, run)


def _by_container(shown: pd.DataFrame, run: Run) -> None:
    metric = one_of("By container", METRIC_NAMES, key="attribution_metric", default="capacity_mape", field="metric")
    rows = shown[(shown["metric"] == metric) & (shown["container"] != AVERAGE)]
    if rows.empty:
        st.info(f"There is no number for {METRIC_NAMES[metric]} here.", icon=":material/info:")
        return
    linked_plot(
        share_figure(rows, rows="container", columns="stage"),
        key="attribution_containers",
        label=f"Share of the error of {METRIC_NAMES[metric]} that goes away, by container",
        height_px=90 + 30 * rows["container"].nunique(),
        revision=f"{run.name} {metric}",
    )
    st.caption("Share of the error that goes away; of a small or growing error the change in percentage points.")


def _for_people(table: pd.DataFrame) -> pd.DataFrame:
    """The table with names as people read them, errors of which less is better, and what is said of each cell."""
    rows = table.to_dict("records")
    is_class = ~table["metric"].str.endswith("_mape")
    named = table.assign(
        stage=table["stage"].map(STAGE_NAMES),
        label=table["metric"].map(METRIC_NAMES) + is_class.map({True: " (100 − MPF1)", False: ""}),
        is_clear=[is_clear(row) for row in rows],
        text=[gone_text(row) for row in rows],
    )
    for name in ("before", "after"):
        named[name] = table[name].where(~is_class, 100 - table[name])
    return named.assign(told=[_told(row) for row in named.to_dict("records")])


def _told(row: Mapping[Any, Any]) -> str:
    text = f"{row['label']}: {row['before']:.1f} → {row['after']:.1f} %"
    if pd.notna(row["low"]):
        text += f"<br>less by {row['gone']:.1f} points (95 % interval {row['low']:.1f} to {row['high']:.1f})"
    return text.replace("-", "−")


def _table(shown: pd.DataFrame, run: Run) -> None:
    columns = {
        "stage": "Stage replaced",
        "container": "Container",
        "label": "Error of",
        "recordings": "Recordings",
        "before": "As it is (%)",
        "after": "With the truth (%)",
        "gone": "Less by (points)",
        "low": "95 % from",
        "high": "95 % to",
        "share": "Share (%)",
        "share_low": "Share from",
        "share_high": "Share to",
    }
    table = shown[list(columns)].rename(columns=columns)
    with st.expander("All numbers", icon=":material/table:"):
        st.dataframe(table.style.format(precision=1, na_rep="–"), hide_index=True, key=f"attribution table {run.id}")
    downloads(table, name=f"{run.name}_attribution")


def _offer(key: str, run: Run, dataset: Dataset) -> None:
    if is_read_only():
        st.caption(f":material/lock: The errors of this run were not attributed to stages. {READ_ONLY}")
        return
    if not run.is_complete:
        st.info("This run is incomplete. Its errors can be attributed once all recordings are estimated.")
        return
    recordings = (dataset[row["recording_id"]] for row in run.rows if row["recording_id"] in dataset)
    stages = known_stages(recordings, store=shared.store())
    st.info(
        f"Estimate the run again with one stage after the other replaced by the truth: {', '.join(stages)} and filling."
        + (f" {UNKNOWN_MASKS}" * (stages != STAGES)),
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
