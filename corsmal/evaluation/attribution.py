"""Which stage an error comes from: the same run with one stage after the other replaced by the truth."""

from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np
import pandas as pd

from corsmal.dataset.annotation import DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.evaluation.checking import truth_table
from corsmal.evaluation.estimates import ID_COLUMN, check_estimates
from corsmal.evaluation.tables import METRICS, container_table
from corsmal.quantities import GEOMETRY

KnownStage = Literal["dimensions", "filling", "container mass"]
KNOWN_STAGES: tuple[KnownStage, ...] = get_args(KnownStage)
"""The stages whose results an annotation knows."""

_COLUMNS: dict[KnownStage, tuple[str, ...]] = {
    "dimensions": GEOMETRY,
    "filling": ("filling_type", "filling_level"),
    "container mass": ("container_mass_g",),
}


def with_true(estimates: pd.DataFrame, annotation: pd.DataFrame, stage: KnownStage) -> pd.DataFrame:
    """Estimates as they would be if one stage made no error.

    Args:
        estimates: an estimates table.
        annotation: a dataset's table, or the columns of the annotation file.
        stage: what is taken from the annotation: capacity, widths and height; filling type and level; or the
            container's mass. The masses of filling and object follow from the new numbers. The container's mass does
            not follow from the dimensions here: that takes the network.

    Returns:
        An estimates table of the recordings that both have; what the annotation does not know stays as estimated.

    Raises:
        ArgumentError: the stage is unknown, a table has no ids, or they have no recording in common.
    """
    if stage not in KNOWN_STAGES:
        raise ArgumentError(f"stage must be one of {', '.join(KNOWN_STAGES)}, got {stage!r}")
    known = truth_table(annotation)
    table = check_estimates(estimates, known.index).table
    truth = known.loc[table.index]
    table = table.assign(**{name: truth[name].fillna(table[name]) for name in _COLUMNS[stage]})
    if stage != "dimensions":  # the truth comes from no network
        table[f"{'mass' if stage == 'container mass' else stage}_held_out"] = True
    fraction = table["filling_level"].map(dict(enumerate(LEVEL_FRACTIONS)))
    density = table["filling_type"].map(dict(enumerate(DENSITIES_G_PER_ML)))
    filling_mass = fraction * table["capacity_ml"] * density
    table["filling_mass_g"] = filling_mass
    table["object_mass_g"] = table["container_mass_g"] + filling_mass
    return table.rename_axis(ID_COLUMN).reset_index()


def blame_table(runs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """How much of each error goes away with each stage replaced.

    Args:
        runs: error tables by name: first the run as it is, then the same with one stage replaced by the truth.

    Returns:
        A row per replaced stage and container, ``Average`` last: ``stage``, ``container_id``, ``container``, and for
        every metric of Table 2 its value with that stage replaced (in %) and, with ``_removed``, the part of the
        shortfall that is gone, in %: 100 when nothing is left of it, negative when it grew. The shortfall is the MAPE,
        or what MPF1 lacks to 100. NaN where there was none, or no number.

    Raises:
        ArgumentError: there is no replaced stage, or a table is no error table.
    """
    if len(runs) < 2:
        raise ArgumentError(f"runs must hold the run as it is and one with a stage replaced, got {len(runs)} tables")
    (_, as_is), *replaced = runs.items()
    before = container_table(as_is)
    parts = []
    for stage, errors in replaced:
        after = container_table(errors).set_index("container_id").reindex(before["container_id"]).reset_index(drop=True)
        part = before[["container_id", "container"]].copy()
        part.insert(0, "stage", stage)
        for metric in METRICS:
            old, new = (table[metric] if metric.endswith("_mape") else 100 - table[metric] for table in (before, after))
            part[metric] = after[metric]
            part[f"{metric}_removed"] = (100 * (old - new) / old.where(old > 0)).replace([np.inf, -np.inf], np.nan)
        parts.append(part)
    return pd.concat(parts, ignore_index=True)
