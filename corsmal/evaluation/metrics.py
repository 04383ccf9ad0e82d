"""Measures of agreement between estimates and truth, all in percent."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from corsmal.dataset.annotation import FILLINGS, LEVELS
from corsmal.errors import ArgumentError

NO_ESTIMATE = -1
"""What stands for a missing class or quantity in files."""

CLASS_NAMES = {"filling_type": FILLINGS, "filling_level": LEVELS}
"""Names of the classes, by quantity; a class is its name's place."""

Values = ArrayLike | pd.Series
"""(n,) numbers; what is missing may be None, NaN, NA or negative."""


def mpf1(truth: Values, predicted: Values) -> float:
    """Mean over classes of the F1-score, in % (MPF1, paper 4.3).

    Args:
        truth: (n,) class numbers from 0, none missing, n ≥ 1.
        predicted: (n,) class numbers; a missing one is a wrong answer, not a class.

    Returns:
        The mean over the classes that occur in the truth or in the predictions, 0 to 100.

    Raises:
        ArgumentError: the lengths differ, nothing is there, or a class is missing in the truth or no whole number.
    """
    true_classes, predicted_classes = _pair(truth, predicted)
    scores, _ = f1_by_class(true_classes, predicted_classes, np.ones((1, len(true_classes))))
    return 100 * float(np.nanmean(scores))


def weighted_f1(truth: Values, predicted: Values) -> float:
    """Mean over the truth's classes of the F1-score, weighted by how often they occur, in %.

    Args:
        truth: (n,) class numbers from −1, n ≥ 1; −1 is a class here, as in ``joint_classes``.
        predicted: (n,) class numbers; a missing one is −1.

    Returns:
        0 to 100.

    Raises:
        ArgumentError: the lengths differ, nothing is there, or a class is no whole number.
    """
    true_classes, predicted_classes = _pair(truth, predicted, is_truth_complete=False)
    scores, supports = f1_by_class(true_classes + 1, predicted_classes + 1, np.ones((1, len(true_classes))))
    return 100 * float(np.nansum(scores * supports) / supports.sum())


