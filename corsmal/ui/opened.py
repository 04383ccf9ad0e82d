"""A recording as the pages hold it: opened once per run of a page, or of a part of it, and handed down."""

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property

import numpy as np
import streamlit as st
from numpy.typing import NDArray

from corsmal.dataset import Recording, Video
from corsmal.detection import ViewDetections
from corsmal.digests import digest, file_fingerprint
from corsmal.errors import CorsmalError, NotFoundError
from corsmal.estimation import Estimate, Fit, RecordingMasks, TrainingMeans, choose_frames, counted_frames, fit_masks
from corsmal.figures import jpeg
from corsmal.geometry import Camera
from corsmal.parameters import METHOD_VIEWS, CentreRule, Pair, SelectionParameters, ShapeParameters
from corsmal.selection import BestFrame
from corsmal.shape import Agreement, KnownProfile, agreement, silhouettes
from corsmal.stages.by_hand import amodal_by_hand
from corsmal.stages.detections import DetectionSet, detections_origin, load_detections
from corsmal.stages.estimates import Predictors
from corsmal.stages.fits import load_fit
from corsmal.stages.known_profiles import known_profile
from corsmal.stages.moments import kept_estimate
from corsmal.stages.true_masks import true_masks
from corsmal.ui import shared
from corsmal.ui.caching import by_key, cached
from corsmal.ui.messages import guarded
from corsmal.ui.playback import with_detections

PICTURE_WIDTH_PX = 960
"""Frames that are pinned, or shown by themselves, are this wide at most."""


def fingerprint(recording: Recording) -> str:
    """A digest of a recording's files and clock: what is cached for it is not used once one of them changed."""
    paths = [path for view in recording.views.values() for path in (view.video_path, view.calibration_path)]
    paths += [recording.audio_path, *(view.detections_path for view in recording.views.values())]
    return digest(
        "recording",
        recording.id,
        recording.matching,
        recording.masks,
        [file_fingerprint(path) for path in paths if path is not None],
    )


def by_detections(opened: "OpenedRecording", *others: object, **options: object) -> tuple[object, ...]:
    """Results that depend on the detections and on the rules of selection, too."""
    return opened.detections.key, opened.selection, by_key(opened, *others, **options)


