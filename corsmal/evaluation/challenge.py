"""The CORSMAL Challenge's scores, in percent."""

from collections.abc import Mapping
from typing import Literal, TypeVar, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.dataset.annotation import LEVEL_FRACTIONS
from corsmal.errors import check_choice
from corsmal.evaluation.checking import Checked, listed, rows_of, truth_table
from corsmal.evaluation.estimates import ABSENT as NOT_FILMED
from corsmal.evaluation.metrics import joint_classes, weighted_f1
from corsmal.evaluation.splits import SPLITS, Split
from corsmal.evaluation.submission import ID_COLUMN, check_submission
from corsmal.quantities import MEASURED

Absent = Literal["zero", "skip"]
ABSENT: tuple[Absent, ...] = get_args(Absent)
"""What a recording without a row counts: 0, or not at all."""

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
_FROM = {"filling": ["filling_level", "filling_type", "filling_mass_g"], "mass": ["container_mass_g"]}
"""What cannot be scored where a stage's numbers are left out."""

Score = TypeVar("Score", float, pd.Series)


def challenge_scores(
    annotation: pd.DataFrame,
    submission: pd.DataFrame,
    baseline: pd.DataFrame | None = None,
    split: Split = "train",
    *,
    absent: Absent = "zero",
    errors: pd.DataFrame | None = None,
) -> pd.Series:
    """The challenge's scores of a submission.

    −1 stands for no estimate, and so does what cannot be used: NaN, a negative number, a class that there is not. A
    recording without an estimate scores 0, and so does a task whose column is −1 everywhere. Recordings whose truth is
    unknown are left out of the score that needs it.

    Args:
        annotation: a dataset's table, or the columns of the annotation file.
        submission: the submission file's columns, ``Configuration ID`` and those that are scored.
        baseline: another submission, whose columns s8 takes for tasks that were not attempted. Without it s8 is 0 when
            the level or the capacity was not attempted; the type is not needed, because s8 is computed with the
            annotated density.
        split: which of the challenge's sets this is, for s8's offset; ``other`` for data that is none of them.
        absent: how recordings without a row count: ``zero``, which is the challenge's rule, or ``skip``: they are not
            scored.
        errors: the same estimates' error table: what its protocol leaves out is not scored, and of recordings that were
            not filmed ``absent`` decides; default: all is scored.

    Returns:
        ``s1`` to ``s8``, ``overall`` (at most 75 without the simulator's two scores), ``JFTL`` (joint filling type and
        level) and ``CMD`` (container capacity and dimensions), each 0 to 100; NaN where there is no truth to score by.
        Where only some of a challenge's set is scored, s8's offset is what perfect estimates of these recordings lack.
        ``attrs`` holds ``split``, ``scored`` (the number of recordings), ``is_whole`` (no recording is left out of any
        score) and ``notes``, sentences on what was missing or left out.

    Raises:
        ArgumentError: a table has no ids or no rows in common with the annotation, or a choice is unknown.
    """
    check_choice("split", split, SPLITS)
    check_choice("absent", absent, ABSENT)
    known = truth_table(annotation)
    scored = _scored(known, submission, absent, errors)
    truth, is_whole = scored.table, scored.table.equals(known)
    checked = check_submission(submission, truth.index)
    estimates = checked.table
    scores = {name: _task_score(truth[about], estimates[about]) for name, about in SCORES.items() if name != "s8"}
    attempted = [task for task in _MASS_TASKS if estimates[task].notna().any()]
    if baseline is not None:
        other = check_submission(baseline, truth.index, what="baseline").table
        estimates = estimates.assign(**{task: other[task] for task in _MASS_TASKS if task not in attempted})
    offset = OFFSETS[split] if is_whole or split == "other" else None
    scores["s8"] = _filling_mass_score(truth, estimates, offset) * len(attempted) / len(_MASS_TASKS)
    scores["overall"] = overall_score(scores)
    scores["JFTL"] = _joint_score(truth, checked.table)
    scores["CMD"] = scores["s3"] / 2 + (scores["s4"] + scores["s5"] + scores["s6"]) / 6
    result = pd.Series(scores, name="score (%)", dtype=np.float64)
    notes = [*scored.notes, *checked.notes, *_unknown(known.loc[truth.index])]
    if lacking := [name for name in SCORES if np.isnan(scores[name])]:
        notes.append(f"there is no overall score, because no recording can be scored in {', '.join(lacking)}")
    result.attrs |= {"notes": tuple(notes), "split": split, "scored": len(truth), "is_whole": is_whole}
    return result


