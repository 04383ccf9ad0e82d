"""What could be known when: the estimate of a recording, had it ended earlier."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.estimation import Estimate
from corsmal.estimation.fit import MaskSource
from corsmal.quantities import CLASSES, MEASURED
from corsmal.selection import FrameDetections
from corsmal.stages.detections import DetectionSet
from corsmal.stages.estimates import Predictors, estimate_key, estimate_with
from corsmal.stages.fits import load_fit
from corsmal.store import Store, digest

KIND = "known-when"

STEPS = 16
"""Times of a recording at which it is estimated, equally spaced; the last one is its end."""

ANSWERS = (*CLASSES[::-1], "capacity_ml", "container_mass_g")
ALIKE = 0.1
"""Numbers that differ by less than this share of the last one are the same answer."""

FRAME_SLACK = 1e-6
"""Of a frame's length: a frame that is shown at the very end is part of the recording."""


@dataclass(frozen=True)
class Moment:
    """What was known of a recording at one time.

    Args:
        time_s: seconds from its start.
        row: the estimate from the frames and the sound until then, see ``Estimate.row``.
    """

    time_s: float
    row: Mapping[str, Any]

    @property
    def is_fitted(self) -> bool:
        """Whether the geometry was measured; else it is missing, or the mean of a training set."""
        return str(self.row["status"]).startswith("fitted")


def kept_estimate(
    recording: Recording,
    detections: DetectionSet,
    predictors: Predictors,
    *,
    store: Store,
    end_s: float | None = None,
    source: MaskSource | None = None,
) -> Estimate:
    """The estimate of a recording as ``load_estimate`` makes it, with its hull and masks; single fits are kept.

    Args:
        recording: the recording.
        detections: of the recording.
        predictors: what it is estimated with.
        store: keeps the fits of single frames, and log-mel rows.
        end_s: leave out what was seen and heard later, as if the recording had ended then; default: nothing. Of the
            frames only those count that were inspected, and which ones a search inspects depends on all of them.
        source: cameras and masks of the recording, where the caller has them already.
    """
    views = detections.views if end_s is None else _seen_until(recording, detections, end_s)
    fits = partial(
        load_fit,
        recording,
        detections,
        shape=predictors.shape,
        selection=predictors.selection,
        store=store,
        source=source,
    )
    heard = {"store": store} if end_s is None else {"end_s": end_s}
    return estimate_with(predictors, recording, views, fits=fits, **heard)


def known_when(
    recording: Recording,
    detections: DetectionSet,
    predictors: Predictors,
    times_s: Sequence[float],
    *,
    store: Store,
    only_kept: bool = False,
) -> Iterator[Moment]:
    """What was known of a recording at some times, from the store where it was computed before.

    Args:
        recording: the recording.
        detections: of the recording.
        predictors: what it is estimated with.
        times_s: seconds from its start, positive; see ``moments_s``.
        store: keeps what was known at each time.
        only_kept: leave out the times that the store does not have.

    Yields:
        One record per time, in the given order.

    Raises:
        ArgumentError: a time is not positive.
    """
    if any(time_s <= 0 for time_s in times_s):
        raise ArgumentError(f"times_s must be positive, got {list(times_s)}")
    whole = estimate_key(recording, predictors, detections.key)
    for time_s in times_s:
        key = digest(KIND, whole, time_s)
        row = store.json(KIND, key)
        if row is None and not only_kept:
            row = kept_estimate(recording, detections, predictors, store=store, end_s=time_s).row()
            store.save_json(KIND, key, row)
        if row is not None:
            yield Moment(time_s, row)


def known_since_s(moments: Sequence[Moment]) -> dict[str, float]:
    """From when on an answer is the last one: a class does not change any more, a number is within 10 % of the last.

    Args:
        moments: ascending in time.

    Returns:
        Seconds by quantity; one that is not known at the end is left out.
    """
    since = {}
    for name in ANSWERS:
        for moment in reversed(moments):
            if not _is_alike(name, moment, moments[-1]):
                break
            since[name] = moment.time_s
    return since


def moments_s(recording: Recording, *, steps: int = STEPS) -> tuple[float, ...]:
    """Equally spaced times of a recording, the last one where video and sound have ended.

    Returns:
        Seconds from its start, ascending; none where neither a video nor the sound can be read.

    Raises:
        ArgumentError: ``steps`` is not positive.
    """
    if steps < 1:
        raise ArgumentError(f"steps must be at least 1, got {steps}")
    ends_s = [0.0]
    for view in recording.views.values():
        with suppress(CorsmalError, ZeroDivisionError), view.video() as video:
            ends_s.append(video.frame_count / video.fps)
    with suppress(CorsmalError):
        ends_s.append(recording.audio().duration_s)
    clock = recording.clock()
    if clock.frames:
        ends_s = [*ends_s[-1:], float(clock.times_s[-1]) + 1 / clock.fps if clock.fps else 0.0]
    end_s = max(ends_s)
    return tuple(end_s * (step + 1) / steps for step in range(steps)) if end_s else ()


def coarse_to_fine(times_s: Sequence[float]) -> list[float]:
    """The same times in another order: the last one first, then those that halve the gaps that are left."""
    total = len(times_s)
    order: list[int] = []
    step = total
    while len(order) < total:
        order += [index for index in range(total - 1, -1, -step) if index not in order]
        step = max(1, step // 2)
    return [times_s[index] for index in order]


def _is_alike(name: str, moment: Moment, last: Moment) -> bool:
    """Whether an answer is there and the same as the last one."""
    value, final = (None if name in MEASURED and not each.is_fitted else each.row[name] for each in (moment, last))
    if value is None or final is None:
        return False
    return bool(value == final if name in CLASSES else abs(value - final) <= ALIKE * final)


def _seen_until(recording: Recording, detections: DetectionSet, end_s: float) -> dict[str, FrameDetections]:
    """The detections in frames that begin before a time, by view."""
    clock = recording.clock()
    slack_s = FRAME_SLACK / clock.fps if clock.fps else 0.0
    frames = int(np.searchsorted(clock.times_s, end_s - slack_s))
    return {
        name: {frame: found[frame] for frame in found if frame < frames} for name, found in detections.views.items()
    }
