"""Several frames of a recording fitted, and what they say together."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from corsmal.dataset import Recording
from corsmal.estimation.fit import Fit
from corsmal.estimation.intervals import Interval, frame_intervals, pixel_size_mm, recording_intervals
from corsmal.geometry import Floats
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import BestFrame, FrameDetections, Pair, score_frames, select_best_frame

BOX_SLOPE, BOX_LOSS = 100.0, 0.012
"""From the mean gain of overlap by boxes to the logarithm of their odds, as 30 recordings of the demo have it: a box
that a hand hides may lose a little overlap against what is round, and nothing round loses as little."""

TRUST_POWER = 2
"""A fit counts with the inverse of this power of its predicted error, or with this power of its overlap where there is
none. The best one by itself would decide less well: a mask that is too wide in all frames explains itself."""

APART_WEIGHT = 3.0
"""A fit's mean distance from what all fits say, in % of it, counts so much against its predicted error: within 30
recordings of the demo (seeds 5 and 11) their sum ranks the frames best."""

MIDDLE = (0.1, 0.9)
"""Between these quantiles of the fits their spread is read."""


@dataclass(frozen=True, eq=False)
class Combined:
    """What several fits say together.

    Args:
        fit: the one with the least expected error, see ``expected_error_pct``.
        values: their weighted median, by quantity; None where no fit measures it.
        intervals: where the truth lies with a probability of 90 %, by quantity.
        box_odds: how much likelier a box is than a solid of revolution; None where no box was fitted.
    """

    fit: Fit
    values: Mapping[str, float | None]
    intervals: Mapping[str, Interval]
    box_odds: float | None = None


def choose_frames(
    views: Mapping[str, FrameDetections],
    *,
    pair: Pair,
    shape: ShapeParameters,
    selection: SelectionParameters | None = None,
    counted: Collection[int] | None = None,
) -> tuple[BestFrame, list[int]]:
    """The frames of a pair of views that are fitted: the best one, or the best of each of ``shape.frames`` stretches.

    For several frames all those with a container in both views are scored, wherever in the picture it is, if the
    selection has such a rule: the centre rule may leave only the few frames in which another object was taken for the
    container, and one wrong object among many frames is outvoted. Args are as in ``select_best_frame``; ``counted``
    are its ``frames``.

    Returns:
        The scores, and the frames in order; none where there is no best frame.
    """
    selection = selection or SelectionParameters()
    best = select_best_frame(views, pair=pair, parameters=selection, frames=counted)
    if best.frame is None or best.is_fallback:
        return best, [] if best.frame is None else [best.frame]
    if shape.frames > 1 and "none" in selection.centre_rules:
        scores = score_frames(views, pair=pair, centre_rule="none", parameters=selection, frames=counted)
        best = replace(best, centre_rule="none", scores=scores)
    totals = [(score.frame, score.total) for score in best.scores if score.total is not None]
    stretches = np.array_split(np.arange(len(totals)), min(shape.frames, len(totals)))
    return best, [max((totals[index] for index in stretch), key=lambda item: item[1])[0] for stretch in stretches]


def combine_fits(fits: Sequence[Fit], recording: Recording) -> Combined | None:
    """What fits of a pair of views in several frames of one recording say together; None where all failed.

    The container is rigid: the median over the fits is taken for each quantity, weighted by their predicted errors. It
    is a box or a solid of revolution as all fits together say, weighted alike.
    """
    found = sorted((fit for fit in fits if fit.ok), key=_doubt)
    if not found:
        return None
    odds = _box_odds(found)
    is_box = odds is not None and odds > 1
    alike = [fit for fit in found if (fit.hull.depth_mm is not None) == is_box] or found
    table = np.array([[getattr(fit.dimensions, name) for name in GEOMETRY] for fit in alike], dtype=np.float64)
    weights = _weights(alike)
    low, middle, high = np.array([_quantiles(column, weights, (MIDDLE[0], 0.5, MIDDLE[1])) for column in table.T]).T
    measured = {name: value for name, value in zip(GEOMETRY, middle.tolist(), strict=True) if not np.isnan(value)}
    values = {name: measured.get(name) for name in GEOMETRY}
    if all(fit.hull.error_pct is not None for fit in alike):
        alike.sort(key=lambda fit: expected_error_pct(fit, measured))
    if len(fits) == 1 or len(measured) < len(GEOMETRY):
        return Combined(alike[0], values, frame_intervals(alike[0]) if len(fits) == 1 else {}, odds)
    pixel_mm = pixel_size_mm(alike[0], recording)
    return Combined(alike[0], values, recording_intervals(measured, (high - low) / 2, pixel_mm=pixel_mm), odds)


def expected_error_pct(fit: Fit, values: Mapping[str, float]) -> float:
    """The error that a frame's fit is expected to have, in %, knowing what the fits of a recording say together.

    They show one rigid container, so that a fit which lies far from the others is in error, however well it explains
    the masks of its frame.

    Args:
        fit: one with a predicted error.
        values: what all fits say, mL and mm, by quantity.
    """
    apart = [abs(np.log(found / value)) for name, value in values.items() if (found := getattr(fit.dimensions, name))]
    return float(np.hypot(fit.hull.error_pct or 0.0, 100 * APART_WEIGHT * np.mean(apart))) if apart else np.inf


def _doubt(fit: Fit) -> tuple[float, float]:
    """What fits are sorted by, the best first: their predicted error, or else how badly they explain the masks."""
    return (np.inf if fit.hull.error_pct is None else fit.hull.error_pct), -(fit.hull.overlap or 0.0)


def _weights(fits: Sequence[Fit]) -> Floats:
    """How much each fit counts."""
    errors = [fit.hull.error_pct for fit in fits]
    if any(error is None for error in errors):
        return np.array([fit.hull.overlap or 1.0 for fit in fits]) ** TRUST_POWER
    return np.array(errors, dtype=np.float64) ** -TRUST_POWER


def _box_odds(fits: Sequence[Fit]) -> float | None:
    """How much likelier a box is than what is round, by the mean gain of overlap; None where none was fitted."""
    known = [fit for fit in fits if fit.hull.box_gain is not None]
    if not known:
        return None
    gain = np.average([fit.hull.box_gain or 0.0 for fit in known], weights=_weights(known))
    return float(np.exp(np.clip(BOX_SLOPE * (gain + BOX_LOSS), -20.0, 20.0)))


def _quantiles(values: Floats, weights: Floats, shares: Sequence[float]) -> Floats:
    """Weighted quantiles: half of a value's weight lies on either side of it. NaN counts only if there is no number."""
    seen = ~np.isnan(values)
    if not seen.any():
        return np.full(len(shares), np.nan)
    values, weights = values[seen], weights[seen]
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.interp(np.array(shares) * weights.sum(), below, values[order])
