"""What was known when: the estimates of a recording, had it ended earlier, on one time axis."""

from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Annotation
from corsmal.figures.answer import HEAD_COLOURS, Head
from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.panels import (
    Panels,
    anchor,
    cursor_text,
    log_mel_axis,
    log_mel_caption,
    log_mel_image,
)
from corsmal.figures.sound import SoundPicture
from corsmal.figures.style import (
    BEST,
    CONTAINER,
    PRESET_COLOURS,
    TOTAL,
    TRUTH,
    Part,
    axis,
    cursor_line,
    note,
    scatter,
)
from corsmal.figures.windows import class_areas, class_labels
from corsmal.stages.moments import Moment

Floats = NDArray[np.float64]

PANELS_PX = {"log-mel": 64, "type": 76, "level": 64, "capacity": 104, "mass": 104}
"""Heights of the panels, from above."""

MARGIN_PX = {"l": 60, "r": 14, "t": 20, "b": 40}
MASSES = {"container_mass_g": ("container", CONTAINER), "object_mass_g": ("container and filling", TOTAL)}
CAPTIONS = {
    "type": "<b>Type</b> from the sound so far",
    "level": "<b>Level</b> from the sound so far",
    "capacity": "<b>Capacity</b> from the frames so far",
    "mass": "<b>Mass</b>: "
    + ", ".join(f'<span style="color:{colour}">{name}</span>' for name, colour in MASSES.values()),
}


@Drawing
def known_when_figure(
    moments: Sequence[Moment],
    *,
    end_s: float,
    picture: SoundPicture | None = None,
    annotation: Annotation | None = None,
    best: tuple[float, str] | None = None,
    preset: str = "tuned",
) -> Drawn:
    """Filling, capacity and masses against the time at which the recording would have ended.

    Args:
        moments: what was known, ascending in time, at least one. A panel of which nothing was known at any of them is
            left out.
        end_s: where the recording ends.
        picture: its sound.
        annotation: the truth, as dashed lines.
        best: a moment, s, that a line marks, and its name.
        preset: of the estimates, whose colour the capacity has.

    Returns:
        A figure with its height set.
    """
    names = _panels(moments, picture)
    panels = Panels({name: PANELS_PX[name] for name in names})
    ids = panels.ids
    truths = _truths(annotation, ids)
    traces = [*_capacity(moments, yaxis=ids["capacity"], colour=PRESET_COLOURS[preset]), *_masses(moments, ids)]
    labels: list[Part] = []
    for head in (head for head in HEAD_COLOURS if head in ids):
        curves = _shares(moments, head)
        traces += class_areas(*curves, head=head, yaxis=ids[head])
        labels += class_labels(*curves, head=head, yaxis=ids[head], width_s=end_s)
    layout = panels.layout(
        margin_px=MARGIN_PX,
        limits_s=(0, end_s),
        captions={name: _caption(name, moments, picture) for name in names},
        axes={name: _axis(name, picture) for name in names},
        images=[] if picture is None else [log_mel_image(picture, yaxis=ids["log-mel"])],
        shapes=[
            *(_across(value, yaxis) for value, yaxis, _ in truths),
            *([] if best is None else [cursor_line(best[0], yref="paper", colour=BEST)]),
        ],
        annotations=[
            *(_truth_text(*truth) for truth in truths),
            *labels,
            *([] if best is None else [cursor_text(*best, colour=BEST)]),
        ],
    )
    if picture is not None:
        traces.append(anchor(ids["log-mel"]))
    return traces, layout


def _panels(moments: Sequence[Moment], picture: SoundPicture | None) -> list[str]:
    """The panels of which something is known."""
    shown = {
        "log-mel": picture is not None,
        "type": _is_known(moments, "type_p0"),
        "level": _is_known(moments, "level_p0"),
        "mass": any(_is_known(moments, name) for name in MASSES),
    }
    return [name for name in PANELS_PX if shown.get(name, True)]


def _is_known(moments: Sequence[Moment], column: str) -> bool:
    return any(moment.row.get(column) is not None for moment in moments)


def _shares(moments: Sequence[Moment], head: Head) -> tuple[Floats, Floats]:
    """(n,) seconds and (n, classes) probabilities, of the moments at which the sound said something."""
    columns = [f"{head}_p{index}" for index in range(len(HEAD_COLOURS[head]))]
    heard = [moment for moment in moments if moment.row[columns[0]] is not None]
    shares = np.array([[moment.row[column] for column in columns] for moment in heard], dtype=np.float64)
    return np.array([moment.time_s for moment in heard]), shares


