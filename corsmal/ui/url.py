"""What the user is looking at, and how it stands in the address bar.

Only what differs from the defaults is written. What cannot be read is left at its default and reported in one
sentence, so that a mistyped address never looks like an answer.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, cast

from corsmal.dataset.audio import CHANNELS
from corsmal.errors import ArgumentError
from corsmal.parameters import PAIRS, SHAPE_PRESETS, HeightRange, HeightReference, ShapeParameters
from corsmal.selection import Pair


@dataclass(frozen=True)
class Limits:
    """The range of a number that a page offers and an address may hold.

    Args:
        low: the smallest value.
        high: the largest value.
        step: the distance between values on a page.
        unit: for people.
    """

    low: float
    high: float
    step: float
    unit: str = ""


LIMITS = {
    "circumferences": Limits(10, 500, 1),
    "points": Limits(3, 90, 1),
    "radii": Limits(10, 600, 1),
    "radius_max_mm": Limits(10, 250, 0.5, "mm"),
    "radius_min_mm": Limits(0.5, 9.5, 0.5, "mm"),
    "max_difference_mm": Limits(0, 10, 0.05, "mm"),
    "tilt_deg": Limits(0, 15, 0.5, "°"),
    "wall_mm": Limits(0, 5, 0.1, "mm"),
}
WHOLE = ("circumferences", "points", "radii")
NAMES = {
    "circumferences": "L",
    "points": "N",
    "radii": "radii",
    "radius_max_mm": "rmax",
    "radius_min_mm": "rmin",
    "max_difference_mm": "dmax",
    "fit_rule": "fit",
    "width_rule": "width",
    "height_range": "z",
    "tilt_deg": "tilt",
    "wall_mm": "wall",
    "boxes": "boxes",
    "all_views": "third",
}
"""Names of the shape parameters in the address."""

HEIGHT_LIMIT_MM = 2000.0


@dataclass(frozen=True)
class Choice:
    """What the user is looking at.

    Args:
        recording: id; None: the first one.
        pair: views of the fit; None: the pair that the estimate used.
        frame: frame index; None: the best frame.
        shape: parameters of the fit.
        crop_s: start and end of what the filling network hears, in hundredths of a second; None: the whole.
        channel: microphone that is drawn and played, from 0; None: the mean of all.
    """

    recording: str | None = None
    pair: Pair | None = None
    frame: int | None = None
    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    crop_s: tuple[float, float] | None = None
    channel: int | None = None

    @property
    def preset(self) -> str:
        """The preset that the parameters are nearest to: of the same method the one with the fewest differences."""
        alike = [name for name, preset in SHAPE_PRESETS.items() if preset.method == self.shape.method]
        return min(alike, key=lambda name: len(_differences(self.shape, SHAPE_PRESETS[name])))

    @property
    def is_preset(self) -> bool:
        """Whether the parameters are exactly a preset's."""
        return self.shape == SHAPE_PRESETS[self.preset]


def to_params(choice: Choice) -> dict[str, str]:
    """The address' query parameters of a choice: only what differs from the defaults."""
    params = {}
    if choice.recording is not None:
        params["recording"] = choice.recording
    if choice.pair is not None:
        params["pair"] = "-".join(choice.pair)
    if choice.frame is not None:
        params["frame"] = str(choice.frame)
    if choice.crop_s is not None:
        params["crop"] = "-".join(f"{end_s:.2f}" for end_s in choice.crop_s)
    if choice.channel is not None:
        params["ch"] = str(choice.channel + 1)
    if choice.preset != "paper":
        params["preset"] = choice.preset
    for name, value in _differences(choice.shape, SHAPE_PRESETS[choice.preset]).items():
        params[NAMES[name]] = _text(value)
    return params


