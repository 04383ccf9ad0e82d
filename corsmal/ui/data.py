"""Cached calls of the library. Keys are small; what they return is shared between sessions and never changed."""

import contextlib
import os
from functools import cache
from pathlib import Path

import numpy as np
import streamlit as st
from numpy.typing import NDArray

from corsmal.dataset import Dataset, Recording, Video, open_dataset
from corsmal.detection import filter_detections
from corsmal.errors import CorsmalError, NotFoundError
from corsmal.estimation import Estimate, Fit, container_mask, estimate, fit_frame
from corsmal.figures import draw_detections, jpeg
from corsmal.geometry import Camera
from corsmal.parameters import METHOD_VIEWS, PAIRS, SHAPE_PRESETS, CentreRule, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame, Pair, select_best_frame
from corsmal.stages.detections import DetectionSet, load_detections
from corsmal.stages.fits import load_fit
from corsmal.store import Store, digest, file_fingerprint
from corsmal.ui import media
from corsmal.ui.jobs import Jobs

PICTURE_WIDTH_PX = 960
"""Frames are sent this wide at most: three of them side by side fill a large screen."""


@cache
def store() -> Store:
    """The store of this server."""
    return Store()


@cache
def jobs() -> Jobs:
    """The background jobs of this server."""
    return Jobs()


def dataset(root: str) -> Dataset:
    """The dataset in a folder, read again when a file was added to it or removed.

    Raises:
        FileError: there is no dataset.
    """
    return _dataset(root, _folder_times(os.path.expanduser(root)))


def recording_key(recording: Recording) -> str:
    """A digest of a recording's files: what is cached for it is not used once one of them changed."""
    paths = [path for view in recording.views.values() for path in (view.video_path, view.calibration_path)]
    paths += [view.detections_path for view in recording.views.values()]
    return digest("recording", recording.id, [file_fingerprint(path) for path in paths if path is not None])


def detections(recording: Recording) -> DetectionSet:
    """The detections of a recording: files beside the videos, else what the store holds.

    They are looked for again when a job of this server has kept more.
    """
    job = jobs().get(detection_job_key(recording))
    kept = None if job is None else (job.started_s, job.active, job.results)
    return _detections(recording_key(recording), kept, _recording=recording)


def detection_job_key(recording: Recording) -> str:
    """The key of the job that detects in a recording."""
    return f"detect {recording_key(recording)}"


def best_frame(recording: Recording, *, pair: Pair) -> BestFrame:
    """The best frame of a pair, with all scores."""
    found = detections(recording)
    return _best_frame(found.key, pair, _detections=found)


def estimated_pair(recording: Recording) -> Pair:
    """The pair of views that the estimate takes; the first pair where it finds none."""
    found = detections(recording)
    result = _estimate(recording_key(recording), found.key, "paper", _recording=recording, _detections=found)
    return PAIRS[0] if result.best_frame is None else result.best_frame.pair


def frame_image(recording: Recording, *, view: str, frame: int) -> NDArray[np.uint8]:
    """One frame, (H, W, 3) uint8 RGB, read only.

    Raises:
        CorsmalError: the view or the frame cannot be read.
    """
    return _frame_image(recording_key(recording), view, frame, _recording=recording)


def frame_picture(recording: Recording, *, view: str, frame: int, centre_rule: CentreRule) -> bytes:
    """One frame as JPEG, with its detections drawn on it where there are any.

    Raises:
        CorsmalError: the view or the frame cannot be read.
    """
    found = detections(recording)
    return _frame_picture(
        recording_key(recording), found.key, view, frame, centre_rule, _recording=recording, _detections=found
    )


def mask(recording: Recording, *, view: str, frame: int, centre_rule: CentreRule) -> NDArray[np.bool_] | None:
    """The container's (H, W) mask in one frame of a view, all false without a container; None if not inspected."""
    found = detections(recording).views.get(view)
    if found is None or frame not in found:
        return None
    return container_mask(found[frame], centre_rule=centre_rule, parameters=SelectionParameters())


def cameras(recording: Recording) -> dict[str, Camera]:
    """The fixed cameras whose calibration can be read, by view."""
    return _cameras(recording_key(recording), _recording=recording)


def fit(
    recording: Recording, *, pair: Pair, frame: int, centre_rule: CentreRule, shape: ShapeParameters, keep: bool
) -> Fit:
    """The hull of one pair in one frame; ``keep`` it in the store unless something is being dragged."""
    found = detections(recording)
    if keep:
        return load_fit(recording, found, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape, store=store())
    return fit_frame(recording, found.views, pair=pair, frame=frame, centre_rule=centre_rule, shape=shape)


