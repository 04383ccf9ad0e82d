"""Tables of estimates without the rows that raise flags."""

from collections.abc import Collection

import pandas as pd

from corsmal.dataset.annotation_file import listed
from corsmal.errors import ArgumentError, check_choice
from corsmal.evaluation.estimates import ID_COLUMN
from corsmal.notes import FLAGS, SEPARATOR

ANY = "any"
"""Stands for all flags."""


def flag_counts(estimates: pd.DataFrame) -> dict[str, int]:
    """How many rows of an estimates table raise each flag, and ``any``; flags that no row raises are left out."""
    raised = [set(str(text).split(SEPARATOR)) & set(FLAGS) for text in estimates.get("flags", ())]
    counts = {ANY: sum(map(bool, raised)), **{flag: sum(flag in each for each in raised) for flag in FLAGS}}
    return {flag: count for flag, count in counts.items() if count}


def without_flagged(estimates: pd.DataFrame, flags: Collection[str]) -> tuple[pd.DataFrame, str]:
    """Leave out the rows of an estimates table that raise certain flags.

    Args:
        estimates: an estimates table; rows without a column ``flags`` raise none.
        flags: of ``notes.FLAGS``, or ``any``.

    Returns:
        The other rows, and one sentence on those that were left out; empty where none was.

    Raises:
        ArgumentError: there is no such flag, or no row is left.
    """
    for flag in flags:
        check_choice("flags", flag, (*FLAGS, ANY))
    wanted = set(FLAGS if ANY in flags else flags)
    if not wanted or "flags" not in estimates:
        return estimates, ""
    raised = estimates["flags"].fillna("").map(lambda text: bool(wanted.intersection(str(text).split(SEPARATOR))))
    if not raised.any():
        return estimates, ""
    if raised.all():
        raise ArgumentError(f"all {len(estimates)} rows raise a flag ({', '.join(flags)}): none is left to evaluate")
    names = estimates.loc[raised, ID_COLUMN].astype(str)
    shown = ", ".join(sorted(wanted)) if ANY not in flags else "any"
    sentence = f"estimates: {raised.sum()} of {len(estimates)} rows raise a flag ({shown}), left out: {listed(names)}"
    return estimates[~raised], sentence
