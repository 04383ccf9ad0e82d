"""The dataset's layout before its restructuring: a folder per container, with everything known in the files' names.

``N/rgb/sS_fiI_fuU_bB_lL_cC.mp4``, ``N/audio/…_audio.wav`` (or ``audios``) and ``N/calib/…_cC_calib.pickle``, N being
the container, S the scenario, I and U type and level of the filling, B and L background and light, C the camera: views
1 to 4. The recordings of containers 10 to 15 have a number instead, ``N/rgb/0012_c1.mp4``.
"""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from corsmal.dataset.annotation import CONTAINERS, DENSITIES_G_PER_ML, FILLINGS, LEVELS, Annotation
from corsmal.dataset.annotation_file import Annotations
from corsmal.dataset.findings import Finding
from corsmal.dataset.ids import recording_id
from corsmal.dataset.places import (
    CALIBRATION_ENDINGS,
    DETECTIONS_ENDINGS,
    SOUND_ENDINGS,
    VIDEO_ENDINGS,
    Listing,
    folder_findings,
    listing,
    shown_path,
)

_FACTS = re.compile(r"s(\d+)_fi(\d+)_fu(\d+)_b(\d+)_l(\d+)")
_CONTAINER = re.compile(r"0?[1-9]|1\d")
_OF_A_VIEW = {
    "rgb": (re.compile(r"(.+)_c([1-4])"), VIDEO_ENDINGS),
    "calib": (re.compile(r"(.+)_c([1-4])(?:_calib)?"), CALIBRATION_ENDINGS),
    "detections": (re.compile(r"(.+)_c([1-4])"), DETECTIONS_ENDINGS),
}
_SOUND = re.compile(r"(.+?)(?:_audio)?")
_OTHER_FORMS = ("depth", "ir", "imu")
"""Folders of what the method does not use."""

_CONTAINER_FACTS = ("width_top_mm", "width_bottom_mm", "height_mm", "depth_mm", "capacity_ml", "container_mass_g")
_CONFIGURATION = ("container_id", "scenario", "background", "illumination", "filling_type", "filling_level")


@dataclass
class OlderLayout:
    """The files of a folder of the older layout, by view and recording id.

    A recording's id is its container and its name, such as ``4_s0_fi2_fu1_b1_l1`` or ``10_0012``.
    """

    files: dict[str, dict[str, dict[str, Path]]] = field(
        default_factory=lambda: {part: {f"view{number}": {} for number in range(1, 5)} for part in _OF_A_VIEW}
    )
    sounds: dict[str, Path] = field(default_factory=dict)
    known: dict[str, Annotation] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)


def find_containers(root: Listing) -> dict[str, Path]:
    """The containers' folders by container, where a folder has the older layout; "" where its number is unknown."""
    if _has_older_names(root):
        return {str(int(root.path.name)) if _CONTAINER.fullmatch(root.path.name) else "": root.path}
    names = [name for name in root.folders if _CONTAINER.fullmatch(name)]
    return {str(int(name)): root.path / name for name in names if _has_older_names(listing(root.path / name))}


def scan_containers(containers: Mapping[str, Path], *, root: Path) -> OlderLayout:
    """List the containers' folders; no file is opened."""
    found = OlderLayout()
    for container, folder in sorted(containers.items(), key=lambda item: int(item[0] or 0)):
        inside = listing(folder)
        for part in _OF_A_VIEW:
            if (path := inside.folder(part)) is not None:
                _add_views(found, part, listing(path), container=container, root=root)
        if (path := inside.folder("audio", "audios")) is not None:
            for name, match in _matches(found, listing(path), _SOUND, SOUND_ENDINGS, root=root):
                _add(found, found.sounds, path / name, name=(container, match[1]), root=root)
        used = {inside.folder(name) for name in (*_OF_A_VIEW, "audio", "audios", *_OTHER_FORMS)}
        found.findings += folder_findings({folder / name for name in inside.folders} - used, root=root)
    return found


