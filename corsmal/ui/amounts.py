"""Amounts and errors as pages write them."""

from typing import Any

from corsmal.dataset.annotation import FILLINGS, LEVELS
from corsmal.quantities import BY_NAME


def measure(place: Any, label: str, value: object, note: str) -> None:
    """A measure with a note below it, in a column or another place."""
    place.metric(label, value, note, delta_color="off", delta_arrow="off")


def amount(name: str, value: float) -> str:
    """A quantity with its unit; a length as finely as a slider changes it."""
    return f"{value:.1f} mm" if BY_NAME[name].unit == "mm" else BY_NAME[name].text(value)


def percent_error(value: float, true: float) -> str:
    """A signed error in per cent of the truth."""
    share = round(100 * (value - true) / true, 1) or 0.0  # no "−0.0"
    return f"{share:+.1f} %".replace("-", "−")


def filling_text(kind: int, level: int) -> str:
    """A filling in words."""
    return f"{FILLINGS[kind]}, {LEVELS[level]}" if kind and level else "empty"


def grams(value: float | None) -> str:
    """A mass."""
    return "unknown" if value is None else f"{_digits(value)} g"


def mass_interval(ends_g: tuple[float, float]) -> str:
    """Where a mass lies with a probability of 90 %."""
    low, high = map(_digits, ends_g)
    return f"90 % interval {low}–{high} g"


def mass_error(value: float | None, true: float | None) -> str:
    """How far a mass is from the truth."""
    if true is None:
        return "no annotation"
    off = 0.0 if value is None else value - true
    if off == 0:
        return f"true {grams(true)}" if value is None else f"exact (true {grams(true)})"
    if round(abs(off), 1) == 0:
        return f"less than 0.1 g off (true {grams(true)})"
    share = f"{100 * off / true:+.0f} %; ".replace("-", "−") if true else ""
    return f"{_digits(abs(off))} g too {'high' if off > 0 else 'low'} ({share}true {grams(true)})"


def _digits(value: float) -> str:
    """One decimal below ten grams, none above, none for nothing."""
    return f"{value:.1f}" if 0 < abs(value) < 9.95 else f"{value:,.0f}"


def total(*values: float | None) -> float | None:
    """The sum; None where a value is not known."""
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None
