"""Several frames of a recording fitted, and what they say together."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from corsmal.dataset import Recording
from corsmal.estimation.fit import Fit
from corsmal.geometry import Floats
from corsmal.parameters import SelectionParameters, ShapeParameters
from corsmal.quantities import DIMENSIONS, GEOMETRY
from corsmal.selection import BestFrame, FrameDetections, Pair, score_frames, select_best_frame

VOTERS = 5
"""So many fits say whether it is a box, those whose silhouettes agree best with the masks."""

TRUST_POWER = 2
"""A fit counts with this power of its overlap. The best explained alone would decide less well: a mask that is too wide
in all frames explains itself, and one in which a hand hides the container does not have that fault."""

MIDDLE = (0.1, 0.9)
"""Between these quantiles of the fits their spread is read."""

CAPACITY_SCALE, LENGTH_SCALE = 1.6, 1.2
"""From the spread of the fits and a pixel's size to half of a 90 % interval, as ninety synthetic recordings have it."""

Interval = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Combined:
    """What several fits say together.

    Args:
        fit: the one that is explained best.
        values: their weighted median, by quantity; None where no fit measures it.
        intervals: where the truth lies with a probability of 90 %, by quantity.
    """

    fit: Fit
    values: Mapping[str, float | None]
    intervals: Mapping[str, Interval]


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

    The container is rigid: the median over the fits is taken for each quantity, weighted by how well their silhouettes
    agree with the masks. A box or a solid of revolution, as most of the best explained say.
    """
    found = sorted((fit for fit in fits if fit.ok), key=lambda fit: -(fit.hull.overlap or 0.0))
    if not found:
        return None
    boxes = [fit.hull.depth_mm is not None for fit in found]
    is_box = np.mean(boxes[:VOTERS]) > 0.5
    alike = [fit for fit, box in zip(found, boxes, strict=True) if box == is_box]
    table = np.array([[getattr(fit.dimensions, name) for name in GEOMETRY] for fit in alike], dtype=np.float64)
    weights = np.array([fit.hull.overlap or 1.0 for fit in alike]) ** TRUST_POWER
    low, middle, high = np.array([_quantiles(column, weights, (MIDDLE[0], 0.5, MIDDLE[1])) for column in table.T]).T
    measured = {name: value for name, value in zip(GEOMETRY, middle.tolist(), strict=True) if not np.isnan(value)}
    values = {name: measured.get(name) for name in GEOMETRY}
    if len(fits) == 1 or len(measured) < len(GEOMETRY):
        return Combined(alike[0], values, {})
    return Combined(alike[0], values, _intervals(measured, (high - low) / 2, pixel_mm=_pixel_mm(alike[0], recording)))


def _quantiles(values: Floats, weights: Floats, shares: Sequence[float]) -> Floats:
    """Weighted quantiles: half of a value's weight lies on either side of it. NaN counts only if there is no number."""
    seen = ~np.isnan(values)
    if not seen.any():
        return np.full(len(shares), np.nan)
    values, weights = values[seen], weights[seen]
    order = np.argsort(values)
    below = np.cumsum(weights[order]) - weights[order] / 2
    return np.interp(np.array(shares) * weights.sum(), below, values[order])


def _intervals(values: Mapping[str, float], spreads: Floats, *, pixel_mm: float) -> dict[str, Interval]:
    """Half an interval holds the spread of the fits and what a pixel more or less of the masks does to a quantity."""
    sizes = [values[name] for name in DIMENSIONS]
    pixels = [values["capacity_ml"] * sum(pixel_mm / size for size in sizes), *[pixel_mm] * 3]
    halves = np.array([CAPACITY_SCALE, *[LENGTH_SCALE] * 3]) * np.hypot(spreads, pixels)
    return {
        name: (max(0.0, values[name] - half), values[name] + half)
        for name, half in zip(GEOMETRY, halves.tolist(), strict=True)
    }


def _pixel_mm(fit: Fit, recording: Recording) -> float:
    """What a pixel spans at the container, mean of the pair's views."""
    cameras = [recording.views[name].camera() for name in fit.pair]
    centre = np.zeros(3) if fit.hull.centroid_m is None else fit.hull.centroid_m
    spans = [1000 * np.linalg.norm(camera.centre_m - centre) / camera.intrinsic[0, 0] for camera in cameras]
    return float(np.mean(spans))
