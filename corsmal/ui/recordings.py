"""The tables of the pages."""

from collections.abc import Iterable, Mapping

import pandas as pd

from corsmal.dataset import Recording
from corsmal.detection import Detections, filter_detections
from corsmal.figures.overlay import class_name
from corsmal.parameters import CentreRule

UNKNOWN = "unknown"
LACKS = {None: "all that are known", "video": "with a video here", "complete": "lacking nothing"}
"""Which recordings to list, by what is on disk."""
SCENARIOS = {0: "on the table", 1: "held", 2: "brought in"}


def recording_labels(table: pd.DataFrame) -> dict[str, str]:
    """Each recording in one line, by id: container, filling and level, as far as they are known."""
    known = (table[column].to_numpy(dtype=object, na_value="") for column in ("container", "filling", "level"))
    labels = {}
    for name, container, filling, level in zip(table.index.to_numpy(dtype=object), *known, strict=True):
        content = "empty" if filling == "none" else ", ".join(filter(None, (filling, level)))
        labels[name] = " · ".join(filter(None, (name, container, content)))
    return labels


def most_complete(table: pd.DataFrame) -> str:
    """The id of the first recording that lacks the least: what to show before anything was chosen."""
    return str(table["missing"].str.count(",").where(table["missing"] != "", -1).idxmin())


def recordings_table(table: pd.DataFrame) -> pd.DataFrame:
    """A dataset's table as people read it: names for numbers, ``unknown`` for what the annotation does not say.

    Args:
        table: ``Dataset.table``.

    Returns:
        Columns container, kind, filling, level, scenario, capacity_ml, width_top_mm, width_bottom_mm, height_mm,
        container_mass_g and missing, indexed by recording id.
    """
    shown = table[["container", "kind", "filling", "level"]].astype("string").fillna(UNKNOWN)
    shown["scenario"] = table["scenario"].map(SCENARIOS).astype("string").fillna(UNKNOWN)
    numbers = ["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"]
    return shown.join(table[["missing", *numbers]])


def filter_table(shown: pd.DataFrame, *, chosen: Mapping[str, Iterable[str]], lacks: str | None = None) -> pd.DataFrame:
    """The rows whose columns hold one of the chosen values; an empty choice keeps all.

    Args:
        shown: from ``recordings_table``.
        chosen: values by column.
        lacks: a key of ``LACKS``.
    """
    keep = pd.Series(data=True, index=shown.index)
    for column, values in chosen.items():
        if values := list(values):
            keep &= shown[column].isin(values)
    missing = shown["missing"]
    if lacks == "complete":
        keep &= missing == ""
    elif lacks is not None:
        keep &= ~missing.str.contains("view1 video, view2 video, view3 video", regex=False)
    return shown[keep]


def detections_table(detections: Detections, *, centre_rule: CentreRule) -> pd.DataFrame:
    """The detections of one frame of one view: what each is, and why it was dropped."""
    filtered = filter_detections(detections, centre_rule=centre_rule)
    verdicts = [
        reason or ("the container" if index == filtered.container else "kept")
        for index, reason in enumerate(filtered.reasons)
    ]
    return pd.DataFrame(
        {
            "verdict": verdicts,
            "class": [class_name(int(label)) for label in detections.labels],
            "score": detections.scores,
            "mask (px)": detections.mask_areas,
        },
        index=pd.RangeIndex(1, len(detections) + 1, name="no."),
    )


def truth(recording: Recording) -> dict[str, float]:
    """The annotated capacity (mL), widths and height (mm) of a recording, as far as they are known."""
    annotation = recording.annotation
    names = ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm")
    values = {name: getattr(annotation, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def truth_profile_mm(recording: Recording) -> tuple[float, float, float] | None:
    """Annotated bottom width, top width and height, mm; None unless all are known."""
    values = truth(recording)
    names = ("width_bottom_mm", "width_top_mm", "height_mm")
    return (values[names[0]], values[names[1]], values[names[2]]) if values.keys() >= set(names) else None
