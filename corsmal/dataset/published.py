"""What is particular about the published training set."""

from collections.abc import Collection, Mapping

from corsmal.dataset.annotation import Annotation
from corsmal.dataset.findings import Finding

CUTS_S = {"000377": 13.10}
"""Recordings of the published training set, by id, whose sound ends that many seconds after its start: the recorder of
000377 was not stopped."""

TRAINING_IDS = frozenset(f"{number:06d}" for number in range(684))
"""The training set's recordings."""

_KNOWN = {
    "000377": Annotation(
        container_id=1,
        scenario=2,
        background=1,
        illumination=0,
        capacity_ml=520.0,
        container_mass_g=10.0,
        filling_type=1,
        filling_level=2,
        filling_mass_g=195.0,
    )
}
"""What the published annotation says, in part, of the recordings that are cut."""


def cut_s(recording: str, annotation: Annotation | None, *, ids: Collection[str]) -> float | None:
    """Where a recording's sound is to be cut, in seconds from its start; None where it is used whole.

    Only the published training set's is cut: the recording whose annotation is the published one or, without
    annotation, the one in a folder of exactly that set's ids. Recordings of other sets carry the same numbers.

    Args:
        recording: its id.
        annotation: what is known about it.
        ids: of all recordings of the folder.
    """
    if recording not in CUTS_S:
        return None
    known = _KNOWN[recording]
    if annotation is None:
        return CUTS_S[recording] if set(ids) == TRAINING_IDS else None
    facts = (name for name, value in vars(known).items() if value is not None)
    is_published = all(getattr(annotation, name) == getattr(known, name) for name in facts)
    return CUTS_S[recording] if is_published else None


def cut_findings(ends_s: Mapping[str, float | None]) -> list[Finding]:
    """Sentences on the sounds that are cut, or would be in the published set, by recording id."""
    findings = []
    for name, end_s in ends_s.items():
        if end_s is not None:
            what = f"the sound of {name} is cut at {end_s:.1f} s: its recorder was not stopped"
        elif name in CUTS_S:
            what = (
                f"the sound of {name} is used whole; only the published training set's is cut, at {CUTS_S[name]:.1f} s"
            )
        else:
            continue
        findings.append(Finding("note", "sound", what, recording=name))
    return findings
