"""How errors spread over containers, and which class is predicted for which."""

import pandas as pd
import streamlit as st

from corsmal.evaluation import METRICS, confusion_tables, container_table, metric_of, paper_table_2, recordings_confused
from corsmal.evaluation.metrics import CLASS_NAMES, NO_ESTIMATE
from corsmal.figures.evaluation import spread_figure
from corsmal.figures.heatmaps import confusion_figure
from corsmal.figures.style import run_colour
from corsmal.quantities import BY_NAME
from corsmal.ui.evaluation.downloads import pin_figure
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.links import open_recording
from corsmal.ui.evaluation.panel import FOCUS, Focus, beside_panel, focus_container
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.one_of import one_of

SPREAD, CONFUSION = "errors", "confusion"
CLASSES = {"filling_type": "Filling type", "filling_level": "Filling level"}


def spread_section(judged: Judged) -> None:
    """One metric by container, the worst first, with the error of every recording."""
    run, errors = judged.run, judged.errors()
    known = [metric for metric in METRICS if pd.notna(metric_of(errors, metric))]
    if not known:
        st.info("No estimate of this run can be compared with the annotation.", icon=":material/info:")
        return
    default = "capacity_mape" if "capacity_mape" in known else None
    metric = one_of(
        "Metric", {each: METRIC_NAMES[each] for each in known}, key="spread_metric", default=default, field="metric"
    )
    is_class = METRICS[metric] in CLASS_NAMES
    click = plot_event("spread").click
    if click is not None and isinstance(click.customdata, str):
        if click.customdata in errors.index:
            open_recording(run, click.customdata, metric=metric)
        focus_container(errors, section=SPREAD, metric=metric, container=click.customdata)
    bars = _bars(container_table(errors), metric)
    points = None if is_class else errors[["container", "failed"]].assign(error=errors[METRICS[metric]])
    measured = f"{METRIC_NAMES[metric]}, {'MPF1' if is_class else 'MAPE'}"
    figure = spread_figure(bars, points, metric=measured, unit="%", colour=run_colour(run.preset))
    with beside_panel(judged, section=SPREAD):
        linked_plot(
            figure,
            key="spread",
            label=f"{METRIC_NAMES[metric]} by container",
            height_px=110 + 34 * len(bars),
            revision=f"{run.name} {metric}",
        )
    st.caption(
        "The worst container first. Click a bar to list its recordings"
        + ("." if is_class else ", a point to open that recording on the page of its stage. Right of zero: too large.")
    )
    numbers = {str(row["container"]): f"{row['value']:.1f} %" for row in bars.to_dict("records")}
    pin_figure(judged, figure, title=f"{measured}, by container", key="spread", numbers=numbers)


def confusion_section(judged: Judged) -> None:
    """Fig. 3: which class is predicted for which, by cup, glass and box."""
    run, errors = judged.run, judged.errors()
    quantity = one_of("Classes", CLASSES, key="confusion_quantity", field="classes")
    tables = {kind: table for kind, table in confusion_tables(errors, quantity).items() if table.to_numpy().any()}
    if not tables:
        st.info(
            "No filling can be compared here: it was not estimated, does not count or is not annotated.",
            icon=":material/graphic_eq:",
        )
        return
    click = plot_event("confusion").click
    if click is not None and click.curve < len(tables):
        kind = list(tables)[click.curve]
        columns, rows = list(tables[kind].columns), list(tables[kind].index)
        if click.x in columns and click.y in rows:
            predicted = NO_ESTIMATE if click.x == columns[-1] else columns.index(click.x)
            behind = recordings_confused(
                errors, quantity, kind=kind, true_class=rows.index(click.y), predicted_class=predicted
            )
            title = f"{kind}, {click.y} taken for {click.x}"
            st.session_state[FOCUS] = Focus(CONFUSION, title, BY_NAME[quantity].metric, tuple(behind.index))
    with beside_panel(judged, section=CONFUSION):
        figure = confusion_figure(tables)
        linked_plot(
            figure,
            key="confusion",
            label=f"Confusion of {quantity.replace('_', ' ')} by kind of container",
            height_px=400,
            revision=f"{run.name} {quantity}",
        )
    st.caption("Counts of recordings; colours are shares of the true class. Click a cell to list its recordings.")
    pin_figure(judged, figure, title=f"Confusion of the {CLASSES[quantity].lower()}", key="confusion")


def _bars(table: pd.DataFrame, metric: str) -> pd.DataFrame:
    """The containers of Table 2 from the worst to the best in one metric, beside the paper's."""
    rows = table[table["container_id"].notna()]
    paper = paper_table_2().set_index("container_id")[metric].reindex(rows["container_id"])
    bars = pd.DataFrame({"container": rows["container"], "value": rows[metric], "recordings": rows["recordings"]})
    bars["paper"] = paper.to_numpy(dtype="float64")
    return bars.sort_values("value", ascending=metric.endswith("_mpf1"), na_position="last", kind="stable")
