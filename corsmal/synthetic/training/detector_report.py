"""How well a detector finds the containers in frames of the demo that it has not seen."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from corsmal.detection import Detections, Detector
from corsmal.errors import ArgumentError
from corsmal.mass.judging import mask_iou
from corsmal.synthetic.render.frame import FrameTruth, render_frame
from corsmal.synthetic.scene.cameras import VIEWS
from corsmal.synthetic.scene.containers import CONTAINER_IDS
from corsmal.synthetic.scene.scene import make_scene

SEEDS_FROM = 1_000_000
"""Of the report's scenes; those of the demo's own recordings and of the training are others."""

SCORE_MIN, IOU_MIN = 0.5, 0.5
SHOWN_SHARE_MIN = 0.5
"""A container of which less can be seen may be missed."""


def detector_report(
    detector: Detector, *, frames: int = 200, progress: Callable[[int, int], None] | None = None
) -> pd.DataFrame:
    """Compare a detector with the truth in frames of the demo, the containers in turn.

    ``progress`` is called with the numbers of frames done and wanted.

    Returns:
        A row per frame: ``seed``, ``container``, ``view``, ``frame``; ``visible``: more than half of the container is
        seen; ``found``: a detection's mask overlaps it with an IoU of at least 0.5; ``iou``: of the best one, NaN where
        there is none; ``false``: detections of score 0.5 or more that are not the container.

    Raises:
        ArgumentError: ``frames`` is not positive.
    """
    if frames < 1:
        raise ArgumentError(f"frames must be at least 1, got {frames}")
    rows = []
    for index in range(frames):
        number, seed = CONTAINER_IDS[index % len(CONTAINER_IDS)], SEEDS_FROM + index
        rng = np.random.default_rng(seed)
        scene = make_scene(seed, container=number)
        view, frame = VIEWS[rng.integers(len(VIEWS))], int(rng.integers(scene.frames))
        truth = render_frame(scene, view, frame)
        visible = bool(truth.visible.sum() > SHOWN_SHARE_MIN * truth.amodal.sum())
        [detections] = detector.detect([truth.image])
        iou, false = _compared(detections, truth, visible=visible)
        is_hit = visible and iou >= IOU_MIN
        rows.append((seed, scene.container.name, view, frame, visible, is_hit, iou if is_hit else np.nan, false))
        if progress is not None:
            progress(index + 1, frames)
    return pd.DataFrame(rows, columns=["seed", "container", "view", "frame", "visible", "found", "iou", "false"])


def detector_table(report: pd.DataFrame) -> pd.DataFrame:
    """Recall, mean IoU of the hits and false detections per frame of a report, by container and over all frames."""

    def summary(rows: pd.DataFrame) -> pd.Series:
        visible = rows[rows["visible"]]
        figures = [len(rows), len(visible), visible["found"].mean(), rows["iou"].mean(), rows["false"].mean()]
        return pd.Series(figures, index=["frames", "visible", "recall", "iou", "false_per_frame"])

    table = pd.DataFrame({name: summary(rows) for name, rows in report.groupby("container", sort=False)}).T
    table.loc["all frames"] = summary(report)
    return table.astype({"frames": int, "visible": int})


def _compared(detections: Detections, truth: FrameTruth, *, visible: bool) -> tuple[float, int]:
    """The best overlap, and how many are not the container; one of which less can be seen may be found or not."""
    kept = np.flatnonzero(np.asarray(detections.scores) >= SCORE_MIN)
    masks = [detections.mask(int(index)) for index in kept]
    overlaps = [mask_iou(mask, truth.visible) for mask in masks]
    if visible:
        right = min(1, sum(overlap >= IOU_MIN for overlap in overlaps))
    else:
        right = sum(bool((mask & truth.amodal).any()) for mask in masks)
    return max(overlaps, default=0.0), len(kept) - right
