"""The wall thickness of a dataset's containers, learned from annotated capacities, and its effect on unseen ones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from corsmal.dataset import Recording
from corsmal.errors import ArgumentError
from corsmal.estimation import estimate
from corsmal.parameters import ShapeParameters
from corsmal.shape import capacity_ml, learn_wall_mm, learn_walls_of_others
from corsmal.stages.detections import load_detections
from corsmal.store import Store


@dataclass(frozen=True, eq=False)
class LearnedWall:
    """What ``learn_wall`` found.

    Args:
        wall_mm: the wall learned from all round containers.
        table: a row per round container: container, recordings, wall_mm as the others have it, and the mean absolute
            error of the capacity in % without a wall, with the preset's and with that of the others.
    """

    wall_mm: float
    table: pd.DataFrame


def learn_wall(
    recordings: Sequence[Recording],
    *,
    store: Store,
    shape: ShapeParameters | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> LearnedWall:
    """Learn the wall from the hulls of recordings whose capacities are annotated, by default with the preset ``tuned``.

    Detections are beside the videos or in the store; ``progress`` is called with the numbers of recordings done and
    wanted.

    Raises:
        ArgumentError: no recording has a round container that was fitted and whose capacity is annotated.
    """
    shape = shape or ShapeParameters.tuned()
    hulls, known = [], []
    for index, recording in enumerate(recordings):
        annotation = recording.annotation
        if annotation is not None and annotation.capacity_ml:
            found = estimate(recording, detections=load_detections(recording, store=store).views, shape=shape)
            if found.fit is not None and found.fit.hull.depth_mm is None:
                hulls.append(found.fit.hull)
                known.append((annotation.container or "unknown", annotation.capacity_ml))
        if progress is not None:
            progress(index + 1, len(recordings))
    if not hulls:
        raise ArgumentError(
            "recordings must show a round container with an annotated capacity and detections in two views, got none; "
            "run detect first"
        )
    containers, capacities = zip(*known, strict=True)
    others = learn_walls_of_others(hulls, capacities, containers)
    table = pd.DataFrame({"container": containers, "wall_mm": np.array(others, dtype=np.float64)})
    given: dict[str, Sequence[float | None]] = {
        "no_wall_pct": [0.0] * len(hulls),
        "preset_pct": [shape.wall_mm] * len(hulls),
        "others_pct": others,
    }
    for name, walls in given.items():
        table[name] = [
            np.nan if wall is None else 100 * abs(capacity_ml(hull, wall_mm=wall) - true) / true
            for hull, true, wall in zip(hulls, capacities, walls, strict=True)
        ]
    means = table.groupby("container", sort=False).mean()
    means.insert(0, "recordings", table.groupby("container", sort=False).size())
    return LearnedWall(learn_wall_mm(hulls, capacities), means.reset_index())
