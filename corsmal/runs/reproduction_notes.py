"""What a reproduction says about a training set that is too small or too uniform for what it is asked."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from corsmal.filling.records import NAMES

if TYPE_CHECKING:
    from corsmal.mass import MassRow


def filling_notes(known: pd.DataFrame, folds: pd.Series) -> list[str]:
    """Sentences on classes that a network of the cross-validation has not been shown.

    Args:
        known: ``filling_type`` and ``filling_level`` of every recording that is trained on, by recording id.
        folds: the fold of each.

    Returns:
        One for each quantity with a single class, and one for each class that is judged in a fold whose training
        recordings hold none of it.
    """
    notes = []
    for column, names in NAMES.items():
        found, label = known[column].astype(int), column.replace("_", " ")
        if len(set(found)) == 1:
            notes.append(
                f"All {len(found)} recordings have the {label} {names[found.iloc[0]]}: its scores say nothing."
            )
            continue
        for number in sorted(found.unique()):
            own = sorted(folds[found == number].unique())
            if len(own) == 1:
                notes.append(
                    f"The {label} {names[number]} is in fold {own[0]} only: the network that is judged there was not "
                    "shown any, and is wrong on it."
                )
    return notes


def mass_notes(rows: "Sequence[MassRow]", *, share: float) -> list[str]:
    """A sentence on containers with too few recordings for a validation part.

    Args:
        rows: all recordings whose mass is known.
        share: of each container's recordings that is to validate.
    """
    recordings = Counter(container for container, _ in {(row.container, row.recording_id) for row in rows})
    few = sorted(container for container, count in recordings.items() if min(round(share * count), count - 1) == 0)
    if not few:
        return []
    return [
        f"Container {', '.join(few)}: too few recordings for a validation part; the epoch of the mass network is "
        "chosen on the other containers."
    ]
