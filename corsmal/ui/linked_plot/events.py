"""What goes into a linked plot and what comes out of it: range inputs, spans, clicks."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from corsmal.errors import ArgumentError


@dataclass(frozen=True)
class Slider:
    """A range input under the figure, with a number entry beside it.

    Args:
        name: the key of its value in ``PlotEvent.values``.
        label: what the user reads.
        min: the lowest value.
        max: the highest value.
        step: the distance between values, counted from ``min``.
        value: what the input shows, in ``min``..``max``.
        unit: written after the number.
    """

    name: str
    label: str
    min: float
    max: float
    step: float
    value: float
    unit: str = ""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.min, self.max, self.step, self.value))):
            raise ArgumentError(f"slider {self.name!r}: min, max, step and value must be finite numbers")
        if not (self.min < self.max and self.step > 0):
            raise ArgumentError(
                f"slider {self.name!r}: min must be below max and step positive, "
                f"got min {self.min}, max {self.max}, step {self.step}"
            )
        if not self.min <= self.value <= self.max:
            raise ArgumentError(f"slider {self.name!r}: value must lie in {self.min}..{self.max}, got {self.value}")


@dataclass(frozen=True)
class Span:
    """A stretch of the x-axis between two handles that the user drags; what lies outside can be faded.

    Args:
        names: the keys of its ends in ``PlotEvent.values``.
        labels: accessible names of the two handles.
        min: the lowest value.
        max: the highest value.
        step: by how much an arrow key moves a handle; dragging keeps to multiples of it.
        values: where the ends stand, in ``min``..``max``.
        gap: the ends come no nearer to each other.
        unit: written after the numbers.
        domain: the part of the plot's height that the handles cover, from below, in 0..1.
        faded: the parts of it that are faded outside, likewise.
    """

    names: tuple[str, str]
    labels: tuple[str, str]
    min: float
    max: float
    step: float
    values: tuple[float, float]
    gap: float = 0.0
    unit: str = ""
    domain: tuple[float, float] = (0.0, 1.0)
    faded: Sequence[tuple[float, float]] = ((0.0, 1.0),)

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.min, self.max, self.step, self.gap, *self.values))):
            raise ArgumentError(f"span {self.names}: min, max, step, gap and values must be finite numbers")
        if not (self.step > 0 and self.gap >= 0 and self.min <= self.values[0] <= self.values[1] <= self.max):
            raise ArgumentError(
                f"span {self.names}: values must rise within {self.min}..{self.max}, step be positive and gap not "
                f"negative, got {self.values}, {self.step} and {self.gap}"
            )


@dataclass(frozen=True)
class Click:
    """A click on a point of the figure.

    Args:
        x: the point's x, in the axis' unit; text on a category axis.
        y: the point's y, likewise.
        curve: the number of the trace, from 0.
        customdata: what the trace holds for the point, or None.
    """

    x: float | str | None
    y: float | str | None
    curve: int
    customdata: Any = None


@dataclass(frozen=True)
class PlotEvent:
    """What the user did to a linked plot, or to the time line, since its last run.

    Args:
        click: the point that was clicked, only in the run that the click caused.
        values: values of the range inputs and ends of the span that the user moved, by name, likewise.
        camera: from where the user now looks at a plot in 3D, once it has come to rest: x, y and z of Plotly's eye and
            centre; only in the run that this caused.
        settled: False while something is being dragged, a key is held or frames are played: more is coming, keep slow
            work for later.
    """

    click: Click | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    settled: bool = True
    camera: tuple[float, ...] | None = None


def parse_event(report: Mapping[str, Any]) -> PlotEvent:
    """The event in a report from the browser.

    Args:
        report: as ``linked_plot.js`` sends it. Anyone who can reach the app can make one up.

    Raises:
        ArgumentError: it is not of that form.
    """
    try:
        values = report.get("values") or {}
        event = PlotEvent(
            click=_click(report["click"]) if report.get("click") else None,
            values={str(name): float(value) for name, value in values.items()},
            settled=bool(report.get("settled", True)),
            camera=tuple(float(value) for value in report["camera"]) if report.get("camera") else None,
        )
    except (AttributeError, KeyError, OverflowError, TypeError, ValueError) as error:
        raise ArgumentError(f"a linked plot sent a report that cannot be read ({error!r}); reload the page") from error
    if not all(map(math.isfinite, (*event.values.values(), *(event.camera or ())))):
        raise ArgumentError("a linked plot sent a value that is not a finite number; reload the page")
    return event


def _click(raw: Mapping[str, Any]) -> Click:
    return Click(x=raw.get("x"), y=raw.get("y"), curve=int(raw["curve"]), customdata=raw.get("customdata"))