def overall_score(scores: Mapping[str, Score]) -> Score:
    """The challenge's overall score without the simulator, from ``s1`` to ``s8`` in %, numbers or a table's columns.

    The mean of eight: level, type, capacity, dimensions, container mass, filling mass, and 0 for each of s9 and s10.
    """
    dimensions = (scores["s4"] + scores["s5"] + scores["s6"]) / 3
    return (scores["s1"] + scores["s2"] + scores["s3"] + dimensions + scores["s7"] + scores["s8"]) / 8


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


def _scored(truth: pd.DataFrame, submission: pd.DataFrame, absent: Absent, errors: pd.DataFrame | None) -> Checked:
    """The truth that the submission is scored by, and sentences on what is not scored."""
    scored, notes = truth.copy(), []
    if absent == "skip":
        present = rows_of(submission, truth.index, id_column=ID_COLUMN, what="submission").table.index
        scored = scored[scored.index.isin(present)]
        if missing := len(truth) - len(scored):
            notes.append(
                f"submission: {len(scored)} of the annotation's {len(truth)} recordings have a row and are scored; "
                f"{missing} have none and are not scored"
            )
    if errors is not None:
        for stage, columns in _FROM.items():
            is_out = errors[f"{stage}_left_out"].reindex(scored.index, fill_value=False)
            scored.loc[is_out, columns] = np.nan
        is_absent = errors["status"].eq(NOT_FILMED).reindex(scored.index, fill_value=False)
        if absent == "skip" and is_absent.any():
            scored.loc[is_absent, [*MEASURED, "filling_mass_g"]] = np.nan
            notes.append(
                f"estimates: {is_absent.sum()} of {len(scored)} recordings were not filmed; only their filling level "
                "and type are scored"
            )
    return Checked(scored, tuple(notes))


def _filling_mass_score(truth: pd.DataFrame, estimates: pd.DataFrame, offset: float | None) -> float:
    """s8 before it is weighted by the share of tasks that were attempted, in %; None: what perfect estimates lack."""
    truth = truth[truth[["filling_mass_g", "filling_density_g_per_ml"]].notna().all(axis=1)]
    if truth.empty:
        return np.nan
    score = _filling_masses_score(truth, estimates)
    if np.isnan(score).all():
        return 0.0
    if offset is None:
        offset = float(np.nan_to_num(1 - np.nanmean(_filling_masses_score(truth, truth))))
    return 100 * (float(np.nan_to_num(score).mean()) + offset)


def _filling_masses_score(truth: pd.DataFrame, estimates: pd.DataFrame) -> NDArray[np.float64]:
    """Each recording's closeness to the annotated filling mass, 0 to 1; NaN where the level or capacity is missing."""
    estimates = estimates.loc[truth.index]
    fraction = estimates["filling_level"].map(dict(enumerate(LEVEL_FRACTIONS)))
    mass = (fraction * estimates["capacity_ml"] * truth["filling_density_g_per_ml"]).to_numpy()
    true_mass = truth["filling_mass_g"].to_numpy()
    score: NDArray[np.float64] = np.exp(-np.abs(mass - true_mass) / np.where(true_mass > 0, true_mass, 1.0))
    return score


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
