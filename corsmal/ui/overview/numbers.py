"""The numbers of the estimate over the whole recording, each with its interval, the truth and the error."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from corsmal.dataset import Annotation
from corsmal.dataset.annotation import FILLINGS, LEVELS
from corsmal.estimation import Estimate
from corsmal.estimation.filling_mass import filling_mass_interval_g
from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.ui.amounts import amount, filling_text, grams, mass_error, mass_interval, percent_error, total
from corsmal.weights import RELEASED

NOTHING, LEFT_OUT = "–", "left out"
NOT_ANNOTATED = "no annotation"
SEEN_IN_TRAINING = "not held out: the network was trained on this recording"
UNKNOWN_TRAINING = "not held out: the network's file does not say what it was trained on"

CLASSES = {"type": len(FILLINGS), "level": len(LEVELS)}

ASSUMED = {
    "mass-assumed": "the training set's: the network had no answer",
    "dimensions-assumed": "from mean dimensions: nothing was fitted",
}
"""How a container's mass came about, by the flag of its row."""


@dataclass(frozen=True)
class Tile:
    """One number as the page shows it.

    Args:
        label: what it is.
        page: that explains it.
        value: with its unit; ``NOTHING`` or ``LEFT_OUT`` where there is none.
        interval: how sure it is.
        verdict: the truth and the error, or why there is no value.
    """

    label: str
    page: str
    value: str = "…"
    interval: str = "being computed"
    verdict: str = ""


PENDING = (
    Tile("Filling", "filling"),
    *(Tile(BY_NAME[name].label, "shape") for name in GEOMETRY[:1]),
    Tile("Filling mass", "mass"),
    Tile("Object mass", "mass"),
    *(Tile(BY_NAME[name].label, "shape") for name in GEOMETRY[1:]),
    Tile("Container mass", "mass"),
)
"""All tiles in their order, before anything is known."""


def shape_tiles(found: Estimate, annotation: Annotation | None, *, is_inspected: bool) -> list[Tile]:
    """Capacity, widths and height.

    Args:
        found: the estimate.
        annotation: of the recording.
        is_inspected: whether there are detections at all.
    """
    return [_shape_tile(name, found, annotation, is_inspected) for name in GEOMETRY]


def _shape_tile(name: str, found: Estimate, annotation: Annotation | None, is_inspected: bool) -> Tile:
    label, value, true = BY_NAME[name].label, getattr(found, name), getattr(annotation, name, None)
    truth = NOT_ANNOTATED if true is None else f"annotated {BY_NAME[name].text(true)}"
    if not is_inspected or value is None:
        return Tile(label, "shape", NOTHING, "not fitted" if is_inspected else "no detections yet", truth)
    if found.fit is None:
        interval = "training mean: nothing was fitted"
    elif name in found.intervals:
        low, high = found.intervals[name]
        interval = f"90 % interval {low:.0f}–{high:.0f} {BY_NAME[name].unit}"
    else:
        interval = "one frame: no interval"
    return Tile(label, "shape", amount(name, value), interval, _with_error(truth, value, true))


def _with_error(truth: str, value: float, true: float | None) -> str:
    return f"{truth}, error {percent_error(value, true)}" if true else truth


def network_tiles(row: Mapping[str, Any], annotation: Annotation | None, *, left_out: Mapping[str, str]) -> list[Tile]:
    """Filling and masses.

    Args:
        row: of a run, see ``corsmal.stages.estimates.estimate_row``.
        annotation: of the recording.
        left_out: why a network is left out, by ``filling`` and ``mass``.
    """
    return [_filling_tile(row, annotation, left_out), *_mass_tiles(row, annotation, left_out)]


def _filling_tile(row: Mapping[str, Any], annotation: Annotation | None, left_out: Mapping[str, str]) -> Tile:
    true = _annotated_filling(annotation)
    truth = NOT_ANNOTATED if true is None else f"annotated: {filling_text(*true)}"
    if not row["filling_weights"]:
        return Tile("Filling", "filling", LEFT_OUT, "", left_out.get("filling", ""))
    kind, level = row["filling_type"], row["filling_level"]
    if kind is None or level is None:
        return Tile("Filling", "filling", NOTHING, "no prediction", _reason(row, "filling"))
    sure = ", ".join(
        f"{name} {100 * share:.0f} %"
        for name, share in ((FILLINGS[kind], row[f"type_p{kind}"]), (LEVELS[level], row[f"level_p{level}"]))
    )
    if true is not None:
        truth = f"{'✓' if filling_text(*true) == filling_text(kind, level) else '✗'} {truth}"
    return Tile("Filling", "filling", filling_text(kind, level), sure, _stamped(truth, row, "filling"))


def _reason(row: Mapping[str, Any], name: str) -> str:
    """Why a network has no answer, from the row's notes."""
    notes = str(row["notes"]).split("; ")
    return next((note.removeprefix(f"{name}: ") for note in notes if note.startswith(f"{name}: ")), "")


def _annotated_filling(annotation: Annotation | None) -> tuple[int, int] | None:
    if annotation is None or annotation.filling_type is None or annotation.filling_level is None:
        return None
    return annotation.filling_type, annotation.filling_level


def _mass_tiles(row: Mapping[str, Any], annotation: Annotation | None, left_out: Mapping[str, str]) -> list[Tile]:
    container_true, filling_true = (getattr(annotation, name, None) for name in ("container_mass_g", "filling_mass_g"))
    filling, mass = left_out.get("filling", ""), left_out.get("mass", "")
    container = "" if str(row["status"]).startswith("fitted") else "training mean: nothing was fitted"
    container = next((text for flag, text in ASSUMED.items() if flag in str(row.get("flags", ""))), container)
    tiles = [
        _mass_tile("Filling mass", row["filling_mass_g"], filling_true, filling, note=_filling_interval(row)),
        _mass_tile(
            "Object mass",
            row["object_mass_g"],
            total(container_true, filling_true),
            filling or mass,
            note="container + filling",
        ),
        _mass_tile("Container mass", row["container_mass_g"], container_true, mass, note=container),
    ]
    return [*tiles[:-1], replace(tiles[-1], verdict=_stamped(tiles[-1].verdict, row, "mass"))]


def _filling_interval(row: Mapping[str, Any]) -> str:
    """Where the filling's mass lies; how it was computed, where a probability or the capacity is not known."""
    types, levels = ([row[f"{head}_p{number}"] for number in range(count)] for head, count in CLASSES.items())
    capacity_ml, ends = row["capacity_ml"], (row.get("capacity_ml_low"), row.get("capacity_ml_high"))
    if None in (*types, *levels, capacity_ml):
        return "level × capacity × density"
    low, high = ends
    interval_ml = None if low is None or high is None else (low, high)
    return mass_interval(filling_mass_interval_g(types, levels, capacity_ml, capacity_interval_ml=interval_ml))


def _mass_tile(label: str, value: float | None, true: float | None, left_out: str, *, note: str) -> Tile:
    if value is not None:
        return Tile(label, "mass", grams(value), note, mass_error(value, true))
    if left_out:
        return Tile(label, "mass", LEFT_OUT, "", left_out)
    return Tile(label, "mass", NOTHING, "not estimated", NOT_ANNOTATED if true is None else f"annotated {grams(true)}")


def _stamped(verdict: str, row: Mapping[str, Any], name: str) -> str:
    if str(row.get(f"{name}_weights")).startswith(RELEASED):
        return f"{verdict}; {UNKNOWN_TRAINING}"
    return f"{verdict}; {SEEN_IN_TRAINING}" if row.get(f"{name}_held_out") is False else verdict
