"""A recording's sound, and what the filling network makes of it, on one time axis."""

from collections.abc import Sequence

import numpy as np

from corsmal.figures.answer import HEAD_COLOURS
from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.panels import (
    Panels,
    anchor,
    log_mel_axis,
    log_mel_caption,
    log_mel_image,
)
from corsmal.figures.sound import SoundPicture
from corsmal.figures.style import ATTENTION, SOUND, TRUTH, Part, axis, note, scatter
from corsmal.figures.windows import length_s, times_s, window_areas, window_labels
from corsmal.filling import FillingPrediction

PANELS_PX = {"waveform": 60, "log-mel": 124, "attention": 50, "type": 84, "level": 72}
"""Heights of the panels, from above."""

CROPPED = ("waveform", "log-mel", "attention")

LANE_PX = 26
BAR_PX = 8
"""Above the lane the handles' bar is laid."""
MARGIN_PX = {"l": 60, "r": 14, "t": 18, "b": 40}
AMPLITUDE_MIN = 0.01
"""The waveform's axis reaches at least this far: mere noise must not look like a sound."""

TRAINING_CROPS = ((0.0, 0.4, "training crops begin here"), (0.6, 1.0, "training crops end here"))
"""Of the recording's length (paper 2)."""

CAPTIONS = {
    "waveform": "<b>Waveform</b>, {channel}",
    "attention": "<b>CLS attention</b> within the crop (1 = uniform)",
    "type": "<b>Type</b> from a sliding {window_s:g} s window",
    "level": "<b>Level</b> from the same window",
}


@Drawing
def timeline_figure(
    picture: SoundPicture,
    *,
    channel: str,
    prediction: FillingPrediction | None = None,
    windows: Sequence[FillingPrediction] = (),
) -> Drawn:
    """Waveform, log-mel, attention and the probabilities of a sliding window, one below the other.

    Args:
        picture: the channel that is drawn.
        channel: its name.
        prediction: gives the attention; without it its panel is left out.
        windows: predictions for windows that slide across the recording; likewise.

    Returns:
        A figure with its height set. ``layout.meta`` names the parts of the plot's height, from below, that a crop is
        of.
    """
    attended = prediction is not None and prediction.attention is not None
    shown = {"attention": attended, "type": bool(windows), "level": bool(windows)}
    names = [name for name in PANELS_PX if shown.get(name, True)]
    panels = Panels({name: PANELS_PX[name] for name in names}, lane_px=LANE_PX)
    ids, height_px = panels.ids, panels.height_px(MARGIN_PX)
    traces = [*_waveform(picture), anchor(ids["log-mel"])]
    if prediction is not None and "attention" in names:
        traces.append(_attention(prediction, yaxis=ids["attention"]))
    labels = []
    for head in HEAD_COLOURS if windows else ():
        traces += window_areas(windows, head=head, yaxis=ids[head])
        labels += window_labels(windows, head=head, yaxis=ids[head], width_s=picture.duration_s)
    window_s = round(length_s(windows[0]), 1) if windows else 0.0
    captions = {name: text.format(channel=channel, window_s=window_s) for name, text in CAPTIONS.items()}
    captions["log-mel"] = log_mel_caption(picture)
    limits_s = [picture.span_s[0], max(picture.span_s[1], picture.duration_s)]
    layout = panels.layout(
        margin_px=MARGIN_PX,
        limits_s=limits_s,
        captions=captions,
        axes={name: _axis(name, picture) for name in names},
        meta={"cropped": [panels.domains[name] for name in names if name in CROPPED]},
        images=[log_mel_image(picture, yaxis=ids["log-mel"])],
        shapes=_lane(picture, height_px),
        annotations=[*_lane_texts(picture, height_px), *labels],
    )
    return traces, layout


def _axis(name: str, picture: SoundPicture) -> Part:
    if name == "waveform":
        reach = 1.05 * max(AMPLITUDE_MIN, float(-picture.low.min()), float(picture.high.max()))
        return axis("amplitude", range=[-reach, reach], nticks=3, zeroline=True)
    if name == "log-mel":
        return log_mel_axis(picture)
    if name == "attention":
        return axis("relative", rangemode="tozero", nticks=3)
    return axis("%", range=[0, 100], tickvals=[0, 50, 100], showgrid=False)


def _waveform(picture: SoundPicture) -> list[Part]:
    low, high = (
        scatter(picture.times_s, ends, mode="lines", line={"color": SOUND, "width": 1})
        for ends in (picture.low, picture.high)
    )
    filled = {"fill": "tonexty", "fillcolor": SOUND, "hovertemplate": "peak %{y:.3f} of full", "name": ""}
    return [low | {"hoverinfo": "skip"}, high | filled]


def _attention(prediction: FillingPrediction, *, yaxis: str) -> Part:
    times = times_s(prediction)
    relative = np.asarray(prediction.attention) * len(times)
    return scatter(
        times.astype(np.float32),
        relative.astype(np.float32),
        mode="lines",
        yaxis=yaxis,
        line={"color": ATTENTION, "width": 1.5, "shape": "hvh"},
        fill="tozeroy",
        name="",
        hovertemplate="attention %{y:.2f}",
    )


def _lane(picture: SoundPicture, height_px: int) -> list[Part]:
    """Where the paper's crops begin and end, above the panels."""
    bottom = 1 - LANE_PX / _inner_px(height_px)
    return [
        {
            "type": "rect",
            "x0": low * picture.duration_s,
            "x1": high * picture.duration_s,
            "yref": "paper",
            "y0": bottom,
            "y1": 1 - BAR_PX / _inner_px(height_px),
            "fillcolor": TRUTH,
            "opacity": 0.22,
            "line": {"width": 0},
        }
        for low, high, _ in TRAINING_CROPS
    ]


def _lane_texts(picture: SoundPicture, height_px: int) -> list[Part]:
    middle = 1 - (LANE_PX + BAR_PX) / 2 / _inner_px(height_px)
    look = {"y": middle, "yref": "paper", "yanchor": "middle", "opacity": 0.75, "font": {"size": 11}}
    return [note(text, x=(low + high) / 2 * picture.duration_s, **look) for low, high, text in TRAINING_CROPS]


def _inner_px(height_px: int) -> int:
    return height_px - MARGIN_PX["t"] - MARGIN_PX["b"]
