"""Several runs beside each other: what they were made with, and one metric of all of them by container."""

import pandas as pd
import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.evaluation.exporting import heading
from corsmal.figures.runs import RunNumbers, runs_figure, runs_height_px
from corsmal.runs.differences import SHAPE, parameter_differences
from corsmal.runs.run import Run
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.parameter_names import option_label, parameter_label
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.one_of import one_of


def compare_parameters(chosen: list[Run]) -> None:
    """The parameters that runs were made with, where they differ."""
    st.subheader("What they were made with, where it differs")
    table = parameter_differences(chosen)
    if table.empty:
        st.caption("Nothing: they have the same parameters, networks and recordings.")
        return
    names = {run.id: run.name for run in chosen}
    fields = [str(name).removeprefix(SHAPE) for name in table.index]
    is_shape = [str(name).startswith(SHAPE) for name in table.index]
    labels = [parameter_label(name) if own else heading(name) for name, own in zip(fields, is_shape, strict=True)]
    shown = table.rename(columns=names).assign(what=labels)
    for name in dict.fromkeys(names.values()):
        shown[name] = [option_label(field, value) for field, value in zip(fields, shown[name], strict=True)]
    st.dataframe(
        shown[["what", *dict.fromkeys(names.values())]],
        hide_index=True,
        height=38 + 35 * len(shown),
        key=f"differences {list(names)}",
        column_config={"what": st.column_config.TextColumn("Parameter", pinned=True)},
    )


def overlay(judged: list[Judged]) -> None:
    """One metric of several runs in one figure, by container."""
    st.subheader("By container")
    metric = one_of("Metric", METRIC_NAMES, key="overlay_metric", default="capacity_mape", field="metric")
    found: list[RunNumbers] = []
    for each in judged:
        try:
            cells = each.cells()
        except CorsmalError:  # it has no recording in common with the annotation
            continue
        if cells.loc[cells["metric"] == metric, "value"].notna().any():
            state = "" if each.run.is_complete else " (partial)"
            found.append(RunNumbers(each.run.name + state, each.run.preset, cells))
    if not found:
        st.info("None of these runs has a number for it that counts.", icon=":material/info:")
        return
    kind = "MAPE" if metric.endswith("_mape") else "MPF1"
    containers = pd.concat([run.cells["container"] for run in found]).nunique()
    linked_plot(
        runs_figure(found, metric=metric, label=f"{METRIC_NAMES[metric]}, {kind} (%)"),
        key="overlay",
        label=f"{METRIC_NAMES[metric]} of several runs by container",
        height_px=runs_height_px(containers, runs=len(found)),
        revision=f"{metric} {[each.run.id for each in judged]}",
    )
    st.caption(
        "Points with 95 % bootstrap intervals over recordings (none for a single one); a colour per preset, a sign per "
        "run. Whether the difference of two runs is significant: *Results*, *Compare*."
    )
