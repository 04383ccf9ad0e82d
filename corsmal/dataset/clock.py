"""The frame clock: when each frame of a recording's views is shown, and which frames are shown together."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from corsmal.digests import file_fingerprint
from corsmal.errors import ArgumentError, CorsmalError, check_choice
from corsmal.notes import Note
from corsmal.parameters import METHOD_VIEWS

if TYPE_CHECKING:
    from corsmal.dataset.layout import View

Match = Literal["time", "index"]
"""Frames of two views belong together by the time at which they are shown, or by their numbers."""

START_MAX_S = 0.1
"""Starts that differ by no more come from encoders, which delay the first frame differently."""

LENGTH_MAX_S = 0.1
"""Ends that differ by no more are not worth a sentence."""

OFFSET_MAX_S, OFFSET_DIGITS = 600.0, 4
CLOCKS_KEPT = 64
TIE_S = 1e-6

Times = NDArray[np.float64]
Value = TypeVar("Value")


@dataclass(frozen=True)
class Matching:
    """How the frames of a recording's views are matched.

    Args:
        by: ``time``, which follows the files' time stamps where they differ, or ``index``.
        offsets_s: by view, how much later than its file says it was filmed, seconds; for ``time`` only.

    Raises:
        ArgumentError: there is no such way, no such view, a view is named twice, or an offset is out of range.
    """

    by: Match = "time"
    offsets_s: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        check_choice("by", self.by, get_args(Match))
        for view, offset_s in self.offsets_s:
            check_choice("offsets_s", view, (*METHOD_VIEWS, "view4"))
            if not -OFFSET_MAX_S <= offset_s <= OFFSET_MAX_S:
                raise ArgumentError(f"offsets_s must lie within {OFFSET_MAX_S:g} s, got {offset_s}")
        if len(dict(self.offsets_s)) != len(self.offsets_s):
            raise ArgumentError(f"offsets_s must name each view once, got {self.offsets_s}")
        if self.offsets_s and self.by == "index":
            raise ArgumentError("offsets_s must be empty where frames are matched by index: they are seconds")

    def __str__(self) -> str:
        """For people, such as ``by time, view1 +0.4 s``."""
        offsets = [f"{view} {offset_s:+.4g} s".replace("-", "−") for view, offset_s in self.offsets_s]
        return ", ".join([f"by {'time' if self.by == 'time' else 'frame number'}", *offsets])


@dataclass(frozen=True)
class ViewFrames:
    """What a view's file says of its frames.

    Args:
        count: how many there are.
        fps: per second, 0 where the file does not say.
        start_s: when the first one is shown.
    """

    count: int
    fps: float
    start_s: float


@dataclass(frozen=True, eq=False)
class FrameClock:
    """Frames and times of a recording; its frames are those of one view, the ``reference``.

    Args:
        times_s: (n,) when each of the recording's frames is shown, seconds, ascending from 0 on.
        fps: frames per second of the reference, 0 where nobody knows.
        reference: name of the view; empty where there is no video.
        frames: by view that is matched by time, (n,) its own frame that is shown with each of the recording's frames,
            −1 where none is; other views have the recording's numbers.
        nearest: likewise the nearest in time, which is never −1.
        notes: sentences on frame counts, rates and starts that differ.
        views: by view whose video can be read, what its file says.
    """

    times_s: Times
    fps: float
    reference: str
    frames: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    nearest: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    views: Mapping[str, ViewFrames] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.times_s)

    def own(self, view: str, frame: int) -> int | None:
        """The view's own frame that is shown with one of the recording's; None where none is."""
        if view not in self.frames:
            return frame
        own = int(self.frames[view][frame]) if 0 <= frame < len(self) else -1
        return own if own >= 0 else None

    def matched(self, view: str) -> int:
        """How many of the recording's frames a view has; as many as its file where it is not matched by time."""
        if view in self.frames:
            return int(np.count_nonzero(self.frames[view] >= 0))
        return self.views[view].count if view in self.views else 0

    def by_frame(self, view: str, found: Mapping[int, Value]) -> Mapping[int, Value]:
        """What is known of a view's own frames, by the recording's frames."""
        if view not in self.frames:
            return found
        owns = enumerate(self.frames[view].tolist())
        return {frame: found[own] for frame, own in owns if own >= 0 and own in found}


def recording_clock(views: "Mapping[str, View]", matching: Matching) -> FrameClock:
    """The clock of a recording's views; a view whose video cannot be read is left out."""
    paths = tuple((name, view.video_path) for name, view in views.items())
    prints = tuple(file_fingerprint(path) if path.is_file() else "" for _, path in paths)
    return _clock(paths, prints, matching)


@lru_cache(maxsize=CLOCKS_KEPT)
def _clock(paths: tuple[tuple[str, Path], ...], _prints: tuple[str, ...], matching: Matching) -> FrameClock:
    notes: tuple[str, ...] = ()
    times = _all_times(dict(paths), exactly=False)
    is_steady = _are_steady(times, matching)
    if not (is_steady and _have_one_length(times)):
        times = _all_times(dict(paths), exactly=True)
        notes, is_steady = _differences(times, matching), _are_steady(times, matching)
    is_plain = is_steady or matching.by == "index"
    found = _plain(times, notes) if is_plain else _by_time(times, matching, notes)
    views = {name: ViewFrames(len(each), rate(each), float(each[0])) for name, each in times.items()}
    return replace(found, views=views)


