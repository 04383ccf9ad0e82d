"""Whether probabilities mean what they say, and what is gained by answering "don't know" where they are low."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from corsmal.errors import ArgumentError
from corsmal.evaluation.filling_tables import PREDICTED, TRUE, checked_predictions, pooled_table
from corsmal.evaluation.metrics import CLASS_NAMES

BINS = 10
"""Of equal width, from 0 to 1."""

COVERAGES = (1.0, 0.9, 0.8, 0.7)
"""Shares of the recordings that are answered, the surest first."""


def reliability_table(confidence: ArrayLike, right: ArrayLike, *, bins: int = BINS) -> pd.DataFrame:
    """How often answers are right, by the probability that they were given.

    Args:
        confidence: (n,) probability of the answer, 0..1.
        right: (n,) whether it is right.
        bins: how many, of equal width; a value on an edge belongs to the bin above.

    Returns:
        A row per bin that holds an answer: ``low`` and ``high``, ``recordings``, and the means ``confidence`` and
        ``accuracy``, 0..1.

    Raises:
        ArgumentError: the two differ in length, are empty, or a probability lies outside 0..1.
    """
    sure, is_right = _checked(confidence, right)
    number = np.minimum((sure * bins).astype(int), bins - 1)
    rows = []
    for index in np.unique(number):
        own = number == index
        means = {"confidence": sure[own].mean(), "accuracy": is_right[own].mean()}
        rows.append({"low": index / bins, "high": (index + 1) / bins, "recordings": int(own.sum()), **means})
    return pd.DataFrame(rows)


def calibration_error(confidence: ArrayLike, right: ArrayLike, *, bins: int = BINS) -> float:
    """The expected calibration error in %: the mean distance of confidence and accuracy, weighted by the bins' sizes.

    Arguments and errors are those of ``reliability_table``.
    """
    table = reliability_table(confidence, right, bins=bins)
    distance = (table["confidence"] - table["accuracy"]).abs()
    return float(100 * (distance * table["recordings"]).sum() / table["recordings"].sum())


def risk_coverage_table(confidence: ArrayLike, right: ArrayLike) -> pd.DataFrame:
    """What is wrong among the surest answers, for every threshold below which none is given.

    Returns:
        A row per threshold, falling: ``threshold``, ``coverage`` (share that is answered) and ``risk`` (share of these
        that is wrong). Errors are those of ``reliability_table``.
    """
    sure, is_right = _checked(confidence, right)
    order = np.argsort(-sure, kind="stable")
    answered = np.arange(1, len(order) + 1)
    table = pd.DataFrame(
        {
            "threshold": sure[order],
            "coverage": answered / len(order),
            "risk": np.cumsum(~is_right[order]) / answered,
        }
    )
    return table.drop_duplicates("threshold", keep="last").reset_index(drop=True)


def confidences(predictions: pd.DataFrame, quantity: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The probability of every answer of a cross-validation, and whether it is right.

    Args:
        predictions: as ``pooled_table``, with a column ``p_NAME`` for every class.
        quantity: ``filling_type`` or ``filling_level``.
    """
    known = checked_predictions(predictions)
    shares = known[[f"p_{name}" for name in CLASS_NAMES[quantity]]].to_numpy(dtype=np.float64)
    predicted = known[PREDICTED[quantity]].to_numpy(dtype=int)
    return shares[np.arange(len(known)), predicted], (known[TRUE[quantity]] == predicted).to_numpy()


def judged_confidences(errors: pd.DataFrame, quantity: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The probability of every judged answer of a run, and whether it is right.

    Args:
        errors: from ``error_table``; answers whose probability is not known are left out.
        quantity: ``filling_type`` or ``filling_level``.

    Returns:
        (n,) and (n,); n may be 0.
    """
    known = errors[errors[f"{quantity}_correct"].notna() & errors[f"{quantity}_confidence"].notna()]
    return known[f"{quantity}_confidence"].to_numpy(dtype=np.float64), known[f"{quantity}_correct"].to_numpy(dtype=bool)


def calibration_table(tables: Mapping[str, pd.DataFrame], quantity: str = "filling_level") -> pd.DataFrame:
    """How well calibrated the answers of one or several cross-validations are.

    Returns:
        A row per table: ``calibration_error``, in %, and ``wrong_at_100`` and so on, the share in % that is wrong among
        that many % of the answers, the surest.
    """
    rows = {}
    for name, predictions in tables.items():
        sure, right = confidences(predictions, quantity)
        curve = risk_coverage_table(sure, right)
        wrong = {
            f"wrong_at_{100 * share:.0f}": 100 * curve["risk"][np.searchsorted(curve["coverage"], share)]
            for share in COVERAGES
        }
        rows[name] = {"calibration_error": calibration_error(sure, right), **wrong}
    return pd.DataFrame.from_dict(rows, orient="index")


def condition_table(tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Weighted F1 of several cross-validations, in %: the mean over seeds of ``pooled_table``, a row per table."""
    rows = {name: pooled_table(table).set_index("seed").loc["mean"] for name, table in tables.items()}
    return pd.DataFrame(rows).T


def _checked(confidence: ArrayLike, right: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    sure, is_right = np.asarray(confidence, dtype=np.float64), np.asarray(right, dtype=bool)
    if sure.ndim != 1 or sure.shape != is_right.shape or not len(sure):
        raise ArgumentError(f"confidence and right must be (n,), n at least 1, got {sure.shape} and {is_right.shape}")
    if not ((sure >= 0) & (sure <= 1)).all():
        raise ArgumentError("confidence must lie in 0..1")
    return sure, is_right
