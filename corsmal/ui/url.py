"""What the user has chosen, and how it stands in the address bar.

Only what differs from the defaults is written. What cannot be read keeps its default and is reported in one
sentence, so that a mistyped address never looks like an answer.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from corsmal.dataset.audio import CHANNELS
from corsmal.errors import ArgumentError
from corsmal.parameters import PAIRS, SHAPE_PRESETS, HeightRange, ShapeParameters
from corsmal.selection import Pair
from corsmal.ui.controls import PARAMETERS, Number, read_number

ESTIMATE, SHOWN = "tuned", "shown"
"""The estimate over the whole recording: the preset unless another is chosen, and what says that it has ``shape``."""


@dataclass(frozen=True)
class Choice:
    """What the user has chosen.

    Args:
        recording: id; None: the first one.
        pair: views of the fit; None: the pair that the estimate used.
        frame: frame index; None: the best frame.
        shape: parameters of the fit.
        crop_s: start and end of the filling network's input, in hundredths of a second; None: the whole.
        channel: microphone that is drawn and played, from 0; None: the mean of all.
        estimate: preset of the estimate over the whole recording, or ``SHOWN``; None: ``tuned``, which gives intervals.
    """

    recording: str | None = None
    pair: Pair | None = None
    frame: int | None = None
    shape: ShapeParameters = field(default_factory=ShapeParameters.paper)
    crop_s: tuple[float, float] | None = None
    channel: int | None = None
    estimate: str | None = None

    @property
    def preset(self) -> str:
        """The preset that the parameters are nearest to: of the same method the one with the fewest differences."""
        alike = [name for name, preset in SHAPE_PRESETS.items() if preset.method == self.shape.method]
        return min(alike, key=lambda name: len(_differences(self.shape, SHAPE_PRESETS[name])))

    @property
    def shape_name(self) -> str:
        """The parameters of the fit, for people."""
        return self.preset if self.is_preset else f"{self.preset}, own values"

    @property
    def estimate_name(self) -> str:
        """The parameters of the estimate over the whole recording, for people."""
        return self.shape_name if self.estimate == SHOWN else self.estimate or ESTIMATE

    @property
    def estimate_preset(self) -> str:
        """The preset that the parameters of the estimate over the whole recording are, or are nearest to."""
        return self.preset if self.estimate == SHOWN else self.estimate or ESTIMATE

    @property
    def estimated_shape(self) -> ShapeParameters:
        """The parameters of the estimate over the whole recording."""
        return self.shape if self.estimate == SHOWN else SHAPE_PRESETS[self.estimate or ESTIMATE]

    @property
    def is_preset(self) -> bool:
        """Whether the parameters are exactly a preset's."""
        return self.shape == SHAPE_PRESETS[self.preset]


def estimate_of(shape: ShapeParameters) -> str | None:
    """What ``Choice.estimate`` is where the shown parameters are also those of the estimate."""
    name = next((name for name, preset in SHAPE_PRESETS.items() if preset == shape), SHOWN)
    return None if name == ESTIMATE else name


def to_params(choice: Choice) -> dict[str, str]:
    """The address' query parameters of a choice: only what differs from the defaults."""
    params = {} if choice.recording is None else {"recording": choice.recording}
    for short, (name, _, write) in FIELDS.items():
        value = getattr(choice, name)
        if value is not None:
            params[short] = write(value)
    if choice.preset != "paper":
        params["preset"] = choice.preset
    differences = _differences(choice.shape, SHAPE_PRESETS[choice.preset])
    return params | {PARAMETERS[name].short: _text(value) for name, value in differences.items()}


def from_params(params: Mapping[str, str]) -> tuple[Choice, tuple[str, ...]]:
    """A choice from the address' query parameters.

    Args:
        params: as the browser sent them: not to be trusted.

    Returns:
        The choice, and one sentence for every parameter that could not be used. Whether the recording exists is for
        the caller to find out.
    """
    problems: list[str] = []
    choice = Choice(params.get("recording"))
    unknown = sorted(set(params) - {"recording", *READERS})
    if unknown:
        problems.append(f"The address has unknown parameters: {', '.join(unknown)[:80]!r}.")
    for short, read in READERS.items():
        if short in params:
            try:
                choice = read(choice, params[short])
            except (ValueError, ArgumentError) as error:
                problems.append(f"The address has {short}={params[short][:40]!r}: ignored; {error}.")
    return choice, tuple(problems)


def _differences(shape: ShapeParameters, preset: ShapeParameters) -> dict[str, Any]:
    return {name: getattr(shape, name) for name in PARAMETERS if getattr(shape, name) != getattr(preset, name)}


def _text(value: Any) -> str:
    if isinstance(value, HeightRange):
        return f"{value.reference}:{value.low_mm:g}:{value.high_mm:g}"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _preset(text: str) -> str:
    if text not in SHAPE_PRESETS:
        raise ArgumentError(f"available presets: {', '.join(SHAPE_PRESETS)}")
    return text


def _with(choice: Choice, text: str, *, name: str, parse: Callable[[str], Any]) -> Choice:
    return replace(choice, **{name: parse(text)})


def _with_shape(choice: Choice, text: str, *, name: str) -> Choice:
    change: dict[str, Any] = {name: PARAMETERS[name].parse(text)}
    return replace(choice, shape=replace(choice.shape, **change))


def _with_preset(choice: Choice, text: str) -> Choice:
    return replace(choice, shape=SHAPE_PRESETS[_preset(text)])


def _pair(text: str) -> Pair:
    pair = tuple(text.split("-"))
    if pair not in PAIRS:
        raise ArgumentError(f"available pairs: {', '.join('-'.join(pair) for pair in PAIRS)}")
    return pair[0], pair[1]


def _frame(text: str) -> int:
    frame = read_number(text, whole=True)
    if not 0 <= frame < 10_000_000:
        raise ArgumentError("frames are numbered from 0")
    return int(frame)


def _crop(text: str) -> tuple[float, float]:
    start, _, end = text.partition("-")
    start_s, end_s = (round(read_number(part, whole=False), 2) for part in (start, end))
    if not 0 <= start_s < end_s:
        raise ArgumentError("expected START-END in seconds")
    return start_s, end_s


FIELDS: dict[str, tuple[str, Callable[[str], Any], Callable[[Any], str]]] = {
    "pair": ("pair", _pair, "-".join),
    "frame": ("frame", _frame, str),
    "crop": ("crop_s", _crop, lambda crop_s: "-".join(f"{end_s:.2f}" for end_s in crop_s)),
    "estimate": ("estimate", lambda text: text if text == SHOWN else _preset(text), str),
    "ch": ("channel", lambda text: Number("ch", "", 1, CHANNELS, 1).parse(text) - 1, lambda channel: str(channel + 1)),
}
"""By name in the address: the field of a choice, and how it is read and written."""

READERS: dict[str, Callable[[Choice, str], Choice]] = {
    "preset": _with_preset,
    **{short: partial(_with, name=name, parse=parse) for short, (name, parse, _) in FIELDS.items()},
    **{parameter.short: partial(_with_shape, name=name) for name, parameter in PARAMETERS.items()},
}
"""By name in the address, in the order in which they are read: a choice after the parameter's text."""