def tuned_estimate(recording: Recording) -> Estimate:
    """The geometry of a recording over several frames, with intervals: the preset ``tuned``."""
    found = detections(recording)
    return _estimate(recording_key(recording), found.key, "tuned", _recording=recording, _detections=found)


def preset_fit(
    recording: Recording, beside: Fit, *, centre_rule: CentreRule, preset: str | None
) -> tuple[str, Fit] | None:
    """A preset's name and its hull of another fit's frame; None where none is asked for."""
    if preset is None or beside.frame is None:
        return None
    shape = SHAPE_PRESETS[preset]
    return preset, fit(recording, pair=beside.pair, frame=beside.frame, centre_rule=centre_rule, shape=shape, keep=True)


def frame_count(recording: Recording, *, view: str) -> int:
    """How many frames a view has.

    Raises:
        CorsmalError: the video cannot be read.
    """
    return _video(recording_key(recording), view, _recording=recording).frame_count


def playable_video(recording: Recording, *, view: str) -> Path:
    """A file that browsers can play: the view's own, or a smaller copy in the store.

    Raises:
        CorsmalError: the video cannot be read.
    """
    return media.playable_video(recording.views[view], store=store())


@st.cache_resource(max_entries=8, show_spinner="Reading the dataset folder")
def _dataset(root: str, times: tuple[tuple[str, int], ...]) -> Dataset:
    del times  # part of the key alone
    return open_dataset(root)


def _folder_times(root: str) -> tuple[tuple[str, int], ...]:
    """Modification times of the folder and two levels below it, and of the annotation: cheap to ask for."""
    times: list[tuple[str, int]] = []
    pending = [(root, 0)]
    while pending:
        folder, depth = pending.pop()
        try:
            times.append((folder, os.stat(folder).st_mtime_ns))
            with os.scandir(folder) as entries:
                for entry in entries if depth < 2 else ():
                    if entry.is_dir():
                        pending.append((entry.path, depth + 1))
                    elif depth == 0:
                        times.append((entry.path, entry.stat().st_mtime_ns))
        except (OSError, ValueError):  # the latter for what can be no file name; opening the dataset says what is wrong
            continue
    return tuple(sorted(times))


@st.cache_resource(max_entries=32, show_spinner="Reading the detections")
def _detections(key: str, kept: tuple[float, bool, int] | None, *, _recording: Recording) -> DetectionSet:
    del key, kept
    return load_detections(_recording, store=store())


@st.cache_resource(max_entries=64, show_spinner="Scoring the frames")
def _best_frame(key: str, pair: Pair, *, _detections: DetectionSet) -> BestFrame:
    del key
    return select_best_frame(_detections.views, pair=pair)


@st.cache_resource(max_entries=64, show_spinner=False)
def _estimate(
    key: str, detections_key: str, preset: str, *, _recording: Recording, _detections: DetectionSet
) -> Estimate:
    del key, detections_key
    return estimate(_recording, detections=_detections.views, shape=SHAPE_PRESETS[preset])


@st.cache_resource(max_entries=24, show_spinner=False)
def _video(key: str, view: str, *, _recording: Recording) -> Video:
    del key
    if view not in _recording.views:
        raise NotFoundError(f"recording {_recording.id} has no video of {view}")
    return _recording.views[view].video()


@st.cache_resource(max_entries=48, show_spinner=False)
def _frame_image(key: str, view: str, frame: int, *, _recording: Recording) -> NDArray[np.uint8]:
    image = _video(key, view, _recording=_recording)[frame]
    image.flags.writeable = False
    return image


@st.cache_resource(max_entries=512, show_spinner=False)
def _frame_picture(
    key: str,
    detections_key: str,
    view: str,
    frame: int,
    centre_rule: CentreRule,
    *,
    _recording: Recording,
    _detections: DetectionSet,
) -> bytes:
    del detections_key
    image = _frame_image(key, view, frame, _recording=_recording)
    found = _detections.views.get(view)
    if found is not None and frame in found:
        image = draw_detections(image, found[frame], filter_detections(found[frame], centre_rule=centre_rule))
    return jpeg(image, width=PICTURE_WIDTH_PX)


@st.cache_resource(max_entries=64, show_spinner=False)
def _cameras(key: str, *, _recording: Recording) -> dict[str, Camera]:
    del key
    found = {}
    for name in METHOD_VIEWS:
        if name in _recording.views:
            with contextlib.suppress(CorsmalError):
                found[name] = _recording.views[name].camera()
    return found