def f1_by_class(
    truth: NDArray[np.int64], predicted: NDArray[np.int64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """F1-score of every class when recordings count with weights, for many sets of weights at once.

    Args:
        truth: (n,) class numbers.
        predicted: (n,) class numbers; a negative one is an answer that is no class.
        weights: (m, n) how often each recording counts.

    Returns:
        (m, classes) 2 hits / (times predicted + times true), 0 to 1, of the classes that occur; NaN where the weights
        leave nothing of one. And (m, classes) how often each is true.
    """
    classes = np.union1d(truth, predicted)
    classes = classes[classes >= 0]
    is_there, is_said = (np.equal.outer(values, classes).astype(np.float64) for values in (truth, predicted))
    supports, sizes = weights @ is_there, weights @ (is_there + is_said)
    hits = weights @ (is_there * is_said)
    return np.divide(2 * hits, sizes, out=np.full_like(sizes, np.nan), where=sizes > 0), supports


def relative_errors(estimated: Values, true: Values) -> NDArray[np.float64]:
    """Signed errors in % of the truth.

    Args:
        estimated: (n,) quantities; a missing one is None, NaN or negative.
        true: (n,) quantities, positive, in the same unit.

    Returns:
        (n,) 100 (estimated − true) / true; NaN where there is no estimate.

    Raises:
        ArgumentError: the lengths differ, or a true quantity is missing or not positive.
    """
    estimates, truths = numbers(estimated, name="estimated"), numbers(true, name="true")
    _check_lengths("estimated", estimates, "true", truths)
    if not np.all(np.isfinite(truths) & (truths > 0)):
        raise ArgumentError("true must hold positive numbers only: a relative error needs a truth to relate to")
    estimates = np.where(np.isfinite(estimates) & (estimates >= 0), estimates, np.nan)
    errors: NDArray[np.float64] = 100 * (estimates - truths) / truths
    return errors


def mape(estimated: Values, true: Values) -> float:
    """Mean absolute relative error, in % (MAPE, paper 4.3), over the recordings that have an estimate.

    How many have none is not part of this number: count them beside it, as ``container_table`` does.

    Args:
        estimated: (n,) quantities; a missing one is None, NaN or negative.
        true: (n,) quantities, positive, in the same unit.

    Returns:
        Mean of 100 |estimated − true| / true.

    Raises:
        ArgumentError: as ``relative_errors``, or there is no estimate at all.
    """
    errors = relative_errors(estimated, true)
    if np.isnan(errors).all():
        raise ArgumentError(f"estimated holds no estimate among {len(errors)} values: there is no error to average")
    return float(np.nanmean(np.abs(errors)))


def joint_classes(filling_type: Values, filling_level: Values) -> NDArray[np.int64]:
    """Filling types (n,) 0 to 3 and levels (n,) 0 to 2 as one class.

    Returns:
        (n,) 0 for nothing in an empty container; 1 to 6 for pasta, rice and water, half before full; −1 for pairs that
        cannot be (a filling at level empty, no filling at level half or full) and where either is missing.
    """
    types, levels = class_numbers(filling_type, name="filling_type"), class_numbers(filling_level, name="filling_level")
    _check_lengths("filling_type", types, "filling_level", levels)
    is_filled = (types >= 1) & (types < len(FILLINGS)) & (levels >= 1) & (levels < len(LEVELS))
    is_empty = (types == 0) & (levels == 0)
    joint: NDArray[np.int64] = np.select([is_empty, is_filled], [0, 2 * (types - 1) + levels], default=NO_ESTIMATE)
    return joint


def confusion(truth: Values, predicted: Values, classes: Sequence[str]) -> pd.DataFrame:
    """How often each class was taken for which.

    Args:
        truth: (n,) class numbers, none missing.
        predicted: (n,) class numbers; may be missing.
        classes: the classes' names; class 0 is the first.

    Returns:
        Counts: a row per true class, a column per predicted class, and a last column ``no estimate``.

    Raises:
        ArgumentError: the lengths differ, or a class is missing in the truth, no whole number or has no name.
    """
    true_classes, predicted_classes = _pair(truth, predicted, is_empty_allowed=True)
    highest = max(true_classes.max(initial=-1), predicted_classes.max(initial=-1))
    if highest >= len(classes):
        raise ArgumentError(f"classes names {len(classes)} classes, got class number {highest}")
    counts = np.zeros((len(classes), len(classes) + 1), dtype=np.int64)
    np.add.at(counts, (true_classes, predicted_classes), 1)  # −1, no estimate, is the last column
    rows, columns = pd.Index(classes, name="true"), pd.Index([*classes, "no estimate"], name="predicted")
    return pd.DataFrame(counts, index=rows, columns=columns)


def numbers(values: Values, *, name: str) -> NDArray[np.float64]:
    """Values as (n,) float, NaN where missing.

    Raises:
        ArgumentError: they are not one list of numbers; ``name`` is what the message calls them.
    """
    try:
        series = pd.Series(values if isinstance(values, pd.Series) else list(values))  # type: ignore[arg-type]
        found: Any = pd.to_numeric(series).to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} must be a list of numbers ({error})") from error
    return np.array(found)


def class_numbers(values: Values, *, name: str) -> NDArray[np.int64]:
    """Values as (n,) class numbers, −1 where missing or negative.

    Raises:
        ArgumentError: a value is no whole number; ``name`` is what the message calls them.
    """
    found = numbers(values, name=name)
    known = np.where(np.isnan(found) | (found < 0), NO_ESTIMATE, found)
    wrong = known[(known > np.iinfo(np.int32).max) | (known != np.floor(known))]
    if len(wrong):
        raise ArgumentError(f"{name} must hold class numbers 0, 1, 2 …, got {wrong[0]:g}")
    return known.astype(np.int64)


def _pair(
    truth: Values, predicted: Values, *, is_truth_complete: bool = True, is_empty_allowed: bool = False
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    true_classes, predicted_classes = class_numbers(truth, name="truth"), class_numbers(predicted, name="predicted")
    _check_lengths("truth", true_classes, "predicted", predicted_classes)
    if not len(true_classes) and not is_empty_allowed:
        raise ArgumentError("truth is empty: there is nothing to score")
    if is_truth_complete and np.any(true_classes == NO_ESTIMATE):
        raise ArgumentError("truth must name a class for every recording: leave those out whose truth is unknown")
    return true_classes, predicted_classes


def _check_lengths(first: str, a: NDArray[Any], second: str, b: NDArray[Any]) -> None:
    if len(a) != len(b):
        raise ArgumentError(f"{first} and {second} must have the same length, got {len(a)} and {len(b)}")
