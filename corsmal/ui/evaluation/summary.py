"""What the Evaluation page opens with: the run in a few numbers, all metrics by container, the worst recordings."""

import pandas as pd
import streamlit as st

from corsmal.evaluation import METRICS
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.evaluation.summary import ALL, NOMINAL_PERCENT, Headline
from corsmal.evaluation.typesetting import UNLIKE
from corsmal.evaluation.worst import worst_recordings
from corsmal.figures.style import run_colour
from corsmal.figures.summary import multiples_figure, multiples_height_px
from corsmal.quantities import QUANTITIES
from corsmal.ui import session
from corsmal.ui.evaluation.downloads import pin_figure
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.panel import beside_panel, focus_container, focus_recording, newly_selected
from corsmal.ui.evaluation.tables import SHORT
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.one_of import one_of
from corsmal.ui.routes import thumbnail_urls

SECTION = "summary"
PANELS = {each.metric: METRIC_NAMES[each.metric] for each in sorted(QUANTITIES, key=lambda each: each.is_class)}
"""First the errors, then level and type."""

ROW_PX, HEAD_PX = 56, 38
TILE_PX = 108
OVERALL = "overall"


def summary_section(judged: Judged) -> None:
    """Tiles, small multiples, and the ten worst recordings; a click opens a panel beside them."""
    errors, cells = judged.errors(), judged.cells()
    is_alike = judged.split.split == "train"
    _tiles(judged.summary(), is_alike=is_alike)
    click = plot_event("summary").click
    if click is not None and isinstance(click.customdata, list) and len(click.customdata) == 2:
        metric, container = map(str, click.customdata)
        if metric in METRICS and container in {*cells["container"]}:
            one = container if container in {*errors["container"]} else None
            focus_container(errors, section=SECTION, metric=metric, container=one)
    names = {OVERALL: "all quantities"} | METRIC_NAMES
    wanted = session.choice().metric
    worst = worst_recordings(errors, metric=wanted if wanted in METRICS else None)
    key = f"worst {judged.run.id} {judged.protocol} {wanted}"
    chosen = newly_selected(key)
    if chosen is not None and chosen[0] < len(worst):
        by_label = {label: metric for metric, label in METRIC_NAMES.items()}
        metric = by_label.get(chosen[1], "capacity_mape")
        focus_recording(str(worst.index[chosen[0]]), section=SECTION, metric=metric)
    figure = multiples_figure(
        cells,
        labels={metric: SHORT.get(metric, label) for metric, label in PANELS.items()},
        colour=run_colour(judged.run.preset),
    )
    with beside_panel(judged, section=SECTION):
        linked_plot(
            figure,
            key="summary",
            label="All metrics by container, beside the paper's",
            height_px=multiples_height_px(cells["container"].nunique(), panels=len(PANELS)),
            revision=f"{judged.run.id} {judged.protocol}",
        )
        st.caption(
            "Errors: the further left, the better; level and type: the further right, the better. Click a point to "
            "list its recordings." + ("" if is_alike else f" **{UNLIKE}**")
        )
        numbers = {METRIC_NAMES[metric]: f"{value:.1f} %" for metric, value in _averages(cells).items()}
        pin_figure(judged, figure, title="All metrics by container", key="summary", numbers=numbers)
        st.subheader(f"The {len(worst)} worst recordings" if len(worst) > 1 else "The worst recording")
        one_of("by", names, key="worst_metric", field="metric")
        _worst_table(judged, worst, key=key)


def _averages(cells: pd.DataFrame) -> dict[str, float]:
    """The known averages over the containers, by metric."""
    rows = cells[cells["container_id"].isna() & cells["value"].notna()]
    return dict(zip(rows["metric"], rows["value"].astype(float), strict=True))


def _tiles(headlines: tuple[Headline, ...], *, is_alike: bool) -> None:
    with st.container(horizontal=True, gap="xsmall", key="summary_tiles"):
        for each in headlines:
            if each.group == "coverage" and each.name != ALL:
                continue
            label = "In the interval" if each.group == "coverage" else each.label
            label = METRIC_NAMES[each.name] if each.group == "MAPE" else label
            if each.group in ("MAPE", "MPF1"):
                label = f"{label} {'↓' if each.is_lower_better else '↑'}"
            with st.container(border=True, width=TILE_PX, height="stretch", gap=None):
                st.metric(label, "–" if each.value is None else f"{each.value:.1f} %")
                st.caption(_compared(each, is_alike=is_alike))


def _compared(each: Headline, *, is_alike: bool) -> str:
    """What a tile says below its number."""
    if each.group == "coverage":
        counts = f"{each.count} of {each.total}, goal {NOMINAL_PERCENT:.0f} %"
        return "no intervals" if each.value is None else counts
    if each.group == "failures":
        return f"{each.count} of {each.total} recordings"
    if each.value is None or each.reference is None or each.difference is None:
        return f"{each.group}, {'no number that counts' if each.value is None else 'not in the paper'}"
    verdict = "better" if (each.difference < 0) == each.is_lower_better else "worse"
    verdict = f": {verdict if each.is_significant else 'no clear difference'}"
    verdict = verdict if is_alike and each.low is not None else ""  # of a single recording nothing can be said
    return f"{each.group}, paper {each.reference:.1f} %{verdict}"


def _worst_table(judged: Judged, worst: pd.DataFrame, *, key: str) -> None:
    if worst.empty:
        st.caption("No recording of this run can be compared with the annotation.")
        return
    shown = pd.DataFrame({"picture": thumbnail_urls(judged.dataset, list(worst.index))}, index=worst.index)
    shown["recording"], shown["container"] = worst.index, worst["container"]
    shown["mean error"] = worst["mean_error"]
    for metric in PANELS:
        column = METRICS[metric]
        if column in CLASS_NAMES:
            words = worst[f"{column}_correct"].astype("object").map({True: "right", False: "wrong"})
            shown[METRIC_NAMES[metric]] = words
        else:
            shown[METRIC_NAMES[metric]] = worst[column].round() + 0.0  # no "−0"
    numbers = {
        METRIC_NAMES[metric]: st.column_config.NumberColumn(format="%+.0f %%", width=76)
        for metric in PANELS
        if METRICS[metric] not in CLASS_NAMES
    }
    st.dataframe(
        shown,
        key=key,
        on_select="rerun",
        selection_mode=["single-row", "single-cell"],
        hide_index=True,
        row_height=ROW_PX,
        height=HEAD_PX + ROW_PX * len(shown),
        placeholder="–",
        column_config=numbers
        | {
            "picture": st.column_config.ImageColumn("", width=76),
            "recording": st.column_config.TextColumn("Recording", width=80),
            "container": st.column_config.TextColumn("Container", width=120),
            "mean error": st.column_config.NumberColumn("Mean error", format="%.0f %%", width=84),
        },
    )
    st.caption(
        "Mean error: over all quantities; an error counts for 100 % at most, as does a wrong class or a missing "
        "estimate. Click a row to see the recording beside the table."
    )
