"""Whether views were filmed at other times than their files say, from how the container moves in them."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.dataset.clock import OFFSET_DIGITS, START_MAX_S, FrameClock, Matching
from corsmal.detection import filter_detections
from corsmal.errors import CorsmalError
from corsmal.geometry import Camera, Floats
from corsmal.parameters import METHOD_VIEWS
from corsmal.selection import FrameDetections
from corsmal.shape.cropped import contour_centroid

RANGE_S, STEP_FRAMES = 1.0, 0.5
"""Offsets that are tried."""

FRAMES_MIN, OVERLAP_MIN = 24, 0.6
"""Frames that both views must show at an offset: a number, and a share of those of the view with fewer."""

TREND_DEGREE = 2
"""The centroids of two silhouettes are not images of one point, and a hand hides part of them. How far that moves them
changes slowly, as a polynomial of this degree."""

MISS_MAX, MOTION_MIN = 0.01, 0.002
"""Of the image's width: what may be left of the distance to the epipolar line, and what wrong offsets must leave."""

UNIQUE_MAX, APART_FRAMES = 0.5, 4.0
"""What is left must be less than this share of what any offset further away leaves."""

SUGGESTED_FRAMES = 1.5
"""Where less is found, the views are taken to agree: that is how exact the search is. On the demo's six recordings and
a real one, each shifted by six known numbers of frames, it found three quarters of the offsets, with a median error of
0.3 and at most 0.7 frames (at most 1.5 with 2 pixels of noise); for the others it found none."""


@dataclass(frozen=True)
class Track:
    """Where the centre of the container's mask is.

    Args:
        times_s: (n,) ascending.
        points_px: (n, 2) pixels.
    """

    times_s: Floats
    points_px: Floats


@dataclass(frozen=True)
class ViewOffset:
    """An offset that was found.

    Args:
        view: name of the view.
        reference: the view that it was compared with.
        offset_s: how much later the view was filmed than it is matched now.
    """

    view: str
    reference: str
    offset_s: float


def find_offsets(recording: Recording, detections: Mapping[str, FrameDetections]) -> tuple[ViewOffset, ...]:
    """Offsets between a recording's views, of those that differ by more than the search is wrong.

    Args:
        recording: gives cameras and times.
        detections: unfiltered, by view and the recording's frame; every few frames must be there.
    """
    clock = recording.clock()
    cameras: dict[str, Camera] = {}
    for name in METHOD_VIEWS:
        if name in detections and name in recording.views:
            with suppress(CorsmalError):
                cameras[name] = recording.views[name].camera()
    if len(cameras) < 2 or not clock.fps:
        return ()
    tracks = {name: container_track(detections[name], clock.times_s) for name in cameras}
    reference, *others = cameras
    found = []
    for name in others:
        pair = (cameras[reference], cameras[name])
        offset_s = offset_between(tracks[reference], tracks[name], pair, fps=clock.fps)
        if offset_s is not None and abs(offset_s) * clock.fps > SUGGESTED_FRAMES:
            found.append(ViewOffset(name, reference, offset_s))
    return tuple(found)


def corrected(matching: Matching, clock: FrameClock, found: Iterable[ViewOffset]) -> Matching:
    """How views are to be matched by time with offsets that were found where they were matched by ``matching``."""
    offsets = dict(matching.offsets_s)
    for each in found:
        given, reference = offsets.get(each.view), clock.reference
        begins_s = clock.views[each.view].start_s - clock.views[reference].start_s - offsets.get(reference, 0.0)
        if each.view != reference and given is None and reference not in offsets and abs(begins_s) <= START_MAX_S:
            given = -begins_s  # so far the two were taken to begin together
        offsets[each.view] = round((given or 0.0) + each.offset_s, OFFSET_DIGITS)
    return Matching(offsets_s=tuple(sorted(offsets.items())))


