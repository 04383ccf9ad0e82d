"""What a check of one recording's files finds: calibrations, detections, and how they were read."""

import numpy as np

from corsmal.dataset import Recording, View
from corsmal.dataset.audio import check_audio
from corsmal.dataset.findings import Finding, Severity
from corsmal.estimation.plausibility import CAMERA_M
from corsmal.notes import Note


def calibration_findings(view: View) -> list[Finding]:
    """How a view's calibration was read where that was not as expected, and a camera that stands at no likely place.

    Raises:
        FileError: the calibration cannot be used.
    """
    if view.calibration_path is None:
        return []
    found, file = view.calibration(), str(view.calibration_path)
    findings = [Finding(_severity(note), "calibration", note, file=file) for note in found.notes]
    distance_m = float(np.linalg.norm(found.camera.translation))
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


def detection_findings(notes: tuple[str, ...]) -> list[Finding]:
    """What was said when detections were read: an error where something could not be used."""
    return [
        Finding("warning" if getattr(note, "flag", "") == "detections-interpreted" else "error", "detections", note)
        for note in notes
    ]


def _severity(note: str) -> Severity:
    """Something that raises a flag may not be what was meant."""
    return "warning" if isinstance(note, Note) else "note"
