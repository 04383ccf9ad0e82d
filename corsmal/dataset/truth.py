"""The truth beside a synthetic recording."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from corsmal.detection import ViewDetections
from corsmal.detection.parquet import read_parquet
from corsmal.errors import ArgumentError, CorsmalError, FileError, NotFoundError
from corsmal.synthetic.scene.cameras import VIEWS
from corsmal.synthetic.scene.containers import DemoContainer, demo_container
from corsmal.synthetic.scene.profiles import Profile

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DemoTruth:
    """What was drawn and played in one synthetic recording.

    Args:
        recording_id: six digits.
        container: the container.
        seed: of the scene.
        base_m: (F, 3) the point of the container's axis at its base, in each frame.
        rotation: (F, 3, 3) container to world.
        fill: (F,) share of the capacity that is filled.
        action: ``pour``, ``shake`` or ``handle``.
        events_s: when things happen, by name.
        root: the dataset's folder.
    """

    recording_id: str
    container: DemoContainer
    seed: int
    base_m: Floats
    rotation: Floats
    fill: Floats
    action: str
    events_s: dict[str, float]
    root: Path = field(repr=False)

    @property
    def frames(self) -> int:
        """How many frames the recording has."""
        return len(self.base_m)

    @property
    def profile(self) -> Profile | None:
        """The outer wall; None for boxes."""
        return self.container.outer

    def visible(self, view: str) -> ViewDetections:
        """The container's visible pixels, frame by frame, as detections with score 1."""
        return self._masks("visible", view)

    def amodal(self, view: str) -> ViewDetections:
        """The container's whole silhouette, what hides it left out."""
        return self._masks("amodal", view)

    def _masks(self, kind: str, view: str) -> ViewDetections:
        if view not in VIEWS:
            raise NotFoundError(f"view must be one of {', '.join(VIEWS)}, got {view!r}")
        path = self.root / "truth" / kind / view / f"{self.recording_id}.parquet"
        try:
            return read_parquet(path)
        except FileNotFoundError as error:
            raise NotFoundError(f"{path}: there is no such truth; make the demo again") from error
        except (CorsmalError, OSError, ValueError, LookupError, TypeError, pa.ArrowException) as error:
            raise FileError(path, "is broken; delete it and make the demo again") from error


def open_demo_truth(root: str | Path, recording_id: str) -> DemoTruth:
    """Read the truth of one recording.

    Args:
        root: the demo's folder.
        recording_id: six digits.

    Raises:
        NotFoundError: there is no truth of such a recording: it is real, or not made yet.
        FileError: the file is broken.
    """
    root = Path(root)
    path = root / "truth" / f"{recording_id}.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return _truth(content, recording_id, root)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise NotFoundError(f"{path}: there is no truth of recording {recording_id!r}: it is no demo's") from error
    except (OSError, ValueError, LookupError, TypeError, CorsmalError) as error:
        raise FileError(path, "is broken; delete it and make the demo again") from error


def _truth(content: dict[str, Any], recording_id: str, root: Path) -> DemoTruth:
    base, rotation, fill = (np.array(content[name], dtype=np.float64) for name in ("base_m", "rotation", "fill"))
    frames = len(base)
    if base.shape != (frames, 3) or rotation.shape != (frames, 3, 3) or fill.shape != (frames,):
        raise ArgumentError("the poses must be one per frame")
    return DemoTruth(
        recording_id=recording_id,
        container=demo_container(content["container_id"]),
        seed=content["seed"],
        base_m=base,
        rotation=rotation,
        fill=fill,
        action=content["action"],
        events_s=dict(content["events_s"]),
        root=root,
    )
