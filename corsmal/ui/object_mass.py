"""Container, filling and object mass beside the truth."""

from contextlib import suppress
from dataclasses import dataclass

import streamlit as st

from corsmal.dataset import Recording
from corsmal.dataset.annotation import FILLINGS, LEVELS
from corsmal.errors import CorsmalError
from corsmal.mass import filling_mass_g
from corsmal.ui.filling import sound


@dataclass(frozen=True)
class Filling:
    """What is in a container, and who says so.

    Args:
        kind: filling type, 0 to 3.
        level: filling level, 0 to 2.
        source: such as "the annotation".
    """

    kind: int
    level: int
    source: str

    @property
    def text(self) -> str:
        """In words."""
        return "empty" if not (self.kind and self.level) else f"{FILLINGS[self.kind]}, {LEVELS[self.level]}"

    def mass_g(self, capacity_ml: float | None) -> float | None:
        """Grams; None where it needs a capacity that is not known."""
        if not (self.kind and self.level):
            return 0.0
        return None if capacity_ml is None else filling_mass_g(self.kind, self.level, capacity_ml)


def heard_filling(recording: Recording) -> Filling | None:
    """The filling as the sound's network says, or as the annotation does where there is nothing to listen to."""
    with suppress(CorsmalError):
        heard = sound.prediction(recording, crop_s=None).pair
        if heard is not None:
            return Filling(*heard, "the sound")
    return _annotated_filling(recording)


def _annotated_filling(recording: Recording) -> Filling | None:
    note = recording.annotation
    if note is None or note.filling_type is None or note.filling_level is None:
        return None
    return Filling(note.filling_type, note.filling_level, "the annotation")


def object_mass(
    recording: Recording, container_g: float | None, filling: Filling | None, *, capacity_ml: float | None
) -> None:
    """Container, filling and object mass beside the truth."""
    note = recording.annotation
    true_g = [getattr(note, name, None) for name in ("container_mass_g", "filling_mass_g")]
    filling_g = None if filling is None else filling.mass_g(capacity_ml)
    values = (container_g, filling_g, _sum(container_g, filling_g))
    truths = (*true_g, _sum(*true_g))
    labels = ("Container mass", "Filling mass", "Object mass")
    for column, label, value, true in zip(st.columns(3), labels, values, truths, strict=True):
        column.metric(label, grams(value), error_text(value, true), delta_color="off", delta_arrow="off")
    said = (
        "not known: neither sound nor annotation says" if filling is None else f"{filling.text}, from {filling.source}"
    )
    if filling is not None and filling.mass_g(None) is None:
        said += "; " + ("the capacity is missing" if capacity_ml is None else f"capacity {capacity_ml:.0f} mL")
    annotated = _annotated_filling(recording)
    if filling is not None and annotated is not None and filling.text != annotated.text:
        said += f" (annotated: {annotated.text})"
    st.caption(f":material/water_full: Filling: {said}. Object = container + filling.")


def grams(value: float | None) -> str:
    """A mass as people read it."""
    if value is None:
        return "unknown"
    return f"{_digits(value)} g"


def error_text(value: float | None, true: float | None) -> str:
    """How far a mass is from the truth."""
    if true is None:
        return "no annotation"
    if value is None:
        return f"truth {grams(true)}"
    off = value - true
    if off == 0:
        return f"exactly the true {grams(true)}"
    share = f" ({100 * off / true:+.0f} %)" if true else ""
    return f"{_digits(off, sign='+')} g{share} off the true {grams(true)}"


def _digits(value: float, *, sign: str = "") -> str:
    """One decimal below ten grams, none above, none for nothing."""
    return f"{value:{sign}.1f}" if 0 < abs(value) < 9.95 else f"{value:{sign},.0f}"


def _sum(*values: float | None) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None