def from_params(params: Mapping[str, str]) -> tuple[Choice, tuple[str, ...]]:
    """A choice from the address' query parameters.

    Args:
        params: as the browser sent them: not to be trusted.

    Returns:
        The choice, and one sentence for every parameter that could not be used. Whether the recording exists is for
        the caller to find out.
    """
    problems: list[str] = []

    def read(name: str, parse: Callable[[str], Any], default: Any) -> Any:
        text = params.get(name)
        if text is None:
            return default
        try:
            return parse(text)
        except (ValueError, ArgumentError) as error:
            problems.append(f"The address has {name}={text[:40]!r}, which was left out: {error}.")
            return default

    unknown = sorted(set(params) - {"recording", "pair", "frame", "crop", "ch", "preset", *NAMES.values()})
    if unknown:
        problems.append(f"The address has parameters that mean nothing here: {', '.join(unknown)[:80]!r}.")
    shape = SHAPE_PRESETS[read("preset", _preset, "paper")]
    for name, short in NAMES.items():
        value = read(short, _PARSERS[name], None)
        if value is not None:
            shape = _changed(shape, name, value, problems)
    choice = Choice(
        params.get("recording"),
        read("pair", _pair, None),
        read("frame", _frame, None),
        shape,
        read("crop", _crop, None),
        read("ch", _channel, None),
    )
    return choice, tuple(problems)


def _changed(shape: ShapeParameters, name: str, value: Any, problems: list[str]) -> ShapeParameters:
    try:
        return replace(shape, **{name: value})
    except ArgumentError as error:
        problems.append(f"The address has {NAMES[name]}={_text(value)!r}, which was left out: {error}.")
        return shape


def _differences(shape: ShapeParameters, preset: ShapeParameters) -> dict[str, Any]:
    return {name: getattr(shape, name) for name in NAMES if getattr(shape, name) != getattr(preset, name)}


def _text(value: Any) -> str:
    if isinstance(value, HeightRange):
        return f"{value.reference}:{value.low_mm:g}:{value.high_mm:g}"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _preset(text: str) -> str:
    if text not in SHAPE_PRESETS:
        raise ArgumentError(f"there are the presets {', '.join(SHAPE_PRESETS)}")
    return text


def _pair(text: str) -> Pair:
    pair = tuple(text.split("-"))
    if pair not in PAIRS:
        raise ArgumentError(f"there are the pairs {', '.join('-'.join(pair) for pair in PAIRS)}")
    return pair[0], pair[1]


def _frame(text: str) -> int:
    frame = _number(text, whole=True)
    if not 0 <= frame < 10_000_000:
        raise ArgumentError("frames count from 0")
    return int(frame)


def _crop(text: str) -> tuple[float, float]:
    start, _, end = text.partition("-")
    start_s, end_s = (round(_number(part, whole=False), 2) for part in (start, end))
    if not 0 <= start_s < end_s:
        raise ArgumentError("START-END in seconds was expected")
    return start_s, end_s


def _channel(text: str) -> int:
    channel = _number(text, whole=True)
    if not 1 <= channel <= CHANNELS:
        raise ArgumentError(f"there are the microphones 1 to {CHANNELS}")
    return int(channel) - 1


def _number(text: str, *, whole: bool) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (whole and value != int(value)):
        raise ArgumentError("a whole number was expected" if whole else "a finite number was expected")
    return int(value) if whole else value


def _limited(name: str) -> Callable[[str], float]:
    limits = LIMITS[name]

    def parse(text: str) -> float:
        value = _number(text, whole=name in WHOLE)
        if not limits.low <= value <= limits.high:
            raise ArgumentError(f"{limits.low:g} to {limits.high:g} {limits.unit}".strip() + " is possible")
        return value

    return parse


def _height_range(text: str) -> HeightRange:
    reference, *offsets = text.split(":")
    if len(offsets) != 2:
        raise ArgumentError("masks:LOW:HIGH, world:LOW:HIGH or centroid:LOW:HIGH in mm was expected")
    low, high = (_number(offset, whole=False) for offset in offsets)
    if max(abs(low), abs(high)) > HEIGHT_LIMIT_MM:
        raise ArgumentError(f"heights are within {HEIGHT_LIMIT_MM:g} mm")
    return HeightRange(cast(HeightReference, reference), low, high)


def _switch(text: str) -> bool:
    if text not in ("True", "False"):
        raise ArgumentError("True or False was expected")
    return text == "True"


_PARSERS: dict[str, Callable[[str], Any]] = {
    **{name: _limited(name) for name in LIMITS},
    "fit_rule": str,
    "width_rule": str,
    "height_range": _height_range,
    "boxes": _switch,
    "all_views": _switch,
}
