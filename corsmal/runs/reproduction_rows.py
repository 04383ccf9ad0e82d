"""The rows of a reproduction: geometry, filling and mass of every recording, with who may be judged by them."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from corsmal.evaluation import estimates_table
from corsmal.evaluation.estimates import ABSENT
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES
from corsmal.mass import filling_mass_g
from corsmal.quantities import MEASURED


def reproduction_rows(
    geometry: pd.DataFrame,
    filling: pd.DataFrame | None,
    mass: pd.DataFrame | None,
    *,
    recordings: pd.Index,
    protocol: str,
) -> pd.DataFrame:
    """An estimates table of what each stage says of recordings that its network has not seen.

    Args:
        geometry: estimates without networks, of the recordings that were filmed.
        filling: predictions of one seed, from ``cross_validate``; None where nothing could be trained.
        mass: predictions of one seed, from ``cross_validate_mass``, or of the paper's own split; None likewise.
        recordings: ids of all annotated recordings.
        protocol: ``held-out`` or ``paper``; the rows of the latter say so.

    Returns:
        An estimates table, a row for each of ``recordings``; one that was not filmed is ``absent``, which is no
        failure. Container masses are those of ``mass`` only: a training mean is not a prediction.
    """
    measured = geometry.set_index("recording_id")
    heard = {} if filling is None else filling.set_index("recording_id").to_dict("index")
    weighed = {} if mass is None else mass.set_index("recording_id").to_dict("index")
    rows = []
    for name in recordings:
        row: dict[str, Any] = {"recording_id": name, "status": ABSENT, "notes": "no video of the method's views"}
        if name in measured.index:
            row = {"recording_id": name, **measured.loc[name].to_dict(), "container_mass_g": None}
        row |= _heard(heard.get(name)) | _weighed(weighed.get(name))
        row["protocol"] = "paper" if protocol == "paper" else ""
        rows.append(row | _masses(row))
    return estimates_table(rows)


def _heard(prediction: Mapping[Any, Any] | None) -> dict[str, Any]:
    if prediction is None:
        return {}
    return {
        "filling_type": _number(prediction["predicted_type"]),
        "filling_level": _number(prediction["predicted_level"]),
        **{f"type_p{index}": prediction[f"p_{name}"] for index, name in enumerate(TYPE_NAMES)},
        **{f"level_p{index}": prediction[f"p_{name}"] for index, name in enumerate(LEVEL_NAMES)},
        "filling_weights": f"fold {prediction['fold']}, seed {prediction['seed']}",
        "filling_held_out": True,
    }


def _weighed(prediction: Mapping[Any, Any] | None) -> dict[str, Any]:
    if prediction is None:
        return {}
    return {
        "container_mass_g": _number(prediction["mass_g"]),
        "mass_weights": f"fold {prediction['fold']}, seed {prediction['seed']}",
        "mass_held_out": True,
    }


def _masses(row: Mapping[str, Any]) -> dict[str, Any]:
    kind, level = row.get("filling_type"), row.get("filling_level")
    if kind is None or level is None:
        return {}
    filling_g = filling_mass_g(int(kind), int(level), capacity_ml=_number(row.get(MEASURED[0])))
    container_g = row.get("container_mass_g")
    whole_g = None if container_g is None or filling_g is None else container_g + filling_g
    return {"filling_mass_g": filling_g, "object_mass_g": whole_g}


def _number(value: Any) -> float | None:
    return None if value is None or pd.isna(value) else float(value)
