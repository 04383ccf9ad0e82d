"""Which numbers of an estimates table may be judged: those of networks that have not seen the recording."""

from typing import Literal, get_args

import pandas as pd

from corsmal.errors import check_choice
from corsmal.evaluation.checking import Checked
from corsmal.evaluation.estimates import FALLBACK
from corsmal.quantities import QUANTITIES

Protocol = Literal["held-out", "paper", "in-sample"]
PROTOCOLS: tuple[Protocol, ...] = get_args(Protocol)

STAMPS: dict[Protocol, str] = {
    "held-out": "Held-out: no number comes from a network that was trained on the recording.",
    "paper": "The paper's protocol: no network was trained on the recordings that it is judged on, but the epoch at "
    "which its training stopped was chosen on them.",
    "in-sample": "In-sample: networks are judged on recordings that they were trained on, or may have been. "
    "These numbers say little about new recordings and must not be published as results.",
}
"""What a table says about its protocol."""

BY_NETWORKS = {
    "filling": [quantity for quantity in QUANTITIES if quantity.stage == "filling"],
    "mass": [quantity for quantity in QUANTITIES if quantity.stage == "mass"],
}
"""The quantities that networks predict, by stage. Geometry is fitted, not trained: it is always held out."""

TRAINED = "the network was trained on them"
UNKNOWN = "it is not known what the network was trained on, so it counts as trained on all of them"
CHOSEN = "the epoch of their network was chosen on them (the paper's protocol)"


def left_out(estimates: pd.DataFrame, *, protocol: Protocol = "held-out") -> Checked:
    """Which numbers a protocol leaves out of the tables.

    Args:
        estimates: from ``check_estimates``, whose columns ``filling_held_out``, ``mass_held_out`` and ``protocol`` say
            where the numbers come from. Weights of unknown origin count as trained on every recording.
        protocol: ``held-out``; ``paper``, which admits networks whose epoch was chosen on the judged recordings; or
            ``in-sample``, which leaves nothing out.

    Returns:
        A row per recording, a column per stage (``filling``, ``shape``, ``mass``): whether its numbers are left out;
        and sentences on how many are, and why. For ``in-sample``, on how many would be.

    Raises:
        ArgumentError: the protocol is unknown.
    """
    check_choice("protocol", protocol, PROTOCOLS)
    columns, notes = {"shape": pd.Series(data=False, index=estimates.index)}, []
    for stage, quantities in BY_NETWORKS.items():
        reasons = _reasons(estimates, stage, [quantity.name for quantity in quantities], protocol)
        columns[stage] = reasons.ne("") & (protocol != "in-sample")
        labels = " and ".join(quantity.label for quantity in quantities).capitalize()
        verb = "are in-sample" if protocol == "in-sample" else f"are left out (protocol {protocol})"
        for reason, count in reasons[reasons.ne("")].value_counts().items():
            notes.append(f"{labels}: {count} of {len(reasons)} recordings {verb}: {reason}")
    return Checked(pd.DataFrame(columns), tuple(notes))


def _reasons(estimates: pd.DataFrame, stage: str, names: list[str], protocol: Protocol) -> pd.Series:
    """Why each recording's numbers do not count; empty where they do."""
    reasons = pd.Series("", index=estimates.index, dtype="object")
    is_predicted = estimates[names].notna().any(axis=1)
    if stage == "mass":
        is_predicted &= estimates["status"].ne(FALLBACK)
    if not is_predicted.any():
        return reasons
    held_out = estimates[f"{stage}_held_out"]
    # a recording that failed before its network was reached, or that holds a training mean
    is_silent = held_out.isna() & estimates[f"{stage}_weights"].eq("") & ~is_predicted
    reasons[held_out.isna() & ~is_silent] = UNKNOWN
    reasons[held_out.eq(other=False).fillna(value=False)] = TRAINED
    if protocol == "held-out":
        reasons[held_out.fillna(value=False) & estimates["protocol"].eq("paper")] = CHOSEN
    if not (reasons.eq("") & ~is_silent).any():  # failures without a result beside them are no result
        reasons[is_silent] = reasons[~is_silent].mode()[0]
    return reasons
