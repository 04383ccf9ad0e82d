"""What sound and sight each said of the level while a recording went on, and the share that the gate gave sight."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.panels import Panels
from corsmal.figures.style import SIGHT, Part, axis, scatter
from corsmal.figures.windows import class_areas, class_labels
from corsmal.filling import FusedPrediction

SENSES = ("sound", "sight")

PANELS_PX = {"sound": 72, "sight": 72, "share": 60, "both": 72}
"""Heights of the panels, from above."""

MARGIN_PX = {"l": 60, "r": 14, "t": 18, "b": 40}

CAPTIONS = {
    "sound": "<b>Level</b> from the sound until then",
    "sight": "<b>Level</b> from the videos until then",
    "share": "<b>Share of sight</b> in the level, as the gate gives it",
    "both": "<b>Level</b> from both",
}

Moments = Sequence[tuple[float, FusedPrediction]]
"""Seconds from the start, and what was predicted then, see ``predicted_until``."""


@Drawing
def senses_figure(moments: Moments, *, duration_s: float) -> Drawn:
    """The level's probabilities from each sense, the share of sight, and the level from both, one below the other.

    Args:
        moments: from the first to the last.
        duration_s: length of the time axis.

    Returns:
        A figure with its height set. A sense that was missing all the time has no panel; where only one was there, it
        is the answer, and there is neither a share nor a panel of both.
    """
    own = {name: [(time_s, found) for time_s, each in moments if (found := getattr(each, name))] for name in SENSES}
    both = [(time_s, each) for time_s, each in moments if each.sound and each.sight]
    shown = {**own, "share": both, "both": both}
    names = [name for name in PANELS_PX if shown[name]]
    panels = Panels({name: PANELS_PX[name] for name in names})
    ids = panels.ids
    traces: list[Part] = []
    labels: list[Part] = []
    for name in names:
        times_s = np.array([time_s for time_s, _ in shown[name]])
        if name == "share":
            traces.append(_share(times_s, [each.sight_share for _, each in both], yaxis=ids[name]))
            continue
        shares = np.array([each.level_probabilities for _, each in shown[name]])
        areas = class_areas(times_s, shares, head="level", yaxis=ids[name])
        traces += [area | {"stackgroup": name} for area in areas]
        labels += class_labels(times_s, shares, head="level", yaxis=ids[name], width_s=duration_s)
    percent = axis("%", range=[0, 100], tickvals=[0, 50, 100], showgrid=False)
    layout = panels.layout(
        margin_px=MARGIN_PX,
        limits_s=(0, duration_s),
        captions=CAPTIONS,
        axes=dict.fromkeys(names, percent),
        annotations=labels,
    )
    return traces, layout


def _share(times_s: NDArray[np.float64], shares: Sequence[float], *, yaxis: str) -> Part:
    return scatter(
        times_s.tolist(),
        [100 * share for share in shares],
        mode="lines+markers",
        yaxis=yaxis,
        line={"color": SIGHT, "width": 2},
        name="share of sight",
        hovertemplate="sight %{y:.0f} %",
    )
