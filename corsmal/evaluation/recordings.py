"""Estimates beside the truth, recording by recording: what every table is made from, and what lies behind its cells."""

import pandas as pd

from corsmal.evaluation.checking import listed, truth_table
from corsmal.evaluation.estimates import ABSENT, FAILED, check_estimates
from corsmal.evaluation.metrics import CLASS_NAMES, relative_errors
from corsmal.evaluation.protocols import BY_NETWORKS, STAMPS, Protocol, left_out
from corsmal.quantities import BY_NAME, MEASURED, QUANTITIES


def error_table(estimates: pd.DataFrame, annotation: pd.DataFrame, *, protocol: Protocol = "held-out") -> pd.DataFrame:
    """How far off each estimate is.

    Args:
        estimates: with columns of ``ESTIMATE_COLUMNS``; all but ``recording_id`` may be absent.
        annotation: a dataset's table, or the columns of the annotation file.
        protocol: which numbers of networks are judged, see ``left_out``.

    Returns:
        Indexed by ``recording_id``, the recordings that both have:

        - ``container_id``, ``container``, ``kind``; the estimate's ``status``, ``pair``, ``notes`` and ``best_frame``;
        - ``failed``: the container could not be measured, or there is no estimate of something that the run estimates;
        - ``protocol``, and ``filling_left_out`` and ``mass_left_out``: the protocol leaves the stage's numbers out;
        - for each number, with ``_judged``: whether it counts, even if as a failure: its truth is known, the run
          estimates it and the protocol does not leave it out;
        - ``*_error_percent``: 100 (estimate − truth) / truth, NaN where it is not judged or there is no estimate.
          Training means that stand in for a failed fit are estimates like others: ``failed`` tells them apart;
        - ``filling_type``, ``filling_level`` (predicted), the same with ``_true``, with ``_correct``: NA where it is
          not judged; false where there is no answer; and with ``_confidence``: the probability of the predicted class,
          NaN where it is not known;
        - ``filling_mass_error_g``: estimate − truth, NaN where either is missing or the filling is left out.

        ``attrs["notes"]`` holds sentences on what was missing or left out.

    Raises:
        ArgumentError: a table has no ids, they have no recording in common, or the protocol is unknown.
    """
    known = truth_table(annotation)
    checked = check_estimates(estimates, known.index)
    table, truth = checked.table, known.loc[checked.table.index]
    excluded = left_out(table, protocol=protocol)
    notes = [*([] if protocol == "held-out" else [STAMPS[protocol]]), *excluded.notes, *checked.notes]
    is_filmed = table["status"].ne(ABSENT)
    is_failed = table["status"].isin(FAILED)
    for name in (*MEASURED, *CLASS_NAMES):
        if table[name].notna().any():
            is_failed |= table[name].isna() & (is_filmed | (name in CLASS_NAMES))
        else:
            what = f"there is no {BY_NAME[name].words} for any recording"
            notes.append(f"estimates: {what}; its cells are empty and it counts no failure")
        notes += _unknown(truth[name])
    columns = {name: truth[name] for name in ("container_id", "container", "kind")}
    columns |= {name: table[name] for name in ("status", "pair", "notes")}
    columns |= {"best_frame": table["best_frame"].round().astype("Int64"), "failed": is_failed}
    columns |= {f"{stage}_left_out": excluded.table[stage] for stage in BY_NETWORKS}
    for quantity in QUANTITIES:
        name = quantity.name
        judged = truth[name].notna() & bool(table[name].notna().any()) & ~excluded.table[quantity.stage]
        judged &= is_filmed | quantity.is_class
        if quantity.is_class:
            columns[name] = table[name].astype("Int64")
            columns[f"{name}_true"] = truth[name].astype("Int64")
            columns[f"{name}_correct"] = (table[name] == truth[name]).astype("boolean").where(judged)
            columns[f"{name}_confidence"] = _confidence(table, name)
            continue
        # A relative error needs a truth: where it is unknown, 1 stands in until the error is taken away again.
        errors = pd.Series(relative_errors(table[name], truth[name].fillna(1.0)), index=table.index)
        columns |= {f"{name}_judged": judged, quantity.error_column: errors.where(judged)}
    filling_mass = table["filling_mass_g"].where(~excluded.table["filling"])
    columns["filling_mass_error_g"] = filling_mass - truth["filling_mass_g"]
    result = pd.DataFrame(columns, index=table.index).assign(protocol=protocol)
    result.attrs["notes"] = tuple(notes)
    return result


def _confidence(table: pd.DataFrame, name: str) -> pd.Series:
    """The probability of the predicted class; NaN where there is none, or what stands there is no probability."""
    head, found = name.removeprefix("filling_"), pd.Series(float("nan"), index=table.index)
    for number in range(len(CLASS_NAMES[name])):
        found = found.mask(table[name] == number, table[f"{head}_p{number}"])
    return found.where(found.between(0, 1))


def _unknown(truth: pd.Series) -> list[str]:
    absent, what = truth.index[truth.isna()], BY_NAME[str(truth.name)].words
    if len(absent) == 0:
        return []
    if len(absent) == len(truth):
        return [f"annotation: there is no truth of the {what}: its estimates cannot be judged"]
    return [f"annotation: there is no {what} of {listed(absent)}: it cannot be judged there"]