class OpenedRecording:
    """A recording with its files as they are now; its parts are read when they are needed, at most once.

    Args:
        recording: the recording.
        selection: how its detections are filtered and its frames are scored; default: as the paper says.

    Attributes:
        key: see ``fingerprint``.
    """

    def __init__(self, recording: Recording, selection: SelectionParameters | None = None) -> None:
        self.recording = recording
        self.selection = selection or SelectionParameters()
        self.key = fingerprint(recording)

    @property
    def id(self) -> str:
        """The recording's id."""
        return self.recording.id

    @property
    def job_key(self) -> str:
        """The key of the job that detects in the recording."""
        return f"detect {self.key}"

    @property
    def frame_job_key(self) -> str:
        """The key of the job that inspects one frame of the recording."""
        return f"{self.job_key}, one frame"

    @cached_property
    def detections(self) -> DetectionSet:
        """Files beside the videos, else what the store holds; read again when one of these files has changed."""
        return self._detections(detections_origin(self.recording, store=shared.store()))

    @cached(32, spinner="Reading the detections")
    def _detections(self, origin: str) -> DetectionSet:
        del origin
        return load_detections(self.recording, store=shared.store())

    @cached_property
    def _source(self) -> RecordingMasks:
        return RecordingMasks(self.recording, self.detections.views, self.selection)

    @cached_property
    def counted(self) -> tuple[int, ...] | None:
        """The frames that count for selection; None: all."""
        return counted_frames(self.recording, self.selection)

    @cached(64, key=by_detections, spinner="Scoring the frames")
    def best_frame(self, pair: Pair, shape: ShapeParameters) -> BestFrame:
        """The best frame of a pair, with all scores, by the rule with which ``shape`` chooses the container."""
        views = self.detections.views
        return choose_frames(views, pair=pair, shape=shape, selection=self.selection, counted=self.counted)[0]

    @cached(64, key=by_detections)
    def estimate(self, shape: ShapeParameters, means: TrainingMeans | None = None) -> Estimate:
        """The geometry of the recording, without networks; ``means`` stand in where nothing fits."""
        predictors = Predictors(shape, means, selection=self.selection)
        return kept_estimate(self.recording, self.detections, predictors, store=shared.store(), source=self)

    @cached(24)
    def video(self, view: str) -> Video:
        """A view's video; this and what is read from it raises a ``CorsmalError`` where it cannot be read."""
        if view not in self.recording.views:
            raise NotFoundError(f"recording {self.id} has no video of {view}")
        return self.recording.video(view)

    @property
    def frames(self) -> int:
        """The number of frames of the longest readable view, at least 1; problems are reported where it is shown."""
        counts = [1]
        for view in self.recording.views:
            with suppress(CorsmalError):
                counts.append(self.video(view).frame_count)
        return max(counts)

    @property
    def fps(self) -> float:
        """Frames per second of the recording, see ``FrameClock``; 0 where it is not known."""
        clock = self.recording.clock()
        if clock.frames:
            return clock.fps
        for view in ("view3", "view1", "view2", "view4"):
            with suppress(CorsmalError):
                return self.video(view).fps
        return 0.0

    @property
    def seconds_per_frame(self) -> float | None:
        """For an axis in seconds on which the time line's playhead is marked."""
        return 1 / self.fps if self.fps else None

    @cached(48)
    def image(self, view: str, frame: int) -> NDArray[np.uint8]:
        """One frame, (H, W, 3) uint8 RGB, read only."""
        image = self.video(view)[frame]
        image.flags.writeable = False
        return image

    @cached(512, key=by_detections)
    def picture(self, view: str, frame: int, centre_rule: CentreRule) -> bytes:
        """One frame as JPEG, with its detections drawn on it where there are any."""
        image, found = self.image(view, frame), self.detections.views.get(view)
        drawn = with_detections(image, found, frame, centre_rule=centre_rule, selection=self.selection)
        return jpeg(drawn, width=PICTURE_WIDTH_PX)

    @cached(16, key=by_detections)
    def mask(self, view: str, frame: int, centre_rule: CentreRule) -> NDArray[np.bool_]:
        """See ``corsmal.estimation.MaskSource``; read only."""
        mask = self._source.mask(view, frame, centre_rule)
        mask.flags.writeable = False
        return mask

    @cached(64)
    def camera(self, view: str) -> Camera:
        """See ``corsmal.estimation.MaskSource``."""
        return self._source.camera(view)

    @property
    def cameras(self) -> dict[str, Camera]:
        """The fixed cameras whose calibration can be read, by view."""
        found = {}
        for view in METHOD_VIEWS:
            with suppress(CorsmalError):
                found[view] = self.camera(view)
        return found

    def true_mask(self, view: str, frame: int) -> NDArray[np.bool_] | None:
        """The container's whole (H, W) silhouette in one frame of a view, as it was rendered or drawn by hand, or None.

        Raises:
            FileError: the recording is synthetic, and its truth is broken.
        """
        try:
            found = self._true_masks(view)[frame]
        except (NotFoundError, KeyError):
            return amodal_by_hand(self.recording, view, frame, store=shared.store())
        return found.mask(0) if len(found) else np.zeros(found.size, dtype=bool)

    @cached(8)
    def _true_masks(self, view: str) -> ViewDetections:
        return true_masks(self.recording, view, kind="amodal")

    @cached(16)
    def known_profile(self, frame: int) -> KnownProfile | None:
        """See ``corsmal.stages.known_profiles.known_profile``."""
        return known_profile(self.recording, frame)

    def is_inspected(self, pair: Pair, frame: int) -> bool:
        """Whether a detector has inspected the frame in both views, or a file says what is in it."""
        return all(frame in self.detections.views.get(name, ()) for name in pair)

    def agreements(self, fit: Fit, centre_rule: CentreRule) -> dict[str, Agreement]:
        """How the silhouettes of a fit's hull agree with the masks, by view of its pair; none where nothing fitted."""
        if not fit.hull.ok or fit.frame is None:
            return {}
        seen = silhouettes(fit.hull, [self.camera(name) for name in fit.pair])
        masks = [self.mask(name, fit.frame, centre_rule) for name in fit.pair]
        return {name: agreement(*each) for name, *each in zip(fit.pair, seen, masks, strict=True)}

    def fit(self, best: BestFrame, frame: int, shape: ShapeParameters, *, is_settled: bool = True) -> Fit:
        """The hull of a pair in one frame; nothing is kept of one that was fitted while something is dragged."""
        if is_settled:
            return self._kept_fit(best.pair, frame, best.centre_rule, shape)
        return fit_masks(self, pair=best.pair, frame=frame, centre_rule=best.centre_rule, shape=shape)

    @cached(64, key=by_detections)
    def _kept_fit(self, pair: Pair, frame: int, centre_rule: CentreRule, shape: ShapeParameters) -> Fit:
        return load_fit(
            self.recording,
            self.detections,
            pair=pair,
            frame=frame,
            centre_rule=centre_rule,
            shape=shape,
            selection=self.selection,
            store=shared.store(),
            source=self,
        )


def show_panel(panel: Callable[[OpenedRecording], object], opened: OpenedRecording) -> None:
    """Show a part of a page that also runs by itself, for the recording as it is then.

    Args:
        panel: draws the part; an error of the library ends it with its sentence.
        opened: the recording of the page's own run.
    """
    of_page = [opened]

    @st.fragment
    @guarded()
    def run() -> None:
        panel(of_page.pop() if of_page else OpenedRecording(opened.recording, opened.selection))

    run()
