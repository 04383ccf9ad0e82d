"""A run in a few numbers: the averages against the paper's, how many failed, how often intervals contain the truth."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd

from corsmal.dataset.ids import recording_id
from corsmal.errors import ArgumentError
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN
from corsmal.quantities import BY_METRIC, MEASURED, QUANTITIES

Group = Literal["MAPE", "MPF1", "failures", "coverage"]

NOMINAL_PERCENT = 90.0
"""How often an estimate's interval should contain the truth."""

ALL = "All"
_NORMAL = 1.96


@dataclass(frozen=True)
class Headline:
    """One number of a summary, with what it is compared with.

    Args:
        group: what kind of number it is.
        name: the metric's column for MAPE and MPF1, the quantity for the coverage of its intervals, ``All`` for the
            coverage over all quantities and for failures.
        label: for people, such as ``Capacity``.
        value: in %; None where there is nothing to compute it from.
        low: lower end of its 95 % interval; None without one.
        high: upper end.
        reference: in %: the paper's average over the same containers, or the nominal coverage; None without one.
        difference: percentage points to the reference, over the containers that both have.
        count: how many of ``total`` failed, or have the truth in their interval; else how many recordings count.
        total: recordings, for the coverage over all quantities intervals.
    """

    group: Group
    name: str
    label: str
    value: float | None
    low: float | None = None
    high: float | None = None
    reference: float | None = None
    difference: float | None = None
    count: int = 0
    total: int = 0

    @property
    def is_lower_better(self) -> bool:
        """Whether a smaller number is the better one; coverage should be neither higher nor lower than nominal."""
        return self.group in ("MAPE", "failures")

    @property
    def is_significant(self) -> bool:
        """Whether the 95 % interval excludes the reference, over the containers that both have."""
        if self.value is None or self.low is None or self.high is None or self.difference is None:
            return False
        return not self.low - self.value <= -self.difference <= self.high - self.value


def summary(
    errors: pd.DataFrame, cells: pd.DataFrame, *, estimates: pd.DataFrame, annotation: pd.DataFrame
) -> tuple[Headline, ...]:
    """A run in a few numbers.

    Args:
        errors: from ``error_table``.
        cells: from ``cell_table`` of ``errors``.
        estimates: the run's table; its columns ``*_low`` and ``*_high`` are the ends of 90 % intervals.
        annotation: the dataset's table.

    Returns:
        The averages of Table 2 in its order (first MAPE, then MPF1), the failures, and the coverage: over all
        quantities, then of each that has intervals. A run without intervals has a coverage without a value.

    Raises:
        ArgumentError: it is no error table, or ``cells`` are not its own.
    """
    if "failed" not in errors or "metric" not in cells:
        raise ArgumentError("errors must come from error_table and cells from cell_table")
    averages = {str(cell["metric"]): cell for cell in cells[cells["container_id"].isna()].to_dict("records")}
    metrics = sorted(QUANTITIES, key=lambda quantity: quantity.is_class)
    failed, total = int(errors["failed"].sum()), len(errors)
    return (
        *(_average(quantity.metric, averages[quantity.metric]) for quantity in metrics),
        _share("failures", ALL, "Failed", failed, total),
        *_coverages(errors, estimates, annotation),
    )


def _average(metric: str, cell: Mapping[Hashable, Any]) -> Headline:
    quantity = BY_METRIC[metric]
    numbers = {name: _known(cell[name]) for name in ("value", "low", "high", "difference")}
    return Headline(
        "MPF1" if quantity.is_class else "MAPE",
        metric,
        quantity.words.capitalize(),
        reference=_known(cell["published"]),
        count=int(cell["recordings"]) - int(cell["failures"]),
        total=int(cell["recordings"]),
        **numbers,
    )


def _coverages(errors: pd.DataFrame, estimates: pd.DataFrame, annotation: pd.DataFrame) -> Sequence[Headline]:
    """Over all quantities, then by quantity."""
    truth = truth_table(annotation).reindex(errors.index)
    own = estimates.set_axis(estimates[ID_COLUMN].map(recording_id))
    table = own[~own.index.duplicated()].reindex(errors.index)
    found = []
    for quantity in (each for each in QUANTITIES if each.name in MEASURED and f"{each.name}_low" in table):
        low, high = (pd.to_numeric(table[f"{quantity.name}_{end}"], errors="coerce") for end in ("low", "high"))
        known = low.notna() & high.notna() & truth[quantity.name].notna() & errors[f"{quantity.name}_judged"]
        is_inside = known & (low <= truth[quantity.name]) & (truth[quantity.name] <= high)
        if known.any():
            counts = int(is_inside.sum()), int(known.sum())
            found.append(
                _share("coverage", quantity.name, quantity.words.capitalize(), *counts, reference=NOMINAL_PERCENT)
            )
    inside, total = (sum(getattr(each, name) for each in found) for name in ("count", "total"))
    whole = _share("coverage", ALL, "Intervals that contain the truth", inside, total, reference=NOMINAL_PERCENT)
    return [whole, *found]


def _share(group: Group, name: str, label: str, count: int, total: int, *, reference: float | None = None) -> Headline:
    """A share of recordings with Wilson's interval; quantities of one recording go wrong together, so none over all."""
    if not total:
        return Headline(group, name, label, None, reference=reference)
    share = count / total
    low: float | None = None
    high: float | None = None
    if group == "failures" or name != ALL:
        squared = _NORMAL**2 / total
        middle = (share + squared / 2) / (1 + squared)
        half = _NORMAL * np.sqrt(share * (1 - share) / total + squared / (4 * total)) / (1 + squared)
        low, high = 100 * float(middle - half), 100 * float(middle + half)
    difference = None if reference is None else 100 * share - reference
    return Headline(group, name, label, 100 * share, low, high, reference, difference, count, total)


def _known(value: float) -> float | None:
    return None if pd.isna(value) else float(value)