def known_by_names(known: Mapping[str, Annotation], annotations: Annotations) -> dict[str, Annotation]:
    """What the names say of recordings, completed by an annotation's row of that id or configuration, or by container.

    Args:
        known: from the names, by recording id.
        annotations: an annotation of this layout, of the published one, or of containers.
    """
    rows = list(annotations.by_id.values())
    by_configuration: dict[tuple[object, ...], list[Annotation]] = {}
    for row in rows:
        by_configuration.setdefault(tuple(getattr(row, name) for name in _CONFIGURATION), []).append(row)
    by_container = {row.container_id: row for row in reversed(rows) if row.capacity_ml is not None}
    completed = {}
    for name, facts in known.items():
        same = by_configuration.get(tuple(getattr(facts, each) for each in _CONFIGURATION), [])
        other = annotations.by_id.get(name) or (same[0] if len(same) == 1 and facts.scenario is not None else None)
        if other is None and facts.container_id is not None:
            container = annotations.by_container.get(facts.container_id) or by_container.get(facts.container_id)
            other = container and Annotation(**{each: getattr(container, each) for each in _CONTAINER_FACTS})
        given = {} if other is None else {key: value for key, value in asdict(other).items() if value is not None}
        completed[name] = replace(facts, **given)
    return completed


def _has_older_names(folder: Listing) -> bool:
    """Whether a folder is that of a container in the older layout."""
    rgb = folder.folder("rgb")
    names = [] if rgb is None else listing(rgb).files
    pattern, endings = _OF_A_VIEW["rgb"]
    if any(pattern.fullmatch(os.path.splitext(name)[0].lower()) and _has_ending(name, endings) for name in names):
        return True
    sounds = folder.folder("audio", "audios")
    stems = [] if sounds is None else [os.path.splitext(name.lower())[0] for name in listing(sounds).files]
    return any(_FACTS.match(stem) or stem.endswith("_audio") for stem in stems)


def _add_views(found: OlderLayout, part: str, inside: Listing, *, container: str, root: Path) -> None:
    pattern, endings = _OF_A_VIEW[part]
    for name, match in _matches(found, inside, pattern, endings, root=root):
        files = found.files[part][f"view{match[2]}"]
        _add(found, files, inside.path / name, name=(container, match[1]), root=root)


def _matches(
    found: OlderLayout, inside: Listing, pattern: re.Pattern[str], endings: Sequence[str], *, root: Path
) -> list[tuple[str, re.Match[str]]]:
    """The files of a folder whose names are of the layout; findings on the others."""
    used = []
    for name in sorted(inside.files, key=lambda name: _order(name, endings)):
        stem = os.path.splitext(name)[0].lower()
        match = pattern.fullmatch(stem) if _has_ending(name, endings) else None
        if match is not None and recording_id(match[1]) is not None:
            used.append((name, match))
        else:
            what = f"is none of the older layout's names, such as s0_fi2_fu1_b1_l1_c1{endings[0]}; not used"
            found.findings.append(Finding("warning", "unused", what, f"{shown_path(inside.path, root)}/{name}"))
    return used


def _add(found: OlderLayout, files: dict[str, Path], path: Path, *, name: tuple[str, str], root: Path) -> None:
    container, stem = name
    recording = f"{container}_{stem}" if container else str(recording_id(stem))
    if recording in files:
        what = f"is not used: {files[recording].name} is the one used for recording {recording}"
        advice = "remove or rename one of the two"
        found.findings.append(Finding("warning", "unused", what, shown_path(path, root), recording, advice))
        return
    files[recording] = path
    if recording not in found.known:
        found.known[recording] = _facts(int(container) if container else None, _FACTS.fullmatch(stem))


def _facts(container_id: int | None, match: re.Match[str] | None) -> Annotation:
    container, kind = CONTAINERS.get(container_id or 0, (None, None))
    if match is None:
        return Annotation(container_id=container_id, container=container, kind=kind)
    scenario, filling, level, background, light = (int(value) for value in match.groups())
    return Annotation(
        container_id=container_id,
        container=container,
        kind=kind,
        scenario=scenario,
        background=background,
        illumination=light,
        filling_type=filling if filling < len(FILLINGS) else None,
        filling_level=level if level < len(LEVELS) else None,
        filling_density_g_per_ml=DENSITIES_G_PER_ML[filling] if filling < len(FILLINGS) else None,
    )


def _has_ending(name: str, endings: Sequence[str]) -> bool:
    return os.path.splitext(name)[1].lower() in endings


def _order(name: str, endings: Sequence[str]) -> tuple[int, str]:
    ending = os.path.splitext(name)[1].lower()
    return endings.index(ending) if ending in endings else len(endings), name
