"""Which rule of the authors' program makes which difference: recordings estimated with one rule after the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from corsmal.dataset import Dataset, Recording
from corsmal.engines.engine import Engine, Row, completed_rows, in_turn, never
from corsmal.errors import CorsmalError
from corsmal.estimation import estimate
from corsmal.parameters import (
    METHOD_VIEWS,
    SELECTION_PRESETS,
    SHAPE_PRESETS,
    SelectionParameters,
    ShapeParameters,
    own_selection,
)
from corsmal.stages.detections import detections_origin, has_detections, load_detections
from corsmal.stages.fits import calibration_fingerprints
from corsmal.stages.version import METHOD_VERSION, READING_VERSION
from corsmal.store import Store, digest

KIND = "rules"

RULES: dict[str, tuple[str, ...]] = {
    "heights": ("circumferences", "height_range"),
    "angles": ("angle_rule",),
    "rounding": ("pixel_rule",),
    "axis": ("triangulation",),
    "width rule": ("width_rule",),
    "height rule": ("height_rule",),
    "pairs": ("pairs",),
    "selection": (),
}
"""The rules in which ``released`` is not ``paper``, and their fields of ``ShapeParameters``; selection has its own."""

ALONE, IN_TURN = "paper with ", "… and "
"""Before a rule's name: where only it is switched, and where those before it are switched, too."""


@dataclass(frozen=True)
class Condition:
    """What recordings are estimated with.

    Args:
        shape: how the hull is fitted and measured.
        selection: how the best frame is found.
    """

    shape: ShapeParameters
    selection: SelectionParameters


def conditions() -> dict[str, Condition]:
    """The presets by name, the paper's with each rule of ``released`` by itself, and with one rule after the other.

    The last of them all has every rule of ``released``.
    """
    found = {name: Condition(shape, SELECTION_PRESETS[own_selection(name)]) for name, shape in SHAPE_PRESETS.items()}
    found |= {f"{ALONE}{rule}": switched(found["paper"], rule) for rule in RULES}
    so_far = found["paper"]
    for rule in RULES:
        so_far = switched(so_far, rule)
        found[f"{IN_TURN}{rule}"] = so_far
    return found


def switched(condition: Condition, rule: str) -> Condition:
    """A condition with one of ``RULES`` as ``released`` has it."""
    if rule == "selection":
        return replace(condition, selection=SelectionParameters.released())
    changes: dict[str, Any] = {name: getattr(ShapeParameters.released(), name) for name in RULES[rule]}
    return replace(condition, shape=replace(condition.shape, **changes))


@dataclass(frozen=True)
class RulesTask:
    """Estimating the geometry of a recording under all conditions; what was estimated is kept.

    Args:
        cache: folder of the store.
    """

    cache: Path

    def __call__(self, recording: Recording) -> Row:
        """The recording's rows by condition; where it cannot be estimated, failed ones with the reason."""
        store = Store(self.cache)
        try:
            key = _key(recording, store)
            kept = store.json(KIND, key)
            if kept is None:
                kept = {"rows": _estimated(recording, store)}
                store.save_json(KIND, key, kept)
        except CorsmalError as error:
            failed = {"recording_id": recording.id, "status": "failed", "notes": str(error)}
            kept = {"rows": dict.fromkeys(conditions(), failed)}
        return {"recording_id": recording.id, "rows": kept["rows"]}


def compare_rules(
    recordings: Sequence[Recording],
    *,
    store: Store,
    engine: Engine = in_turn,
    progress: Callable[[int, int], None] | None = None,
    cancelled: Callable[[], bool] = never,
) -> dict[str, list[Row]]:
    """The geometry of recordings under all ``conditions``, without networks and without training means.

    Detections are beside the videos or in the store. The other arguments are those of ``completed_rows``.

    Returns:
        Rows by condition, in the order of the recordings; of those that were done where the work was cancelled.
    """
    task = RulesTask(store.root.resolve())
    done: dict[str, dict[str, Row]] = {}
    for row in completed_rows(task, recordings, engine=engine, progress=progress, cancelled=cancelled):
        done[row["recording_id"]] = row.get("rows") or dict.fromkeys(conditions(), row)
    return {name: [done[each.id][name] for each in recordings if each.id in done] for name in conditions()}


def load_rules(dataset: Dataset, *, store: Store) -> dict[str, list[Row]] | None:
    """What ``compare_rules`` kept of a dataset's recordings with detections; None where one of them is missing."""
    rows: dict[str, list[Row]] = {name: [] for name in conditions()}
    recordings = comparable(dataset, store=store)
    for recording in recordings:
        kept = store.json(KIND, _key(recording, store))
        if kept is None:
            return None
        for name, own in rows.items():
            own.append(kept["rows"][name])
    return rows if recordings else None


def comparable(dataset: Dataset, *, store: Store) -> list[Recording]:
    """The recordings that can be fitted: with the calibration of two views and detections in them."""
    found = []
    for recording in dataset:
        views = [recording.views[name] for name in METHOD_VIEWS if name in recording.views]
        fitted = [each for each in views if each.calibration_path is not None and has_detections(each, store=store)]
        if len(fitted) > 1:
            found.append(recording)
    return found


def _key(recording: Recording, store: Store) -> str:
    """A digest of all that the rows depend on."""
    reading = [] if recording.is_synthetic else [READING_VERSION]
    made_with = {name: (each.shape, each.selection) for name, each in conditions().items()}
    origin = detections_origin(recording, store=store)
    return digest(KIND, METHOD_VERSION, recording.id, origin, calibration_fingerprints(recording), made_with, *reading)


def _estimated(recording: Recording, store: Store) -> dict[str, Row]:
    """Rows by condition; what is the same under two conditions is estimated once."""
    detections = load_detections(recording, store=store).views
    rows: dict[Condition, Row] = {}
    for condition in conditions().values():
        if condition not in rows:
            shape, selection = condition.shape, condition.selection
            rows[condition] = estimate(recording, detections=detections, shape=shape, selection=selection).row()
    return {name: rows[condition] for name, condition in conditions().items()}
