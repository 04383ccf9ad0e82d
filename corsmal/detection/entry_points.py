"""Detectors of other packages, by name: their entry points of the group ``corsmal.detectors``.

An entry point is a function that takes a file of weights or None, and ``device=``, and returns a ``Detector``.
"""

from importlib.metadata import entry_points
from pathlib import Path

from corsmal.detection.job import Detector
from corsmal.errors import ArgumentError, NotFoundError

GROUP = "corsmal.detectors"
NEEDED = ("name", "digest", "detect")


def own_detectors() -> tuple[str, ...]:
    """Names of the detectors that installed packages offer."""
    return tuple(sorted({entry.name for entry in entry_points(group=GROUP)}))


def open_own_detector(name: str, weights: Path | None = None, *, device: str | None = None) -> Detector:
    """Open the detector of a name.

    Args:
        name: of the entry point.
        weights: a file of weights, if the detector takes one.
        device: such as ``cuda:0``; default: the detector's choice.

    Raises:
        NotFoundError: no installed package has such an entry point.
        ArgumentError: it could not be opened, or is no detector.
        CorsmalError: what the detector itself raises.
    """
    found = next((entry for entry in entry_points(group=GROUP) if entry.name == name), None)
    if found is None:
        raise NotFoundError(f"there is no detector {name!r}: there are {', '.join(['coco', 'demo', *own_detectors()])}")
    try:
        detector: Detector = found.load()(weights, device=device)
    except (ImportError, AttributeError, TypeError, ValueError, OSError, RuntimeError) as error:
        raise ArgumentError(f"the detector {name!r} ({found.value}) could not be opened: {error}") from error
    if missing := [attribute for attribute in NEEDED if not hasattr(detector, attribute)]:
        raise ArgumentError(f"the detector {name!r} ({found.value}) has no {', '.join(missing)}")
    return detector
