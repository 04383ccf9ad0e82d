"""Recordings and their views: the files of each, opened when they are asked for."""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.audio import Audio, read_audio
from corsmal.dataset.calibration import Calibration, read_calibration
from corsmal.dataset.clock import FrameClock, Matching, recording_clock
from corsmal.digests import file_fingerprint
from corsmal.errors import FileError, NotFoundError, check_choice
from corsmal.geometry import Camera
from corsmal.notebook import record_html

if TYPE_CHECKING:
    from corsmal.dataset.video import Video

VIEWS = ("view1", "view2", "view3", "view4")
"""Names of the views: left of the robot, right of it, on it, and worn by the person."""

CAMERAS_KEPT = 64
"""A recording's cameras are read once per fitted frame."""

Masks = Literal["detected", "by-hand"]
"""Which masks are used: those that were detected, or those by hand in the frames that have them."""

MASK_NAMES: dict[Masks, str] = {"detected": "detected", "by-hand": "by hand where present"}
"""What they are called."""

WORN_VIEW = "view4"
"""The view that the method does not use: the camera moves, and its absence is nothing that lacks."""


@dataclass(frozen=True)
class View:
    """One camera's part of a recording.

    Args:
        name: ``view1`` to ``view4``.
        detections_path: detections made elsewhere (COCO results), where there are any.
        is_older: whether the file lies in the dataset's older layout, see ``older_layout``.
    """

    name: str
    video_path: Path
    calibration_path: Path | None = None
    detections_path: Path | None = None
    is_older: bool = False

    def video(self) -> "Video":
        """Open the video.

        Returns:
            The video; close it, or use it in a ``with`` statement.

        Raises:
            FileError: the video is truncated, holds no frames, or is no video.
        """
        from corsmal.dataset.video import Video  # noqa: PLC0415 - who lists a dataset need not load the video library

        return Video(self.video_path)

    def camera(self) -> Camera:
        """The calibrated camera; raises what ``calibration`` raises."""
        return self.calibration().camera

    def calibration(self) -> Calibration:
        """Read the calibrated camera, scaled to the size of this view's video.

        Raises:
            FileError: the calibration is absent, broken, has no extrinsics (as view4's), or the video is unreadable.
        """
        if self.calibration_path is None:
            ending = "_calib.pickle" if self.is_older else ".pickle"
            expected = self.video_path.parent.parent / "calib" / f"{self.video_path.stem}{ending}"
            raise FileError(expected, f"the calibration of {self.name} is missing; download it to use this view in 3D")
        paths = self.calibration_path, self.video_path
        return _calibration(*paths, tuple(file_fingerprint(path) for path in paths if path.is_file()))


@lru_cache(maxsize=CAMERAS_KEPT)
def _calibration(calibration_path: Path, video_path: Path, _fingerprints: tuple[str, ...]) -> Calibration:
    """The calibration for a video, read again when one of the two files changes."""
    from corsmal.dataset.video import video_size  # noqa: PLC0415 - as above

    found = read_calibration(calibration_path)
    size = video_size(video_path)
    return found if size == found.camera.size else replace(found, camera=found.camera.scaled(size))


@dataclass(frozen=True)
class Recording:
    """One person handling one container, with what there is of it.

    Args:
        id: the recording's name, six digits in the published sets.
        views: the views that have a video, by name.
        audio_path: the sound, WAV or else FLAC, where there is one.
        annotation: what is known about it, where anything is.
        missing: what it lacks, such as ``view2 video`` or ``audio``. A calibration lacks only where its video exists.
        truth_path: what was drawn and played, as JSON; None where that is not there.
        sound_end_s: where its sound is cut, in seconds from the start, see ``published.cut_s``; None: used whole.
        matching: how the frames of its views are matched.
        masks: which masks are used of it, see ``Masks``.
        is_annotated_synthetic: whether the annotation says that the recording was rendered.
    """

    id: str
    views: dict[str, View] = field(default_factory=dict)
    audio_path: Path | None = None
    annotation: Annotation | None = None
    missing: tuple[str, ...] = ()
    truth_path: Path | None = None
    sound_end_s: float | None = None
    matching: Matching = field(default_factory=Matching)
    masks: Masks = "detected"
    is_annotated_synthetic: bool = False

    def __post_init__(self) -> None:
        check_choice("masks", self.masks, get_args(Masks))

    @property
    def is_synthetic(self) -> bool:
        """Whether the recording was rendered: its truth is there, or the annotation says so."""
        return self.truth_path is not None or self.is_annotated_synthetic

    def _repr_html_(self) -> str:
        """What a notebook shows: what there is of it, and what is known about it."""
        facts = {
            "views": ", ".join(self.views) or "none",
            "detections beside the videos": ", ".join(
                name for name, view in self.views.items() if view.detections_path is not None
            ),
            "sound": "" if self.audio_path is None else self.audio_path.name,
            "missing": ", ".join(self.missing),
            "rendered": "yes" if self.is_synthetic else "",
            **({} if self.annotation is None else self.annotation.facts()),
        }
        return record_html(f"Recording {self.id}", facts)

    def clock(self) -> FrameClock:
        """When its frames are shown, and which frame of each view belongs to which of the recording's."""
        return recording_clock(self.views, self.matching)

    def video(self, view: str) -> "Video":
        """A view's video by the recording's frames; as ``View.video``, but for views that are matched by time."""
        from corsmal.dataset.matched_video import MatchedVideo  # noqa: PLC0415 - as above

        nearest = self.clock().nearest.get(view)
        return self.views[view].video() if nearest is None else MatchedVideo(self.views[view].video_path, nearest)

    def audio(self) -> Audio:
        """Read the sound, up to ``sound_end_s``.

        Raises:
            NotFoundError: the recording has no sound file.
            FileError: the file is broken or has another number of channels.
        """
        if self.audio_path is None:
            raise NotFoundError(f"recording {self.id} has no sound: audio/{self.id}.wav is missing")
        return read_audio(self.audio_path, end_s=self.sound_end_s)
