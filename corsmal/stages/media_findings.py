"""What a check of one recording's files finds: calibrations, detections, and how they were read."""

import math
from collections.abc import Mapping

from corsmal.dataset import Recording, View
from corsmal.dataset.audio import check_audio
from corsmal.dataset.calibration import CALIBRATED_SIZE
from corsmal.dataset.findings import Finding, Severity
from corsmal.dataset.video import video_size
from corsmal.dataset.video_file import file_turn, frames_beyond_end
from corsmal.estimation.plausibility import CAMERA_M
from corsmal.estimation.view_offsets import corrected, find_offsets
from corsmal.notes import Note
from corsmal.selection import FrameDetections

SHAPE_TOLERANCE = 0.05
"""Of the pictures' width by height."""


def calibration_findings(view: View) -> list[Finding]:
    """How a view's calibration was read where that was not as expected, and a camera that stands at no likely place.

    Raises:
        FileError: the calibration cannot be used.
    """
    if view.calibration_path is None:
        return []
    found, file = view.calibration(), str(view.calibration_path)
    findings = [Finding(_severity(note), "calibration", note, file=file) for note in found.notes]
    distance_m = math.hypot(*found.camera.translation)
    low, high = CAMERA_M
    if not low <= distance_m <= high:
        place = f"{distance_m:.3g} m from the world's origin, expected {low:g} to {high:g} m"
        what = f"the camera of {view.name} stands {place}"
        findings.append(Finding("warning", "calibration", what, file=file, advice="check the unit of 'tvec', metres"))
    return findings


def sound_findings(recording: Recording, *, deep: bool) -> list[Finding]:
    """What is wrong with a recording's sound file, from its header or, if ``deep``, from all of it.

    Raises:
        FileError: the sound cannot be used.
    """
    if recording.audio_path is None:
        return []
    notes = recording.audio().notes if deep else check_audio(recording.audio_path)
    return [Finding(_severity(note), "sound", note, file=str(recording.audio_path)) for note in notes]


def detection_findings(recording: Recording, notes: tuple[str, ...]) -> list[Finding]:
    """What was said when detections were read and matched: an error where something could not be used."""
    findings = []
    for note in notes:
        flag = getattr(note, "flag", "")
        kind = "video" if flag.startswith("views-") else "detections"
        is_used = kind == "video" or flag == "detections-interpreted"
        what = f"{recording.id}: {note}" if kind == "video" else note
        findings.append(Finding("warning" if is_used else "error", kind, what))
    return findings


def offset_findings(recording: Recording, detections: Mapping[str, FrameDetections]) -> list[Finding]:
    """Views that seem to have been filmed at other times than they are matched by."""
    found = find_offsets(recording, detections)
    offsets_s = dict(corrected(recording.matching, recording.clock(), found).offsets_s) if found else {}
    return [
        Finding(
            "warning",
            "video",
            f"{recording.id}: as the container moves, {each.view} seems to have been filmed {abs(each.offset_s):.2f} s "
            f"{'later' if each.offset_s > 0 else 'earlier'} than it is matched with {each.reference}",
            advice=f"try --offset {each.view}={offsets_s[each.view]:g}, or the Frames page",
        )
        for each in found
    ]


def video_findings(view: View) -> list[Finding]:
    """Frames that a video lacks, how its pictures are turned, and a form that its calibration is not for.

    Raises:
        FileError: the video cannot be opened.
    """
    (width, height), file = video_size(view.video_path), str(view.video_path)
    findings = []
    count, beyond = frames_beyond_end(view.video_path)
    if beyond:
        what = f"breaks off: {beyond} of its {count} frames are not in the file"
        findings.append(Finding("error", "video", what, file=file, advice="download it again"))
    if any(file_turn(view.video_path)):
        findings.append(Finding("note", "video", "its pictures are turned as its display matrix says", file=file))
    shape, wanted = width / height, CALIBRATED_SIZE[0] / CALIBRATED_SIZE[1]
    if view.calibration_path is not None and abs(shape / wanted - 1) > SHAPE_TOLERANCE:
        what = f"has pictures of {width}x{height}, the calibration is for {CALIBRATED_SIZE[0]}x{CALIBRATED_SIZE[1]}"
        findings.append(Finding("warning", "video", what, file=file, advice="check that it is neither cut nor turned"))
    return findings


def _severity(note: str) -> Severity:
    """Something that raises a flag may not be what was meant."""
    return "warning" if isinstance(note, Note) else "note"
