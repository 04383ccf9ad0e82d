"""What a check of a dataset finds: how bad, in which file, and what to do about it."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from corsmal.errors import ArgumentError

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
"""``error``: something cannot be used. ``warning``: it is used, and may not be what was meant, or it is left out and
could be used. ``note``: what was assumed, or is merely absent."""

ADVICE_SEPARATOR = "; "


@dataclass(frozen=True)
class Finding:
    """One thing to know about a dataset or about one of its recordings.

    Args:
        severity: see ``SEVERITIES``.
        kind: one word for programs: ``missing``, ``unused``, ``name``, ``annotation``, ``video``, ``sound``,
            ``calibration``, ``detections``, ``network`` or ``cache``.
        what: what was found, the rest of a sentence after the file's name.
        file: the file or folder, within the dataset's folder where it lies there; empty where there is none.
        recording: id; empty for what concerns the whole set.
        advice: what to do; empty where nothing is to be done.
    """

    severity: Severity
    kind: str
    what: str
    file: str = ""
    recording: str = ""
    advice: str = ""

    def __post_init__(self) -> None:
        if self.severity not in SEVERITIES:
            raise ArgumentError(f"severity must be one of {', '.join(SEVERITIES)}, got {self.severity!r}")

    def __str__(self) -> str:
        said = f"{self.file}: {self.what}" if self.file else self.what
        return f"{said}{ADVICE_SEPARATOR}{self.advice}" if self.advice else said

    @property
    def is_problem(self) -> bool:
        """Whether somebody should look at it."""
        return self.severity != "note"

    def to_json(self) -> dict[str, Any]:
        """The fields by name."""
        return {
            "severity": self.severity,
            "kind": self.kind,
            "recording": self.recording,
            "file": self.file,
            "what": self.what,
            "advice": self.advice,
        }

    def of(self, recording: str) -> "Finding":
        """The same of a recording."""
        return replace(self, recording=recording)


def in_order(findings: Iterable[Finding]) -> list[Finding]:
    """Each once, the worst first, otherwise as they come."""
    return sorted(dict.fromkeys(findings), key=lambda finding: SEVERITIES.index(finding.severity))
