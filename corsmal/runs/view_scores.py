"""Whether the View Score chooses good frames: scores beside the errors of the fits."""

import numpy as np
import pandas as pd

from corsmal.dataset import Dataset
from corsmal.estimation import fit_frame
from corsmal.evaluation.metrics import relative_errors
from corsmal.parameters import ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import select_best_frame
from corsmal.stages.true_masks import true_views


def score_errors(dataset: Dataset, *, step: int = 3, shape: ShapeParameters | None = None) -> pd.DataFrame:
    """View Score of every ``step``-th frame beside the error of the fit in it, with true masks of the first pair.

    Returns:
        A row per frame that could be fitted: recording, container, frame, score (pixels), error_pct (mean of the
        quantities that were measured), and ``rank``, ``error_rank``: their ranks within the recording, 0..1.

    Raises:
        NotFoundError: a recording is not synthetic.
        FileError: its truth cannot be read.
    """
    rows = []
    for recording in dataset:
        true = [getattr(recording.annotation, name, None) or np.nan for name in GEOMETRY]
        views = true_views(recording) if np.isfinite(true).all() else {}
        best = select_best_frame(views, pair=(shape or ShapeParameters.paper()).pairs[0])
        for score in [score for score in best.scores[::step] if score.total is not None]:
            fit = fit_frame(
                recording, views, pair=best.pair, frame=score.frame, centre_rule=best.centre_rule, shape=shape
            )
            if fit.ok:
                values = np.array([getattr(fit.dimensions, name) for name in GEOMETRY], dtype=np.float64)
                error = float(np.nanmean(np.abs(relative_errors(values, true))))
                name = getattr(recording.annotation, "container", None)
                rows.append((recording.id, name, score.frame, score.total, error))
    table = pd.DataFrame(rows, columns=["recording", "container", "frame", "score", "error_pct"])
    by_recording = table.groupby("recording")
    table["rank"] = by_recording["score"].rank(pct=True)
    table["error_rank"] = by_recording["error_pct"].rank(pct=True)
    return table
