"""The CORSMAL Challenge's scores, in percent."""

from collections.abc import Mapping
from typing import Literal, TypeVar, get_args

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.evaluation.checking import listed, truth_table
from corsmal.evaluation.metrics import joint_classes, weighted_f1
from corsmal.evaluation.submission import check_submission

Split = Literal["train", "public", "private", "other"]
SPLITS: tuple[Split, ...] = get_args(Split)

OFFSETS: dict[Split, float] = {"train": 0.047505, "public": 0.004339, "private": 0.004338, "other": 0.0}
"""What s8 gains: the annotated filling masses are not quite level × capacity × density, so that without it a perfect
submission would stay below 1 by this much. It belongs to the whole set; data that is none of the challenge's has
none."""

SCORES = {
    "s1": "filling_level",
    "s2": "filling_type",
    "s3": "capacity_ml",
    "s4": "width_top_mm",
    "s5": "width_bottom_mm",
    "s6": "height_mm",
    "s7": "container_mass_g",
    "s8": "filling_mass_g",
}
"""What each score is about. s9 and s10 come from a simulator and are 0 here."""

_MASS_TASKS = ("filling_level", "filling_type", "capacity_ml")

Score = TypeVar("Score", float, pd.Series)


def challenge_scores(
    annotation: pd.DataFrame, submission: pd.DataFrame, baseline: pd.DataFrame | None = None, split: Split = "train"
) -> pd.Series:
    """The challenge's scores of a submission.

    −1 stands for no estimate, and so does what cannot be used: a missing row, NaN, a negative number, a class that
    there is not. A recording without an estimate scores 0, and so does a task whose column is −1 everywhere. Recordings
    whose truth is unknown are left out of the score that needs it.

    Args:
        annotation: a dataset's table, or the columns of the annotation file.
        submission: the submission file's columns, ``Configuration ID`` and those that are scored.
        baseline: another submission, whose columns s8 takes for tasks that were not attempted. Without it s8 is 0 when
            the level or the capacity was not attempted; the type is not needed, because s8 is computed with the
            annotated density.
        split: which of the challenge's sets this is, for s8's offset; ``other`` for data that is none of them.

    Returns:
        ``s1`` to ``s8``, ``overall`` (at most 75 without the simulator's two scores), ``JFTL`` (joint filling type and
        level) and ``CMD`` (container capacity and dimensions), each 0 to 100; NaN where the annotation has no truth.
        ``attrs["notes"]`` holds sentences on what was missing or left out.

    Raises:
        ArgumentError: a table has no ids or no rows in common with the annotation, or the split is unknown.
    """
    if split not in SPLITS:
        raise ArgumentError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
    truth = truth_table(annotation)
    checked = check_submission(submission, truth.index)
    estimates, notes = checked.table, [*checked.notes, *_unknown(truth)]
    scores = {name: _task_score(truth[about], estimates[about]) for name, about in SCORES.items() if name != "s8"}
    attempted = [task for task in _MASS_TASKS if estimates[task].notna().any()]
    if baseline is not None:
        other = check_submission(baseline, truth.index, what="baseline").table
        estimates = estimates.assign(**{task: other[task] for task in _MASS_TASKS if task not in attempted})
    scores["s8"] = _filling_mass_score(truth, estimates, OFFSETS[split]) * len(attempted) / len(_MASS_TASKS)
    scores["overall"] = overall_score(scores)
    scores["JFTL"] = _joint_score(truth, checked.table)
    scores["CMD"] = scores["s3"] / 2 + (scores["s4"] + scores["s5"] + scores["s6"]) / 6
    result = pd.Series(scores, name="score (%)", dtype=np.float64)
    result.attrs["notes"] = tuple(notes)
    return result


def overall_score(scores: Mapping[str, Score], *, simulator: Score | float = 0.0) -> Score:
    """The challenge's overall score.

    Args:
        scores: ``s1`` to ``s8`` in %, as numbers, or as a table's columns for many at once.
        simulator: (s9 + s10) in %, times the share of the five tasks (level, type, capacity, mass, dimensions) that
            were attempted.

    Returns:
        The mean of eight: level, type, capacity, dimensions, container mass, filling mass, s9 and s10; in %.
    """
    dimensions = (scores["s4"] + scores["s5"] + scores["s6"]) / 3
    return (scores["s1"] + scores["s2"] + scores["s3"] + dimensions + scores["s7"] + scores["s8"] + simulator) / 8


def _task_score(truth: pd.Series, estimates: pd.Series) -> float:
    """One task's score over the recordings whose truth is known, in %."""
    is_known = truth.notna().to_numpy()
    if not is_known.any():
        return np.nan
    known, estimated = truth.to_numpy()[is_known], estimates.to_numpy()[is_known]
    if truth.name in ("filling_level", "filling_type"):
        return weighted_f1(known, estimated)
    error = np.abs(estimated - known) / known
    score = np.exp(-error) if truth.name in ("capacity_ml", "container_mass_g") else np.clip(1 - error, 0, None)
    return 100 * float(np.nan_to_num(score).mean())


def _filling_mass_score(truth: pd.DataFrame, estimates: pd.DataFrame, offset: float) -> float:
    """s8 before it is weighted by the share of tasks that were attempted, in %."""
    known = truth[["filling_mass_g", "filling_density_g_per_ml"]].notna().all(axis=1)
    if not known.any():
        return np.nan
    true_mass = truth.loc[known, "filling_mass_g"].to_numpy()
    fraction = estimates.loc[known, "filling_level"].map(dict(enumerate(LEVEL_FRACTIONS)))
    mass = fraction * estimates.loc[known, "capacity_ml"] * truth.loc[known, "filling_density_g_per_ml"]
    if mass.isna().all():
        return 0.0
    error = np.abs(mass.to_numpy() - true_mass) / np.where(true_mass > 0, true_mass, 1.0)
    return 100 * (float(np.nan_to_num(np.exp(-error)).mean()) + offset)


def _joint_score(truth: pd.DataFrame, estimates: pd.DataFrame) -> float:
    columns = ["filling_type", "filling_level"]
    known = truth[columns].notna().all(axis=1)
    if not known.any():
        return np.nan
    true_type, true_level = (truth.loc[known, name] for name in columns)
    return weighted_f1(
        joint_classes(true_type, true_level), joint_classes(*(estimates.loc[known, name] for name in columns))
    )


def _unknown(truth: pd.DataFrame) -> list[str]:
    """What the annotation does not know."""
    notes = []
    for name in (*SCORES.values(), "filling_density_g_per_ml"):
        absent = truth.index[truth[name].isna()]
        if len(absent) == len(truth):
            notes.append(f"annotation: there is no truth of {name}; what needs it is not scored")
        elif len(absent):
            notes.append(f"annotation: there is no {name} of {listed(absent)}; left out where it is needed")
    return notes
