"""When does the network know: the probabilities of a window that slides across a recording."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from corsmal.figures.answer import HEAD_COLOURS, Head
from corsmal.figures.style import Part, note, scatter, text_on
from corsmal.filling import FillingPrediction

Floats = NDArray[np.float64]

LABEL_MIN, LABEL_WIDTH = 0.5, 0.06
"""A class is named inside its area where its probability reaches the one, for so much of the time axis."""


def window_areas(windows: Sequence[FillingPrediction], *, head: Head, yaxis: str) -> list[Part]:
    """Stacked areas, one per class, that together are 100 %; at least one window."""
    return class_areas(*_shares(windows, head), head=head, yaxis=yaxis)


def class_areas(times_s: Floats, shares: Floats, *, head: Head, yaxis: str) -> list[Part]:
    """(n, classes) probabilities at (n,) times, s, as stacked areas of a panel in %."""
    return [
        scatter(
            times_s.astype(np.float32),
            (100 * shares[:, index]).astype(np.float32),
            mode="lines",
            yaxis=yaxis,
            stackgroup=head,
            line={"color": colour, "width": 0},
            fillcolor=colour,
            name=name,
            hovertemplate="%{y:.0f} %",
        )
        for index, (name, colour) in enumerate(HEAD_COLOURS[head].items())
    ]


def window_labels(windows: Sequence[FillingPrediction], *, head: Head, yaxis: str, width_s: float) -> list[Part]:
    """The names of the classes inside their areas, see ``class_labels``."""
    return class_labels(*_shares(windows, head), head=head, yaxis=yaxis, width_s=width_s)


def class_labels(times_s: Floats, shares: Floats, *, head: Head, yaxis: str, width_s: float) -> list[Part]:
    """The name of each class inside its area, in the middle of the longest stretch that is its own, if that is wide.

    Args:
        times_s: (n,) seconds.
        shares: (n, classes) probabilities.
        head: whose classes they are.
        yaxis: of the panel, in %.
        width_s: length of the time axis.
    """
    below = np.cumsum(shares, axis=1) - shares / 2
    texts = []
    for index, (name, colour) in enumerate(HEAD_COLOURS[head].items()):
        start, end = _longest_run(shares[:, index] >= LABEL_MIN)
        if end > start and times_s[end - 1] - times_s[start] >= LABEL_WIDTH * width_s:
            middle = (start + end - 1) // 2
            place = {"x": float(times_s[middle]), "y": float(100 * below[middle, index])}
            font = {"color": text_on(colour), "size": 12}
            texts.append(note(name, yref=yaxis, font=font, **place))
    return texts


def _longest_run(chosen: NDArray[np.bool_]) -> tuple[int, int]:
    """[start, end) of the longest run of true values, the first of equals."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    runs = edges.reshape(-1, 2)
    if not len(runs):
        return 0, 0
    start, end = runs[(runs[:, 1] - runs[:, 0]).argmax()].tolist()
    return start, end


def _shares(windows: Sequence[FillingPrediction], head: Head) -> tuple[Floats, Floats]:
    """(n,) the middles of the windows, s, and (n, classes) probabilities; a lone window from its start to its end."""
    shares = np.array([getattr(window, f"{head}_probabilities") for window in windows], dtype=np.float64)
    if len(windows) == 1:
        return times_s(windows[0])[[0, -1]], np.concatenate([shares, shares])
    return np.array([times_s(window).mean() for window in windows]), shares


def times_s(prediction: FillingPrediction) -> Floats:
    """The middles of the rows that a prediction is of, (n,) seconds."""
    start, end = prediction.rows or (0, 0)
    return np.arange(start, end, dtype=np.float64) * (prediction.steps_s or 0.0)


def length_s(prediction: FillingPrediction) -> float:
    """How long a stretch a prediction is of, seconds."""
    return len(times_s(prediction)) * (prediction.steps_s or 0.0)
