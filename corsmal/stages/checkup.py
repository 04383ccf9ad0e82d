"""What is wrong with a dataset, gathered: its folder, and what examining its recordings found."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.dataset.findings import Finding, in_order
from corsmal.dataset.places import shown_path

AGREES_MAX = 0.02
"""Share of the image width. Intact recordings of the demo reach 0.017; with exchanged cameras most have 0.03 to 0.3."""

NAMED_MAX = 3


def set_findings(dataset: Dataset, recordings: Sequence[Recording]) -> list[Finding]:
    """What opening the folder found, and which parts recordings lack, without reading their files."""
    wanted = {recording.id for recording in recordings}
    opened = [finding for finding in dataset.findings if not finding.recording or finding.recording in wanted]
    return in_order([*opened, *_missing(recordings)])


def examined_findings(rows: Iterable[Mapping[str, Any]], *, root: Path) -> list[Finding]:
    """What ``ExamineTask`` found in recordings of a folder, from its rows; a row that failed is an error."""
    findings: list[Finding] = []
    for row in rows:
        name = row["recording_id"]
        findings += (_within(root, finding) for finding in row.get("findings", ()))
        if row.get("notes"):
            findings.append(Finding("error", "recording", row["notes"], recording=name))
        error = row.get("reprojection")
        if error is not None and error > AGREES_MAX:
            what = f"{name}: calibration and detections disagree ({percent(error)}): is one of another recording?"
            findings.append(Finding("error", "agreement", what, recording=name))
    return in_order(findings)


def agreement(rows: Iterable[Mapping[str, Any]]) -> str:
    """One sentence on how well calibration and detections agree over all recordings."""
    errors = sorted(row["reprojection"] for row in rows if row.get("reprojection") is not None)
    if not errors:
        return "calibration and detections cannot be compared: no frame has a container and a camera in two views"
    return (
        f"calibration against detections, {len(errors)} recordings: the reprojected centroid misses the mask's by "
        f"{percent(errors[(len(errors) - 1) // 2])} of the image width (median; worst: {percent(errors[-1])})"
    )


def percent(share: float) -> str:
    """A share as people read it."""
    return f"{100 * share:.2f} %" if math.isfinite(share) else "behind a camera"


def _within(root: Path, finding: Finding) -> Finding:
    """A finding whose file is named from the dataset's folder, where it lies there."""
    return replace(finding, file=shown_path(Path(finding.file), root)) if finding.file else finding


def _missing(recordings: Sequence[Recording]) -> list[Finding]:
    lacking: dict[str, list[str]] = {}
    for recording in recordings:
        for part in recording.missing:
            lacking.setdefault(part, []).append(recording.id)
    findings = []
    for part, names in lacking.items():
        is_whole_set = len(names) == len(recordings)
        shown = ", ".join(names[:NAMED_MAX]) + (", …" if len(names) > NAMED_MAX else "")
        what = f"{part} is missing in {len(names)} recording{'' if len(names) == 1 else 's'}: {shown}"
        only = names[0] if len(names) == 1 else ""
        findings.append(Finding("note" if is_whole_set else "warning", "missing", what, recording=only))
    return findings
