"""What the system says about one recording."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from corsmal.estimation.fit import Fit
from corsmal.estimation.intervals import Interval
from corsmal.filling.records import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.mass.physics import filling_mass_g
from corsmal.mass.records import MassPrediction
from corsmal.notebook import record_html
from corsmal.notes import SEPARATOR, flags_of
from corsmal.parameters import CentreRule
from corsmal.quantities import BY_NAME, MEASURED
from corsmal.selection import BestFrame

Status = Literal["fitted", "fitted, second pair", "fitted, third pair", "fallback: training mean", "failed"]
FITTED: tuple[Status, ...] = ("fitted", "fitted, second pair", "fitted, third pair")
"""The status of a fit by the position of its pair."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What the system says about one recording.

    Args:
        status: where the geometry's numbers come from; ``fallback: training mean`` and ``failed``: all pairs failed.
        capacity_ml: mL, None when failed; likewise the widths and the height, mm. A width may be a training mean by
            itself, or None: a note says so.
        best_frame: the selection that led to the fit, None if none did; its frame is the fitted one.
        fit: the hull behind the numbers, None if none is.
        notes: one sentence for every pair that failed, every view without detections, every later stage that failed,
            and all that was assumed; some raise flags.
        container_mass_g: grams, None when failed or left out.
        filling: what the sound says, None when left out.
        mass: where ``container_mass_g`` comes from, None when left out or when there is no fit.
        intervals: where the truth lies with a probability of 90 %, lower and upper end by quantity; empty where one
            frame was fitted or none.
        mass_frame: the frame whose mask the mass is predicted from, None without one.
        box_odds: how much likelier a box is than a round container, by all fitted frames; None where no box was fitted.
    """

    recording_id: str
    status: Status
    capacity_ml: float | None
    width_top_mm: float | None
    width_bottom_mm: float | None
    height_mm: float | None
    best_frame: BestFrame | None
    fit: Fit | None
    notes: tuple[str, ...]
    container_mass_g: float | None = None
    filling: FillingPrediction | None = None
    mass: MassPrediction | None = None
    intervals: Mapping[str, Interval] = field(default_factory=dict)
    mass_frame: int | None = None
    box_odds: float | None = None

    @property
    def centre_rule(self) -> CentreRule | None:
        """The rung of the ladder that was used."""
        return None if self.best_frame is None else self.best_frame.centre_rule

    @property
    def flags(self) -> tuple[str, ...]:
        """What was assumed, implausible, cut or outside of what a network learned from, see ``notes.FLAGS``."""
        return flags_of(self.notes)

    @property
    def filling_mass_g(self) -> float | None:
        """Level fraction × capacity × density of the estimated type, g; None where one of them is not known."""
        pair = None if self.filling is None else self.filling.pair
        return None if pair is None else filling_mass_g(*pair, capacity_ml=self.capacity_ml)

    @property
    def object_mass_g(self) -> float | None:
        """Container and filling, g."""
        if self.container_mass_g is None or self.filling_mass_g is None:
            return None
        return self.container_mass_g + self.filling_mass_g

    def _repr_html_(self) -> str:
        """What a notebook shows: the numbers with their units and intervals, and all notes."""
        facts: dict[str, str] = {"status": self.status}
        for name in MEASURED:
            quantity, ends = BY_NAME[name], self.intervals.get(name)
            between = "" if ends is None else f" (90 %: {ends[0]:.{quantity.digits}f} to {ends[1]:.{quantity.digits}f})"
            facts[quantity.words] = quantity.text(getattr(self, name)) + between
        if self.filling is not None and self.filling.pair is not None:
            filling, level = self.filling.pair
            facts["filling"] = f"{TYPE_NAMES[filling]}, {LEVEL_NAMES[level]}"
        for name, mass_g in (("filling mass", self.filling_mass_g), ("mass with filling", self.object_mass_g)):
            facts[name] = "" if mass_g is None else f"{mass_g:.0f} g"
        if self.fit is not None:
            facts["fitted to"] = f"{' + '.join(self.fit.pair)}, frame {self.fit.frame}"
        facts["flags"] = SEPARATOR.join(self.flags)
        return record_html(f"Estimate of recording {self.recording_id}", facts, notes=self.notes)

    def row(self) -> dict[str, Any]:
        """The estimate as a row of an estimates table; what is not known is None."""
        filling = FillingPrediction.failed("not asked for") if self.filling is None else self.filling
        types, levels = filling.type_probabilities, filling.level_probabilities
        return {
            "recording_id": self.recording_id,
            "status": self.status,
            **{name: getattr(self, name) for name in MEASURED},
            "filling_type": filling.filling_type,
            "filling_level": filling.filling_level,
            "filling_mass_g": self.filling_mass_g,
            "object_mass_g": self.object_mass_g,
            **{f"type_p{index}": None if types is None else float(types[index]) for index in range(4)},
            **{f"level_p{index}": None if levels is None else float(levels[index]) for index in range(3)},
            "best_frame": None if self.best_frame is None else self.best_frame.frame,
            "pair": "" if self.fit is None else " + ".join(self.fit.pair),
            "flags": SEPARATOR.join(self.flags),
            "notes": "; ".join(self.notes),
            **{
                f"{name}_{end}": value
                for name, ends in self.intervals.items()
                for end, value in zip(("low", "high"), ends, strict=True)
            },
        }