def _capacity(moments: Sequence[Moment], *, yaxis: str, colour: str) -> list[Part]:
    """The band of the intervals, and the estimates above it."""
    line = _line(moments, "capacity_ml", yaxis=yaxis, name="capacity", colour=colour)
    line |= {"customdata": [_interval(moment) for moment in moments], "hovertemplate": "%{y:.0f} mL%{customdata}"}
    x: list[float | None] = []
    y: list[float | None] = []
    for has_interval, run in groupby(moments, key=lambda moment: bool(_interval(moment))):
        if has_interval:  # a closed outline, there along the upper ends and back along the lower ones
            there = list(run)
            x += [moment.time_s for moment in (*there, *there[::-1])]
            y += [moment.row["capacity_ml_high"] for moment in there]
            y += [moment.row["capacity_ml_low"] for moment in there[::-1]]
            x, y = [*x, None], [*y, None]
    band = scatter(x, y, mode="lines", yaxis=yaxis, name="90 % interval", hoverinfo="skip", line={"width": 0})
    return [band | {"fill": "toself", "fillcolor": colour, "opacity": 0.25}, line] if x else [line]


def _interval(moment: Moment) -> str:
    """A capacity's interval in words; empty where there is none."""
    low, high = (moment.row.get(f"capacity_ml_{end}") for end in ("low", "high"))
    return f" (90 %: {low:.0f}–{high:.0f} mL)" if moment.is_fitted and low is not None else ""


def _masses(moments: Sequence[Moment], ids: Mapping[str, str]) -> list[Part]:
    if "mass" not in ids:
        return []
    return [
        _line(moments, column, yaxis=ids["mass"], name=name, colour=colour)
        | {"hovertemplate": f"%{{y:.0f}} g {name}<extra></extra>"}
        for column, (name, colour) in MASSES.items()
    ]


def _line(moments: Sequence[Moment], column: str, *, yaxis: str, name: str, colour: str) -> Part:
    """One number over time, with gaps where nothing was measured."""
    values = [moment.row[column] if moment.is_fitted else None for moment in moments]
    look = {"yaxis": yaxis, "name": name, "line": {"color": colour, "width": 2}, "marker": {"size": 5}}
    return scatter([moment.time_s for moment in moments], values, mode="lines+markers", **look)


def _truths(annotation: Annotation | None, ids: Mapping[str, str]) -> list[tuple[float, str, str]]:
    """Value, y axis and text of what is annotated."""
    if annotation is None:
        return []
    found = [(annotation.capacity_ml, ids["capacity"], "mL")]
    if "mass" in ids:
        container_g, filling_g = annotation.container_mass_g, annotation.filling_mass_g
        found.append((container_g, ids["mass"], "g"))
        if container_g is not None and filling_g:
            found.append((container_g + filling_g, ids["mass"], "g"))
    return [(value, yaxis, f"annotated {value:.0f} {unit}") for value, yaxis, unit in found if value is not None]


def _across(value: float, yaxis: str) -> Part:
    ends = {"xref": "x domain", "x0": 0, "x1": 1, "yref": yaxis, "y0": value, "y1": value}
    return {"type": "line", **ends, "line": {"color": TRUTH, "width": 1.5, "dash": "dash"}}


def _truth_text(value: float, yaxis: str, text: str) -> Part:
    place = {"x": 0, "xref": "x domain", "xanchor": "left", "xshift": 4, "y": value, "yref": yaxis}
    return note(text, yanchor="bottom", font={"size": 11, "color": TRUTH}, **place)


def _caption(name: str, moments: Sequence[Moment], picture: SoundPicture | None) -> str:
    if name == "log-mel" and picture is not None:
        return log_mel_caption(picture)
    has_band = name == "capacity" and _is_known(moments, "capacity_ml_low")
    return CAPTIONS[name] + (", band: 90 % interval" if has_band else "")


def _axis(name: str, picture: SoundPicture | None) -> Part:
    if name == "log-mel" and picture is not None:
        return log_mel_axis(picture)
    if name in HEAD_COLOURS:
        return axis("%", range=[0, 100], tickvals=[0, 50, 100], showgrid=False)
    return axis("mL" if name == "capacity" else "g", rangemode="tozero", nticks=4)