def _plain(times: Mapping[str, Times], notes: tuple[str, ...]) -> FrameClock:
    """The clock where each view's frames have the recording's numbers: as many as the longest view has."""
    if not times:
        return FrameClock(np.empty(0), 0.0, "", notes=notes)
    reference = max(times, key=lambda name: len(times[name]))
    return FrameClock(times[reference] - times[reference][0], rate(times[reference]), reference, notes=notes)


def _by_time(times: Mapping[str, Times], matching: Matching, notes: tuple[str, ...]) -> FrameClock:
    offsets = dict(matching.offsets_s)
    reference = _reference(times)
    start_s = times[reference][0] + offsets.get(reference, 0.0)
    own = times[reference] - times[reference][0]
    tolerance_s = 0.5 / (rate(own) or 1.0) + 1e-6
    frames, nearest = {}, {}
    for name, each in times.items():
        if name == reference or not rate(each):
            continue  # without time stamps numbers are all there is
        begins_s = each[0] + offsets.get(name, 0.0) - start_s
        if name not in offsets and reference not in offsets and abs(begins_s) <= START_MAX_S:
            begins_s = 0.0
        nearest[name] = _nearest(own, each - each[0] + begins_s)
        misses_s = np.abs((each - each[0] + begins_s)[nearest[name]] - own)
        frames[name] = np.where(misses_s <= tolerance_s, nearest[name], -1)
    return FrameClock(own, rate(own), reference, frames, nearest, notes)


def _nearest(wanted: Times, there: Times) -> NDArray[np.int64]:
    """(n,) the place of the nearest of ascending times for each wanted one."""
    after = np.clip(np.searchsorted(there, wanted), 1, max(1, len(there) - 1))
    before = after - 1
    after = np.minimum(after, len(there) - 1)
    return np.where(wanted - there[before] <= there[after] - wanted + TIE_S, before, after).astype(np.int64)


def rate(times_s: Times) -> float:
    """Frames per second of ascending times, 0 where they do not say."""
    length_s = float(times_s[-1] - times_s[0]) if len(times_s) > 1 else 0.0
    return (len(times_s) - 1) / length_s if length_s > 0 else 0.0


def _reference(times: Mapping[str, Times]) -> str:
    """The view with the highest rate, the robot's own of equals, of those that the method uses."""
    order = [name for name in (*METHOD_VIEWS, *times) if name in times]
    used = [name for name in order if name in METHOD_VIEWS] or order
    return max(used, key=lambda name: round(rate(times[name]), 0)) if used else ""


def _are_steady(times: Mapping[str, Times], matching: Matching) -> bool:
    """Whether frames of equal number are shown together, as far as the views go."""
    return not matching.offsets_s and all(_is_steady(times[_reference(times)], each) for each in times.values())


def _is_steady(first: Times, second: Times) -> bool:
    count = min(len(first), len(second))
    differences = second[:count] - first[:count]
    half_frame_s = 0.5 / (rate(first) or 1.0)
    return float(np.ptp(differences)) <= half_frame_s and abs(float(differences[0])) <= START_MAX_S


def _have_one_length(times: Mapping[str, Times]) -> bool:
    counts = [len(each) for each in times.values()] or [0]
    return max(counts) - min(counts) <= LENGTH_MAX_S * max(map(rate, times.values()), default=0.0)


def _differences(times: Mapping[str, Times], matching: Matching) -> tuple[str, ...]:
    """One sentence on how the views that the method uses differ; none where they do not."""
    used = {name: each for name, each in times.items() if name in METHOD_VIEWS}
    is_steady = _are_steady(used, matching)
    if is_steady and _have_one_length(used):
        return ()
    offsets = dict(matching.offsets_s)
    parts = []
    for name, each in sorted(used.items()):
        start_s = float(each[0]) + offsets.get(name, 0.0)
        start = f" from {start_s:.2f} s on" if abs(start_s) > START_MAX_S else ""
        speed = f"at {rate(each):.4g} fps" if rate(each) else "without time stamps"
        parts.append(f"{name} has {len(each)} frames {speed}{start}")
    how = "by their time stamps all begin together" if is_steady else f"frames are matched {matching}"
    flag = "views-by-time" if matching.by == "time" else "views-by-index"
    return (Note(f"{', '.join(parts)}: {how}", flag=flag),)


def _all_times(paths: Mapping[str, Path], *, exactly: bool) -> dict[str, Times]:
    from corsmal.dataset.video import frame_times_s  # noqa: PLC0415 - who lists a dataset need not load the video library

    times = {}
    for name, path in paths.items():
        try:
            times[name] = frame_times_s(path, exactly=exactly)
        except CorsmalError:
            continue
    return times
