"""Estimates under several conditions side by side, and what each rule that is switched changes."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from corsmal.evaluation.attribution import attribution_table
from corsmal.evaluation.published import paper_table_2
from corsmal.evaluation.recordings import error_table
from corsmal.evaluation.tables import AVERAGE, container_table
from corsmal.quantities import BY_NAME, GEOMETRY

PUBLISHED = "published"
"""The condition that is the paper's Table 2."""

SHAPE_METRICS = tuple(BY_NAME[name].metric for name in GEOMETRY)


def side_by_side(estimates: Mapping[str, pd.DataFrame], annotation: pd.DataFrame) -> pd.DataFrame:
    """The MAPE of capacity and dimensions under several conditions, beside the published ones.

    Args:
        estimates: estimates tables by condition.
        annotation: a dataset's table, or the columns of the annotation file.

    Returns:
        A row per metric, container, ``Average`` last, and condition, the published one first: ``metric``,
        ``container_id``, ``container``, ``condition``, ``error`` (MAPE, %), ``signed`` (the mean of the signed errors,
        %; NaN for published ones), ``recordings`` (that have an error) and ``failures``. The published average is that
        of all nine containers; a container that the paper does not have has no published row.

    Raises:
        ArgumentError: a table has no recording in common with the annotation.
    """
    parts: list[dict[str, Any]] = []
    for name, table in estimates.items():
        errors = error_table(table, annotation)
        for row in container_table(errors).to_dict("records"):
            own = errors if row["container"] == AVERAGE else errors[errors["container_id"] == row["container_id"]]
            for quantity in GEOMETRY:
                found = own[BY_NAME[quantity].error_column]
                signed = _mean_of_containers(own, quantity)
                counts = {"recordings": int(found.notna().sum()), "failures": row["failures"]}
                parts.append(_row(row, quantity, name) | {"signed": signed, **counts})
    known = {row["container"]: row["container_id"] for row in parts}
    published = [
        _row(row, quantity, PUBLISHED) | {"container": container}
        for row in paper_table_2().to_dict("records")
        for container, number in known.items()
        for quantity in GEOMETRY
        if (row["container"] == container == AVERAGE) or (pd.notna(number) and row["container_id"] == number)
    ]
    table = pd.DataFrame(published + parts)
    order = {name: place for place, name in enumerate((*known, PUBLISHED))}
    table["place"] = table["container"].map(order)
    metrics = {metric: place for place, metric in enumerate(SHAPE_METRICS)}
    table["metric_place"] = table["metric"].map(metrics)
    table = table.sort_values(["metric_place", "place"], kind="stable", ignore_index=True)
    return table.drop(columns=["place", "metric_place"]).astype({"container_id": "Int64"})


def average_errors(table: pd.DataFrame, conditions: Sequence[str]) -> pd.DataFrame:
    """The averages over containers under some conditions.

    Args:
        table: from ``side_by_side``.
        conditions: the rows, in their order; those that the table does not have are left out.

    Returns:
        A row per condition, which the index ``method`` names: ``SHAPE_METRICS``, MAPE in %, each followed by the mean
        signed error in %, ``height_signed_percent`` for ``height_mape``.
    """
    rows = table[(table["container"] == AVERAGE) & table["condition"].isin(list(conditions))]
    columns: dict[str, pd.Series] = {}
    for metric in SHAPE_METRICS:
        own = rows[rows["metric"] == metric].set_index("condition")
        columns |= {metric: own["error"], f"{metric.removesuffix('_mape')}_signed_percent": own["signed"]}
    found = pd.DataFrame(columns)
    return found.reindex([name for name in conditions if name in found.index]).rename_axis("method")


def average_texts(averages: pd.DataFrame) -> pd.DataFrame:
    """The rows of ``average_errors`` as texts, a column per quantity: its MAPE, the mean signed error in brackets."""
    found = pd.DataFrame(index=averages.index)
    for name in GEOMETRY:
        metric = BY_NAME[name].metric
        pairs = zip(averages[metric], averages[f"{metric.removesuffix('_mape')}_signed_percent"], strict=True)
        texts = [f"{error:.1f}" + ("" if pd.isna(signed) else f" ({signed:+.1f})") for error, signed in pairs]
        found[BY_NAME[name].label] = [text.replace("-", "−").replace("nan", "–") for text in texts]
    return found


def rule_effects(
    base: pd.DataFrame, switched: Mapping[str, pd.DataFrame], annotation: pd.DataFrame, *, rng: np.random.Generator
) -> pd.DataFrame:
    """How much each rule, switched by itself, changes the errors of capacity and dimensions.

    Args:
        base: the estimates table without any rule switched.
        switched: estimates tables by the name of the rule that is switched.
        annotation: as above.
        rng: draws the recordings of the bootstrap.

    Returns:
        Rows of ``attribution_table`` for the average over containers, its ``stage`` named ``rule``.

    Raises:
        ArgumentError: as above.
    """
    table = attribution_table(base, switched, annotation, rng=rng)
    chosen = table["metric"].isin(SHAPE_METRICS) & (table["container"] == AVERAGE) & table["stage"].isin(list(switched))
    return table[chosen].rename(columns={"stage": "rule"}).reset_index(drop=True)


def height_sentence(table: pd.DataFrame, *, height_rule: str) -> str:
    """How far the authors' height rule explains the published error of the height.

    Args:
        table: from ``side_by_side``, with the conditions ``paper``, ``released`` and ``height_rule``.
        height_rule: the condition in which only the height rule is switched.
    """
    rows = table[(table["metric"] == BY_NAME["height_mm"].metric) & (table["container"] == AVERAGE)]
    rows = rows.set_index("condition")
    errors, signed = rows["error"], rows["signed"]
    published = errors[PUBLISHED]
    text = (
        f"The published error of the height is {published:.1f} %. Here `paper` has {errors['paper']:.1f} % (mean "
        f"signed error {signed['paper']:+.1f} %), with only the height rule of `released` {errors[height_rule]:.1f} % "
        f"({signed[height_rule]:+.1f} %), and `released` {errors['released']:.1f} % ({signed['released']:+.1f} %). "
    )
    by_rule, by_all = errors[height_rule] - errors["paper"], errors["released"] - errors["paper"]
    text += f"Between `paper` and `released` lie {by_all:+.1f} points; the height rule by itself makes {by_rule:+.1f}."
    return text.replace("-", "−")


def _row(row: Mapping[Any, Any], quantity: str, condition: str) -> dict[str, Any]:
    metric = BY_NAME[quantity].metric
    where = {name: row[name] for name in ("container_id", "container")}
    return {"metric": metric, **where, "condition": condition, "error": row[metric]}


def _mean_of_containers(errors: pd.DataFrame, quantity: str) -> float:
    """The mean over containers of a quantity's mean signed error, %."""
    return float(errors.groupby("container_id")[BY_NAME[quantity].error_column].mean().mean())