def container_track(view: FrameDetections, times_s: Floats) -> Track:
    """The container's centre in all frames of a view in which it was detected; ``times_s`` are those of the frames."""
    points: dict[int, Floats] = {}
    for frame in sorted(frame for frame in view if frame < len(times_s)):
        container = filter_detections(view[frame], centre_rule="none").container
        centre = None if container is None else contour_centroid(view[frame].mask(container))
        if centre is not None:
            points[frame] = centre
    return Track(times_s[list(points)], np.array(list(points.values())).reshape(-1, 2))


def offset_between(first: Track, second: Track, cameras: tuple[Camera, Camera], *, fps: float) -> float | None:
    """How much later the second view was filmed than its times say, seconds; None where that cannot be told.

    At the right offset the container's centre in one view lies, up to a slow drift, on the epipolar line of its centre
    in the other one. The offset is the one with the least spread about the drift, refined by a parabola.

    Args:
        first: of the view whose times count.
        second: of the other one.
        cameras: of both.
        fps: frames per second of the times.
    """
    steps = round(RANGE_S * fps / STEP_FRAMES)
    shifts_s = np.arange(-steps, steps + 1) * STEP_FRAMES / fps
    least = max(FRAMES_MIN, OVERLAP_MIN * min(len(first.times_s), len(second.times_s)))
    if min(len(first.times_s), len(second.times_s)) < least:
        return None
    matrix = _fundamental(*cameras)
    left = np.array([_left_over(first, second, shift_s, matrix, least) for shift_s in shifts_s]) / cameras[0].size[0]
    if np.isfinite(left).sum() < 2 * APART_FRAMES / STEP_FRAMES:
        return None
    best = int(np.nanargmin(left))
    apart = np.abs(shifts_s - shifts_s[best]) * fps >= APART_FRAMES
    is_inside = 0 < best < len(left) - 1 and bool(np.isfinite(left[best - 1 : best + 2]).all())
    is_clear = left[best] <= UNIQUE_MAX * min(np.nanmin(left[apart], initial=np.inf), np.nanmedian(left))
    if not (is_inside and is_clear and left[best] <= MISS_MAX and np.nanmedian(left) >= MOTION_MIN):
        return None
    before, at, after = left[best - 1 : best + 2]
    bend = before - 2 * at + after
    vertex = 0.5 * (before - after) / bend if bend > 0 else 0.0
    return -float(shifts_s[best] + vertex * STEP_FRAMES / fps)


def _left_over(first: Track, second: Track, shift_s: float, matrix: Floats, least: float) -> float:
    """Spread about a slow drift of the signed distance to the epipolar lines, pixels; NaN where too little overlaps."""
    wanted_s = first.times_s + shift_s
    is_there = (wanted_s >= second.times_s[0]) & (wanted_s <= second.times_s[-1])
    if is_there.sum() < least:
        return np.nan
    other = np.column_stack([np.interp(wanted_s[is_there], second.times_s, axis) for axis in second.points_px.T])
    misses = _epipolar_misses(matrix, first.points_px[is_there], other)
    along = np.linspace(-1, 1, len(misses))
    return float((misses - np.polyval(np.polyfit(along, misses, TREND_DEGREE), along)).std())


def _fundamental(first: Camera, second: Camera) -> Floats:
    """The (3, 3) matrix F with x₂ᵀ F x₁ = 0 for the images of one point (Hartley and Zisserman, section 9.2)."""
    x, y, z = second.projection @ np.append(first.centre_m, 1.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return cross @ second.projection @ np.linalg.pinv(first.projection)


def _epipolar_misses(matrix: Floats, first: Floats, second: Floats) -> NDArray[np.float64]:
    """(n,) signed distances of points of two views, (n, 2) each, from each other's epipolar lines, pixels."""
    homogeneous = [np.column_stack([points, np.ones(len(points))]) for points in (first, second)]
    lines, back = homogeneous[0] @ matrix.T, homogeneous[1] @ matrix
    lengths = np.sqrt((lines[:, :2] ** 2).sum(axis=1) + (back[:, :2] ** 2).sum(axis=1))
    return (homogeneous[1] * lines).sum(axis=1) / lengths
