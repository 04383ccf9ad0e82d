"""The dataset's layout on disk: which files belong to which recording."""

import os
from collections import defaultdict
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.audio import Audio, read_audio
from corsmal.dataset.calibration import read_camera
from corsmal.dataset.ids import ID_PATTERN
from corsmal.digests import file_fingerprint
from corsmal.errors import FileError, NotFoundError
from corsmal.geometry import Camera

if TYPE_CHECKING:
    from corsmal.dataset.video import Video

VIEWS = ("view1", "view2", "view3", "view4")
"""Names of the views: left of the robot, right of it, on it, and worn by the person."""

CAMERAS_KEPT = 64
"""A recording's cameras are read once per fitted frame."""

WORN_VIEW = "view4"
"""The view that the method does not use: the camera moves, and its absence is nothing that lacks."""


@dataclass(frozen=True)
class View:
    """One camera's part of a recording.

    Args:
        name: ``view1`` to ``view4``.
        detections_path: detections made elsewhere (COCO results), where there are any.
    """

    name: str
    video_path: Path
    calibration_path: Path | None = None
    detections_path: Path | None = None

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
        """Read the calibrated camera, scaled to the size of this view's video.

        Raises:
            FileError: the calibration is absent, broken, has no extrinsics (as view4's), or the video is unreadable.
        """
        if self.calibration_path is None:
            expected = self.video_path.parent.parent / "calib" / f"{self.video_path.stem}.pickle"
            raise FileError(expected, f"the calibration of {self.name} is missing; download it to use this view in 3D")
        paths = self.calibration_path, self.video_path
        return _camera(*paths, tuple(file_fingerprint(path) for path in paths if path.is_file()))


@lru_cache(maxsize=CAMERAS_KEPT)
def _camera(calibration_path: Path, video_path: Path, _fingerprints: tuple[str, ...]) -> Camera:
    """The camera of two files, read again when one of them changes."""
    from corsmal.dataset.video import video_size  # noqa: PLC0415 - as above

    camera = read_camera(calibration_path)
    size = video_size(video_path)
    return camera if size == camera.size else camera.scaled(size)


@dataclass(frozen=True)
class Recording:
    """One person handling one container, with what there is of it.

    Args:
        id: the recording's name, six digits in the published sets.
        views: the views that have a video, by name.
        audio_path: the sound, WAV or else FLAC, where there is one.
        annotation: what is known about it, where anything is.
        missing: what it lacks, such as ``view2 video`` or ``audio``. A calibration lacks only where its video exists.
        truth_path: what was drawn and played, as JSON; None where the recording is not synthetic.
        sound_end_s: where its sound is cut, in seconds from the start, see ``published.cut_s``; None: used whole.
    """

    id: str
    views: dict[str, View] = field(default_factory=dict)
    audio_path: Path | None = None
    annotation: Annotation | None = None
    missing: tuple[str, ...] = ()
    truth_path: Path | None = None
    sound_end_s: float | None = None

    @property
    def is_synthetic(self) -> bool:
        """Whether the recording was rendered: its truth is known."""
        return self.truth_path is not None

    def audio(self) -> Audio:
        """Read the sound, up to ``sound_end_s``.

        Raises:
            NotFoundError: the recording has no sound file.
            FileError: the file is broken or has another number of channels.
        """
        if self.audio_path is None:
            raise NotFoundError(f"recording {self.id} has no sound: audio/{self.id}.wav is missing")
        return read_audio(self.audio_path, end_s=self.sound_end_s)


@dataclass(frozen=True)
class Layout:
    """The files of a dataset folder by recording id, those of views by view first.

    ``truths`` are those of synthetic recordings, ``top`` the names of the files in the folder itself.
    """

    videos: dict[str, dict[str, Path]]
    calibrations: dict[str, dict[str, Path]]
    detections: dict[str, dict[str, Path]]
    sounds: dict[str, Path]
    truths: dict[str, Path]
    top: tuple[str, ...]

    @property
    def ids(self) -> set[str]:
        """Ids of the recordings that have a video or a sound."""
        return set(self.sounds).union(*self.videos.values())

    def recording(self, name: str, annotation: Annotation | None, *, sound_end_s: float | None = None) -> Recording:
        """Gather one recording's files and name what is missing."""
        views = {
            view: View(
                view,
                self.videos[view][name],
                self.calibrations[view].get(name),
                self.detections[view].get(name),
            )
            for view in VIEWS
            if name in self.videos[view]
        }
        missing = []
        for view in VIEWS:
            if view != WORN_VIEW and view not in views:
                missing.append(f"{view} video")
            elif view != WORN_VIEW and views[view].calibration_path is None:
                missing.append(f"{view} calibration")
        missing += [] if name in self.sounds else ["audio"]
        missing += [] if annotation else ["annotation"]
        return Recording(
            name,
            views,
            self.sounds.get(name),
            annotation,
            tuple(missing),
            self.truths.get(name),
            sound_end_s,
        )

    def absent_parts(self) -> list[str]:
        """Sentences on what the whole set lacks."""
        parts = [(f"{view} videos", f"{view}/rgb/ID.mp4", self.videos[view]) for view in VIEWS if view != WORN_VIEW]
        parts += [
            (f"{view} calibration", f"{view}/calib/ID.pickle", self.calibrations[view])
            for view in VIEWS
            if view != WORN_VIEW and self.videos[view]
        ]
        parts.append(("audio", "audio/ID.wav", self.sounds))
        return [f"the whole set has no {part}: {where} is not there" for part, where, files in parts if not files]


def scan(root: Path) -> Layout:
    """List a dataset folder, one directory read per part; no file is opened.

    Raises:
        FileError: a folder cannot be read.
    """
    found: dict[str, dict[str, dict[str, Path]]] = defaultdict(dict)
    for view in VIEWS:
        for part, suffix in (("rgb", ".mp4"), ("calib", ".pickle"), ("detections", ".json")):
            found[part][view] = _files_by_id(root / view / part, suffix)
    sounds = _files_by_id(root / "audio", ".flac") | _files_by_id(root / "audio", ".wav")
    truths = _files_by_id(root / "truth", ".json")
    return Layout(found["rgb"], found["calib"], found["detections"], sounds, truths, tuple(sorted(_names(root))))


def _files_by_id(folder: Path, suffix: str) -> dict[str, Path]:
    """The folder's files with that ending, by recording id."""
    stems = {
        name[: -len(suffix)]: folder / name
        for name in _names(folder)
        if name.lower().endswith(suffix) and ID_PATTERN.fullmatch(name[: -len(suffix)])
    }
    return dict(sorted(stems.items()))


def _names(folder: Path) -> list[str]:
    """Names of the folder's visible files; none where there is no folder."""
    try:
        with os.scandir(folder) as entries:
            return [entry.name for entry in entries if not entry.name.startswith(".") and entry.is_file()]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as error:
        raise FileError(folder, f"the folder cannot be read ({error.strerror})") from error
