"""A dataset's folder on disk: which files belong to which recording, in the present layout or the older one."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.findings import Finding
from corsmal.dataset.layout import VIEWS, WORN_VIEW, Recording, View
from corsmal.dataset.older_layout import find_containers, scan_containers
from corsmal.dataset.places import (
    CALIBRATION_ENDINGS,
    DETECTIONS_ENDINGS,
    SOUND_ENDINGS,
    VIDEO_ENDINGS,
    Listing,
    files_by_id,
    folder_findings,
    listing,
    reason_against,
    shown_path,
)

Files = dict[str, dict[str, Path]]
"""By view, then by recording id."""

_PARTS = {
    "rgb": (("rgb", "video", "videos"), VIDEO_ENDINGS),
    "calib": (("calib", "calibration", "calibrations"), CALIBRATION_ENDINGS),
    "detections": (("detections", "detection"), DETECTIONS_ENDINGS),
}
"""What may be in a view's folder: the names of its folders, and the endings of its files."""

_SOUNDS = ("audio", "audios", "sound")
_TRUTHS, _ANNOTATIONS = "truth", ("annotation", "annotations")


@dataclass(frozen=True)
class Layout:
    """The files of a dataset folder by recording id, those of views by view first.

    Args:
        truths: those of synthetic recordings.
        top: names of the files in the folder itself.
        known: what file names say about recordings, in the older layout.
        findings: which files are not used, and why.
        is_older: whether it has the older layout, see ``older_layout``.
    """

    videos: Files
    calibrations: Files
    detections: Files
    sounds: dict[str, Path]
    truths: dict[str, Path] = field(default_factory=dict)
    top: tuple[str, ...] = ()
    known: Mapping[str, Annotation] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    is_older: bool = False

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
                self.is_older,
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
        sound, truth = self.sounds.get(name), self.truths.get(name)
        return Recording(name, views, sound, annotation, tuple(missing), truth, sound_end_s)

    def named_otherwise(self) -> list[tuple[str, Path]]:
        """Recordings and their files whose names are no ids as the present layout writes them: 3.mp4 of 000003."""
        of_views = (files for part in (self.videos, self.calibrations, self.detections) for files in part.values())
        all_files = (item for files in (*of_views, self.sounds) for item in files.items())
        return [] if self.is_older else [(name, path) for name, path in all_files if path.stem != name]

    def absent_parts(self) -> list[str]:
        """Sentences on what the whole set lacks."""
        fixed = [(view, number) for number, view in enumerate(VIEWS, start=1) if view != WORN_VIEW]
        parts = []
        for view, number in fixed:
            where = f"N/rgb/NAME_c{number}.mp4" if self.is_older else f"{view}/rgb/ID.mp4"
            parts.append((f"{view} videos", where, self.videos[view]))
        for view, number in fixed:
            where = f"N/calib/NAME_c{number}_calib.pickle" if self.is_older else f"{view}/calib/ID.pickle"
            if self.videos[view]:
                parts.append((f"{view} calibration", where, self.calibrations[view]))
        parts.append(("audio", "N/audio/NAME_audio.wav" if self.is_older else "audio/ID.wav", self.sounds))
        return [f"the whole set has no {part}: {where} is not there" for part, where, files in parts if not files]


def scan(root: Path) -> Layout:
    """List a dataset folder, one directory read per part; no file is opened.

    Raises:
        FileError: a folder cannot be read.
    """
    top = listing(root)
    if not any(top.folder(view) for view in VIEWS) and (containers := find_containers(top)):
        older = scan_containers(containers, root=root)
        videos, calibrations, detections = (older.files[part] for part in _PARTS)
        return Layout(
            videos,
            calibrations,
            detections,
            older.sounds,
            top=() if root in containers.values() else top.files,
            known=older.known,
            findings=tuple(older.findings),
            is_older=True,
        )
    return _present(top)


