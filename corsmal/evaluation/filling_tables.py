"""Cross-validated filling predictions as tables: how well, on which containers, and how much it varies."""

import pandas as pd

from corsmal.dataset.annotation import CONTAINERS, Kind
from corsmal.errors import ArgumentError, check_choice
from corsmal.evaluation.metrics import CLASS_NAMES, class_numbers, confusion, joint_classes, mpf1, weighted_f1
from corsmal.evaluation.tables import AVERAGE, KINDS
from corsmal.filling.records import PREDICTION_COLUMNS

TRUE = {"filling_level": "true_level", "filling_type": "true_type"}
PREDICTED = {"filling_level": "predicted_level", "filling_type": "predicted_type"}
"""The columns of ``PREDICTION_COLUMNS`` with a quantity's true and predicted classes."""


def pooled_table(predictions: pd.DataFrame) -> pd.DataFrame:
    """Weighted F1 of level, type and both together, in %, pooled over the folds of ``PREDICTION_COLUMNS``.

    Returns:
        A row per seed and two more, ``mean`` and ``std`` (between seeds, NaN for one): ``seed`` (text),
        ``filling_level``, ``filling_type``, ``joint`` and ``recordings`` (that have a row).

    Raises:
        ArgumentError: a column is missing, a class has no number, or a seed predicts a recording twice.
    """
    rows = []
    for seed, group in checked_predictions(predictions).groupby("seed"):
        scores = {name: weighted_f1(group[TRUE[name]], group[PREDICTED[name]]) for name in TRUE}
        joint = [joint_classes(group[f"{side}_type"], group[f"{side}_level"]) for side in ("true", "predicted")]
        rows.append({"seed": str(seed), **scores, "joint": weighted_f1(*joint), "recordings": len(group)})
    table = pd.DataFrame(rows)
    numbers = table.drop(columns="seed")
    summary = pd.DataFrame([numbers.mean(), numbers.std()]).assign(seed=["mean", "std"])
    return pd.concat([table, summary], ignore_index=True)


def filling_container_table(predictions: pd.DataFrame) -> pd.DataFrame:
    """MPF1 of level and type by container, in %: mean and standard deviation between seeds.

    Args and errors are those of ``pooled_table``.

    Returns:
        A row per container and ``Average`` (over containers, before the mean over seeds): ``container_id``,
        ``container``, ``filling_level_mpf1``, ``filling_type_mpf1``, both again with ``_std`` (NaN for one seed), and
        ``recordings``.
    """
    rows = []
    for (number, seed), group in checked_predictions(predictions).groupby(["container_id", "seed"]):
        scores = {f"{name}_mpf1": mpf1(group[TRUE[name]], group[PREDICTED[name]]) for name in TRUE}
        rows.append({"container_id": number, "seed": seed, **scores, "recordings": len(group)})
    by_seed = pd.DataFrame(rows)
    metrics = [f"{name}_mpf1" for name in TRUE]
    average = by_seed.groupby("seed")[metrics].mean()
    by_container = by_seed.groupby("container_id")
    table = pd.concat([by_container[metrics].mean(), by_container[metrics].std().add_suffix("_std")], axis=1)
    table["recordings"] = by_container["recordings"].max()
    table.insert(0, "container", [CONTAINERS.get(number, (f"container {number}",))[0] for number in table.index])
    last = {"container": AVERAGE, **average.mean(), **average.std().add_suffix("_std")}
    last["recordings"] = table["recordings"].sum()
    return pd.concat([table.reset_index(), pd.DataFrame([last])], ignore_index=True).astype({"container_id": "Int64"})


def filling_confusion_tables(predictions: pd.DataFrame, quantity: str) -> dict[Kind, pd.DataFrame]:
    """The confusion matrices of ``filling_type`` or ``filling_level`` by kind of container, summed over seeds.

    Containers that are none of the training set's are in none, see ``confusion``.

    Raises:
        ArgumentError: as ``pooled_table``, or the quantity is no class.
    """
    check_choice("quantity", quantity, CLASS_NAMES)
    known = checked_predictions(predictions)
    kinds = known["container_id"].map(lambda number: CONTAINERS.get(number, ("", ""))[1])
    tables: dict[Kind, pd.DataFrame] = {}
    for kind in KINDS:
        rows = known[kinds == kind]
        tables[kind] = confusion(rows[TRUE[quantity]], rows[PREDICTED[quantity]], CLASS_NAMES[quantity])
    return tables


def checked_predictions(predictions: pd.DataFrame) -> pd.DataFrame:
    """The predictions of a cross-validation; errors are those of ``pooled_table``."""
    if not isinstance(predictions, pd.DataFrame) or not len(predictions):
        raise ArgumentError("predictions must be a table with at least one row")
    absent = [name for name in PREDICTION_COLUMNS if name not in predictions]
    if absent:
        raise ArgumentError(
            f"predictions must have the columns {', '.join(PREDICTION_COLUMNS)}; it lacks {absent[0]!r}"
        )
    repeated = predictions.duplicated(["recording_id", "seed"])
    if repeated.any():
        name, seed = predictions.loc[repeated, ["recording_id", "seed"]].iloc[0]
        raise ArgumentError(f"predictions must have one row per recording and seed, got {name} twice for seed {seed}")
    for quantity, names in CLASS_NAMES.items():
        for column in (TRUE[quantity], PREDICTED[quantity]):
            numbers = class_numbers(predictions[column], name=column)
            if (numbers.min() < 0 and column == TRUE[quantity]) or numbers.max() >= len(names):
                raise ArgumentError(f"predictions: {column} must be a number from 0 to {len(names) - 1}")
    return predictions
