"""Files and folders as they lie on disk: which is used for which recording, and why the others are not."""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from corsmal.dataset.findings import Finding
from corsmal.dataset.ids import recording_id
from corsmal.errors import FileError

VIDEO_ENDINGS = (".mp4", ".mov", ".mkv", ".avi", ".m4v", ".webm", ".mpg", ".mpeg")
SOUND_ENDINGS = (".wav", ".flac")
CALIBRATION_ENDINGS = (".pickle", ".pkl")
DETECTIONS_ENDINGS = (".json",)
"""Endings of the files that are read, in the order in which one is preferred."""

_COPY = re.compile(
    r"(.+?)(?: ?\(\d+\)| [-\u2013] (?:copy|kopie|copie|copia)(?: ?\(\d+\))?| copy(?: \d+)?)|(\d+)(?: \d+|[_-]copy\d*)"
    r"|(?:copy of|kopie von) (.+)",
    re.IGNORECASE,
)
"""What browsers and file managers call another copy of a file."""

_WORD = re.compile(r"(?:view|camera|cam|c)\d|rgb|colou?r|video|audio|sound|calib(?:ration)?|detections?", re.IGNORECASE)
"""What stands beside the number in a file's name where people collect the files of all views in one folder."""

_OF_SYSTEMS = {"thumbs.db", "desktop.ini"}

_REASONS: Mapping[tuple[str, ...], tuple[str, str]] = {
    (".part", ".crdownload", ".download", ".partial", ".tmp", ".!ut"): (
        "is an unfinished download",
        "finish the download",
    ),
    (".zip", ".tar", ".gz", ".tgz", ".7z", ".rar", ".bz2", ".xz"): ("is an archive", "unpack it here"),
    (".mp3", ".m4a", ".aac", ".ogg", ".opus", ".wma", ".aif", ".aiff"): (
        "is sound in a form that is not read",
        "convert it to WAV or FLAC with its eight channels",
    ),
    (".wmv", ".flv", ".3gp", ".mts", ".ts", ".h264", ".h265", ".hevc"): (
        "is video in a form that is not read",
        "convert it to MP4",
    ),
}
"""Why files with certain endings are not used, and what to do."""


@dataclass(frozen=True)
class Listing:
    """What lies in a folder.

    Args:
        path: the folder.
        files: names of its visible files.
        folders: names of its visible folders.
        hidden: names of hidden files that look like recordings' files.
        broken: names of what is neither: links that lead nowhere, pipes.
    """

    path: Path
    files: tuple[str, ...] = ()
    folders: tuple[str, ...] = ()
    hidden: tuple[str, ...] = ()
    broken: tuple[str, ...] = ()

    def folder(self, *names: str) -> Path | None:
        """The first folder of one of some names, whatever its case, spaces, underscores and hyphens."""
        keys = {_folder_key(name): place for place, name in enumerate(names)}
        found = [name for name in self.folders if _folder_key(name) in keys]
        found.sort(key=lambda name: (keys[_folder_key(name)], name not in names, name))
        return self.path / found[0] if found else None


def listing(folder: Path) -> Listing:
    """List a folder; where there is none the listing is empty.

    Raises:
        FileError: the folder cannot be read.
    """
    files, folders, hidden, broken = [], [], [], []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                is_file, is_folder = _kind(entry)
                if entry.name.startswith(".") or entry.name.lower() in _OF_SYSTEMS:
                    hidden += [entry.name] if is_file else []
                elif is_file:
                    files.append(entry.name)
                elif is_folder:
                    folders.append(entry.name)
                else:
                    broken.append(entry.name)
    except (FileNotFoundError, NotADirectoryError):
        return Listing(folder)
    except OSError as error:
        raise FileError(folder, f"the folder cannot be read ({error.strerror})") from error
    return Listing(folder, *(tuple(sorted(names)) for names in (files, folders, hidden, broken)))


@dataclass(frozen=True)
class Found:
    """The files of one folder.

    Args:
        by_id: the file used for each recording.
        findings: those that are not used, with the reason.
    """

    by_id: Mapping[str, Path]
    findings: tuple[Finding, ...] = ()


def _kind(entry: os.DirEntry[str]) -> tuple[bool, bool]:
    """Whether an entry of a folder is, or leads to, a file or a folder; a link in a circle is neither."""
    try:
        return entry.is_file(), entry.is_dir()
    except OSError:
        return False, False


