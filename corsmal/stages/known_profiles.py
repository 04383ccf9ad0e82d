"""The profile that a recording's container is known to have: the truth of a synthetic one, else the annotated sizes."""

import json
from collections.abc import Mapping
from typing import Any

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError, FileError
from corsmal.shape import KnownProfile


def known_profile(recording: Recording, frame: int) -> KnownProfile | None:
    """The outer profile of the container; None where neither truth nor annotation knows it.

    Args:
        recording: the recording.
        frame: of whose truth the height of the base is taken.

    Raises:
        FileError: the recording is synthetic, and its truth cannot be read.
    """
    found = None if recording.truth_path is None else _true_profile(recording, frame)
    if found is not None:
        return found
    note = recording.annotation
    if note is None or not (note.width_bottom_mm and note.width_top_mm and note.height_mm):
        return None
    return KnownProfile.frustum(note.width_bottom_mm, note.width_top_mm, note.height_mm)


def _true_profile(recording: Recording, frame: int) -> KnownProfile | None:
    """The wall that was drawn; None for a box, of which the truth holds no more than the annotation."""
    path = recording.truth_path
    if path is None or not path.is_file():
        return None
    try:
        truth: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        profile, bases_m = truth["profile"], truth["base_m"]
        if profile is None:
            return None
        base_mm = 1000 * float(bases_m[frame][2]) if 0 <= frame < len(bases_m) else None
        return KnownProfile(profile["outer_heights_mm"], profile["outer_radii_mm"], "true profile", base_mm)
    except (OSError, ValueError, LookupError, TypeError, ArgumentError) as error:
        raise FileError(path, "is broken; delete it and make the recording again") from error
