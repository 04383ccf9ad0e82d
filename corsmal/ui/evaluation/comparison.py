"""Two runs side by side: is the change an improvement or luck, and for which recordings."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.evaluation.tables import AVERAGE
from corsmal.figures.evaluation import comparison_figure
from corsmal.runs.run import Run, named_run
from corsmal.ui import session
from corsmal.ui.evaluation.downloads import downloads, pin_figure
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged, runs
from corsmal.ui.evaluation.links import clicked_row
from corsmal.ui.linked_plot import linked_plot, plot_event

THRESHOLD_PERCENT = 20.0


def comparison_section(judged: Judged) -> None:
    """The chosen run against an earlier one."""
    run = judged.run
    others = {other.short_id: other for other in runs(judged.dataset) if other.id != run.id and other.rows}
    if not others:
        st.info(
            "There is one run on this dataset. Make a second one with other parameters or weights (*New run*, above), "
            "then compare them here.",
            icon=":material/compare_arrows:",
        )
        return
    session.keep_among("against", [*others, *(other.name for other in others.values())])
    state = st.session_state
    first = named_run(others.values(), session.choice().against) or next(iter(others.values()))
    state["comparison_other"] = first.short_id
    st.selectbox(
        f"Is {run.name} better than",
        list(others),
        key="comparison_other",
        format_func=lambda each: f"{others[each].name} ?",
        on_change=lambda: session.choose(against=state["comparison_other"]),
    )
    table = judged.compared_with(first)
    metrics = list(dict.fromkeys(table["metric"]))
    click = plot_event("comparison").click
    if click is not None:
        by_name = {METRIC_NAMES[metric]: metric for metric in metrics}
        session.choose(metric=by_name.get(str(click.customdata), metrics[0]))
    chosen = session.choice().metric or "capacity_mape"
    metric = chosen if chosen in metrics else metrics[0]
    averages = table[table["container"] == AVERAGE].assign(metric_name=lambda rows: rows["metric"].map(METRIC_NAMES))
    figure = comparison_figure(averages, label="metric_name")
    left, right = st.columns(2)
    with left:
        st.markdown("**Averages over the containers.** Click one to see its containers.")
        linked_plot(
            figure,
            key="comparison",
            label="Differences of the averages with 95 % intervals",
            height_px=420,
            revision=f"{first.name} {run.name}",
        )
    with right:
        st.markdown(f"**{METRIC_NAMES[metric]}** by container")
        linked_plot(
            comparison_figure(table[table["metric"] == metric], label="container"),
            key="comparison_containers",
            label="Differences by container with 95 % intervals",
            height_px=420,
            revision=f"{first.name} {run.name} {metric}",
        )
    st.caption(
        "Second run: this one. Lines are 95 % bootstrap intervals of the paired difference over recordings; a point "
        "without a line has one recording and no interval. MAPE: left of zero is better; MPF1 (level, type): right of "
        "zero is better."
    )
    numbers = {row["metric_name"]: _difference(row) for row in averages.to_dict("records")}
    title = f"Averages against run {first.name}"
    pin_figure(judged, figure, title=title, key="comparison", numbers=numbers)
    downloads(table, name=f"{first.name}_{run.name}")
    _changed(first, judged)


def _difference(row: Mapping[Any, Any]) -> str:
    """A difference of two runs with its interval, percentage points."""
    text = f"{row['difference']:+.1f} points"
    has_interval = pd.notna(row["low"]) and pd.notna(row["high"])
    return f"{text} (95 % interval {row['low']:+.1f} to {row['high']:+.1f})" if has_interval else text


def _changed(first: Run, judged: Judged) -> None:
    state, key = st.session_state, "sides_threshold"
    state[key] = threshold = session.choice().within_percent or THRESHOLD_PERCENT
    st.slider(
        "A quantity is right when its error is at most (%)",
        1.0,
        100.0,
        step=1.0,
        format="%d",
        key=key,
        on_change=lambda: session.choose(within_percent=state[key]),
    )
    changed = judged.changed_from(first, threshold_percent=threshold)
    counts = changed["change"].value_counts()
    st.subheader(f"Changed sides: {counts.get('better', 0)} numbers became right, {counts.get('worse', 0)} wrong")
    if changed.empty:
        st.caption("No recording is right in one run and wrong in the other.")
        return
    order = changed.sort_values(["change", "metric"], ascending=[False, True], kind="stable")
    shown = order.drop(columns="container_id").assign(metric=order["metric"].map(METRIC_NAMES))
    shown = shown.rename(columns={"first": first.name, "second": judged.run.name})
    st.caption("Click a row to open the recording on the page of its stage, with this run's parameters.")
    key = f"changed {first.name} {judged.run.name} {threshold}"
    clicked_row(shown, run=judged.run, metric=list(order["metric"]), key=key)
