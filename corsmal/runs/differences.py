"""What two or more runs were made with, where they differ."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import pandas as pd

from corsmal.errors import ArgumentError
from corsmal.parameters import HeightRange
from corsmal.runs.run import Run
from corsmal.store import digest

SHAPE = "shape."
"""Stands before the parameters of the fit."""


def parameter_differences(runs: Sequence[Run]) -> pd.DataFrame:
    """What runs were made with, where they differ.

    Args:
        runs: two or more.

    Returns:
        A row per difference, indexed by ``parameter``: fields of ``ShapeParameters`` after ``shape.``, then selection,
        networks, detector, means, recordings, files and the version of the method; a column per run, named by its id,
        of texts. Parameters that no run's method depends on are left out; those of another method are ``not used``.

    Raises:
        ArgumentError: there are fewer than two runs.
    """
    if len(runs) < 2:
        raise ArgumentError(f"runs must be at least two, got {len(runs)}")
    table = pd.DataFrame({run.id: _made_with(run) for run in runs}).rename_axis("parameter")
    return table[table.ne(table.iloc[:, 0], axis=0).any(axis=1)]


def _made_with(run: Run) -> dict[str, str]:
    shape, settings = run.settings.shape, run.settings
    detector = settings.detector
    return {
        **{
            f"{SHAPE}{name}": "not used" if name in shape.ignored else _text(getattr(shape, name))
            for name in ("method", *(each for each in asdict(shape) if each != "method"))
        },
        "selection": run.facts()["selection"],
        **{f"{name} network": (run.digests[name] or "none")[-8:] for name in ("filling", "mass")},
        "detector": "none" if detector is None else f"{(run.digests['detector'] or '')[:24]}, step {detector.every}",
        "masks": run.facts()["masks"],
        "views matched": str(settings.matching),
        "features": "sound" if settings.features is None else str(settings.features),
        "features of the videos": "none" if settings.sight is None else str(settings.sight),
        "training means": "none"
        if settings.means is None
        else f"{settings.means.source}, {digest('means', settings.means)[:8]}",
        "recordings": str(len(run.recordings)),
        "files": run.data_digest[:8],
        "version of the method": str(run.method_version),
    }


def _text(value: Any) -> str:
    if isinstance(value, HeightRange):
        return f"{value.reference} {value.low_mm:+g} to {value.high_mm:+g} mm".replace("-", "−")
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return ", ".join(map(" + ".join, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
