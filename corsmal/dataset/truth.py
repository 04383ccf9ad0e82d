"""The truth beside a synthetic recording: poses and filling frame by frame, the outer wall, and where the masks are."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from corsmal.dataset.layout import Recording
from corsmal.errors import FileError, NotFoundError

Floats = NDArray[np.float64]
MaskKind = Literal["visible", "amodal"]


@dataclass(frozen=True, eq=False)
class Truth:
    """What was drawn and played in one synthetic recording of F frames.

    Args:
        base_m: (F, 3) the point of the container's axis at its base.
        rotation: (F, 3, 3) container to world.
        fill: (F,) share of the capacity that is filled, 0..1.
        profile_mm: heights (n,) above the base and radii (n,) of the outer wall; None for boxes.
        events_s: times of the events, by name.
    """

    base_m: Floats
    rotation: Floats
    fill: Floats
    profile_mm: tuple[Floats, Floats] | None
    events_s: dict[str, float]


def read_truth(recording: Recording) -> Truth:
    """Read a recording's poses, filling and profile.

    Raises:
        NotFoundError: the recording is not synthetic.
        FileError: the file is broken.
    """
    path = truth_path(recording)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        base, rotation, fill = (np.array(content[name], dtype=np.float64) for name in ("base_m", "rotation", "fill"))
        wall = content["profile"]
        profile = wall and (np.array(wall["outer_heights_mm"]), np.array(wall["outer_radii_mm"]))
        truth = Truth(base, rotation, fill, profile, dict(content["events_s"]))
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise FileError(path, "is broken; delete it and make the recording again") from error
    frames = len(fill)
    if (base.shape, rotation.shape, fill.shape) != ((frames, 3), (frames, 3, 3), (frames,)):
        raise FileError(path, "is broken: its poses are not one per frame; delete it and make the recording again")
    return truth


def true_mask_path(recording: Recording, view: str, *, kind: MaskKind) -> Path:
    """The file of the container's true masks in one view, as detections; it may be missing.

    Args:
        recording: a synthetic one.
        view: its name.
        kind: ``visible``: the visible pixels; ``amodal``: the whole silhouette, hidden parts included.

    Raises:
        NotFoundError: the recording is not synthetic.
    """
    return truth_path(recording).parent / kind / view / f"{recording.id}.parquet"


def truth_path(recording: Recording) -> Path:
    """The file of a recording's truth.

    Raises:
        NotFoundError: the recording is not synthetic.
    """
    if recording.truth_path is None:
        raise NotFoundError(f"recording {recording.id} has no truth: only synthetic recordings have one")
    return recording.truth_path