def has_layout(folder: Path) -> bool:
    """Whether a folder has parts of a dataset, by the names of its folders."""
    inside = listing(folder)
    return any(inside.folder(part) for part in (*VIEWS, *_SOUNDS)) or bool(find_containers(inside))


def is_part(folder: Path, *, of: Path) -> bool:
    """Whether a folder is that of a view or of sounds in another folder, or lies in one."""
    inside = listing(of)
    return any(path in (folder, folder.parent) for part in (*VIEWS, *_SOUNDS) if (path := inside.folder(part)))


def _present(top: Listing) -> Layout:
    root = top.path
    files: dict[str, Files] = {part: {view: {} for view in VIEWS} for part in _PARTS}
    findings = _stray(top, root=root)
    used: set[Path | None] = {top.folder(_TRUTHS), *(top.folder(name) for name in _ANNOTATIONS)}
    for view in VIEWS:
        folder = top.folder(view)
        if folder is None:
            continue
        used.add(folder)
        inside = _unpacked_twice(listing(folder), view)
        findings += _stray(inside, root=root)
        parts: set[Path | None] = set()
        for part, (names, endings) in _PARTS.items():
            if (path := inside.folder(*names)) is None:
                continue
            parts.add(path)
            found = files_by_id(listing(path), endings, root=root)
            files[part][view] = dict(found.by_id)
            findings += found.findings
            findings += _without_video(found.by_id, files["rgb"][view], root=root)
        findings += folder_findings({inside.path / name for name in inside.folders} - parts, root=root)
    sounds = truths = None
    if (audio := top.folder(*_SOUNDS)) is not None:
        used.add(audio)
        sounds = files_by_id(_unpacked_twice(listing(audio), audio.name), SOUND_ENDINGS, root=root)
        findings += sounds.findings
    if (truth := top.folder(_TRUTHS)) is not None:
        truths = files_by_id(listing(truth), (".json",), root=root)
    if used - {None, top.folder(_TRUTHS)}:
        findings += folder_findings({root / name for name in top.folders} - used, root=root)
    return Layout(
        files["rgb"],
        files["calib"],
        files["detections"],
        dict(sounds.by_id) if sounds else {},
        dict(truths.by_id) if truths else {},
        top.files,
        findings=tuple(findings),
    )


def _without_video(by_id: Mapping[str, Path], videos: Mapping[str, Path], *, root: Path) -> list[Finding]:
    """One finding on the files of a folder that belong to no video of the same view."""
    alone = [path for name, path in by_id.items() if name not in videos]
    if not alone:
        return []
    count = f"{len(alone)} files are" if len(alone) > 1 else "1 file is"
    what = f"{count} not used, because this view has no video of the recording: {alone[0].name}"
    return [Finding("note", "unused", what + (", …" if len(alone) > 1 else ""), shown_path(alone[0].parent, root))]


def _unpacked_twice(inside: Listing, name: str) -> Listing:
    """What an archive of ``view1`` gives that was unpacked in a folder of that name: the inner folder."""
    inner = inside.folder(name) if not inside.files and len(inside.folders) == 1 else None
    return inside if inner is None else listing(inner)


def _stray(inside: Listing, *, root: Path) -> list[Finding]:
    """Recordings' files that lie a level too high, and archives."""
    findings = []
    endings = {
        **dict.fromkeys(VIDEO_ENDINGS, "move it into a folder such as view1/rgb"),
        **dict.fromkeys(SOUND_ENDINGS, "move it into the folder audio"),
        **dict.fromkeys(CALIBRATION_ENDINGS, "move it into a folder such as view1/calib"),
    }
    for name in inside.files:
        stem, ending = os.path.splitext(name.lower())
        shown = shown_path(inside.path / name, root)
        if ending in endings:
            what = "lies where no recording is looked for and is not used"
            findings.append(Finding("warning", "unused", what, shown, advice=endings[ending]))
        elif (why := reason_against(stem, ending, ("",))) is not None and why[1]:
            findings.append(Finding("warning", "unused", f"{why[0]} and is not used", shown, advice=why[1]))
    return findings