def files_by_id(inside: Listing, endings: Sequence[str], *, root: Path) -> Found:
    """The files of a folder by recording id: one each, and why the others are not used.

    Args:
        inside: the folder's content.
        endings: of the files that are wanted, the preferred first.
        root: the dataset's folder, from which findings name files.
    """
    of_id: dict[str, list[str]] = {}
    findings = []
    folder = shown_path(inside.path, root)
    for name in inside.files:
        stem, ending = os.path.splitext(name)
        original = _original(stem) if ending.lower() in endings else None
        if original is not None:
            what = f"is named like a copy of {original} and is not used"
            advice = f"rename it to {original}{ending} if it is the one to use"
            findings.append(Finding("warning", "unused", what, f"{folder}/{name}", original, advice))
        elif (why := reason_against(stem, ending.lower(), endings)) is None:
            of_id.setdefault(str(_file_id(stem)), []).append(name)
        else:
            findings.append(
                Finding("warning", "unused", f"{why[0]} and is not used", f"{folder}/{name}", advice=why[1])
            )
    findings += folder_findings((inside.path / name for name in inside.folders), root=root)
    for name in inside.broken:
        what = "is a link that leads nowhere" if (inside.path / name).is_symlink() else "is no file and is not used"
        findings.append(Finding("warning", "unused", what, f"{folder}/{name}"))
    if inside.hidden:
        findings.append(_on_hidden(inside, folder))
    by_id = {}
    for recording, names in sorted(of_id.items()):
        used, *others = sorted(names, key=lambda name: _rank(name, recording, endings))
        by_id[recording] = inside.path / used
        for other in others:
            what = f"is not used: {used} is the one used for recording {recording}"
            advice = "remove or rename one of the two"
            findings.append(Finding("warning", "unused", what, f"{folder}/{other}", recording, advice))
    return Found(by_id, tuple(findings))


def file_of(folder: Path, recording: str, ending: str) -> Path:
    """A recording's file in a folder: ``000618.npy``, or where that is missing a file such as ``618.npy``."""
    path = folder / f"{recording}{ending}"
    if path.is_file():
        return path
    others = (folder / name for name in listing(folder).files if name.lower().endswith(ending))
    return next((other for other in others if _file_id(other.stem) == recording), path)


def shown_path(path: Path, root: Path) -> str:
    """A path as findings name it: from the dataset's folder, unless it lies far from it."""
    if path.is_relative_to(root.parent):
        return Path(os.path.relpath(path, root)).as_posix()
    return str(path)


def folder_findings(folders: Iterable[Path], *, root: Path) -> list[Finding]:
    """Findings that folders are not used."""
    return [
        Finding("note", "unused", "this folder is not used", file=shown_path(path, root)) for path in sorted(folders)
    ]


def reason_against(stem: str, ending: str, endings: Sequence[str]) -> tuple[str, str] | None:
    """Why a file is not used, and what to do; None where it is."""
    if ending not in endings:
        known = (reason for others, reason in _REASONS.items() if ending in others)
        return next(known, (f"is none of the files that belong here ({', '.join(endings[:4])})", ""))
    if _file_id(stem) is None:
        return "has no name that can be a recording's id", "use letters, digits, _ and -, such as 000618"
    return None


def _original(stem: str) -> str | None:
    """The id of the recording whose copy a file is named like; None where it is not."""
    copy = _COPY.fullmatch(stem.strip())
    return None if copy is None else _file_id(copy[1] or copy[2] or copy[3])


def _file_id(stem: str) -> str | None:
    """The id of the recording that a file is of: its name, or the number in a name such as ``view1_000003_rgb``."""
    words = re.split(r"[ _-]+", stem.strip())
    others = [word for word in words if not _WORD.fullmatch(word)]
    is_number = len(others) == 1 and others[0].isascii() and others[0].isdecimal()
    return recording_id(others[0] if is_number else stem)


def _rank(name: str, recording: str, endings: Sequence[str]) -> tuple[bool, int, bool, str]:
    """The file whose name is the id itself is preferred, then the ending, then small letters."""
    stem, ending = os.path.splitext(name)
    return stem != recording, endings.index(ending.lower()), ending != ending.lower(), name


def _on_hidden(inside: Listing, folder: str) -> Finding:
    more = f" and {len(inside.hidden) - 1} more" if len(inside.hidden) > 1 else ""
    what = f"hidden files are not used: {inside.hidden[0]}{more}"
    return Finding("note", "unused", what, file=folder)


@lru_cache(maxsize=256)
def _folder_key(name: str) -> str:
    return re.sub(r"[ _-]+", "", name.casefold())
