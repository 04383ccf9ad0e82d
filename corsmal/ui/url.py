"""How what the user has chosen stands in the address bar.

Only what differs from the defaults is written. What cannot be read keeps its default and is reported in one
sentence, so that a mistyped address never looks like an answer.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, get_args

from corsmal.dataset.audio import CHANNELS
from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError
from corsmal.evaluation.flagged import ANY
from corsmal.figures.hull import Scope
from corsmal.mass import AxisRule
from corsmal.notes import FLAGS
from corsmal.parameters import METHOD_VIEWS, SELECTION_PRESETS, SHAPE_PRESETS, HeightRange, read_pair
from corsmal.ui.choice import NOTHING, SHOWN, Choice, View, differences
from corsmal.ui.controls import (
    BETWEEN,
    PADDING_MAX_PX,
    PARAMETERS,
    TYPED,
    TYPED_HIGH,
    TYPED_LOW,
    Number,
    Switch,
    read_number,
)

NAME_MAX = 80
CAMERA_DIGITS, CAMERA_MAX = 3, 100.0
DATASET = re.compile(r".{1,80}-[0-9a-f]{8}")


class Field(NamedTuple):
    """A field of ``Choice`` in the address: its name there is how a link says it.

    Args:
        name: of the field.
        parse: what reads it; raises an ``ArgumentError`` that says what was expected.
        write: what writes it.
    """

    name: str
    parse: Callable[[str], Any]
    write: Callable[[Any], str] = str


def to_params(choice: Choice) -> dict[str, str]:
    """The address' query parameters of a choice: only what differs from the defaults."""
    params = {}
    for short, (name, _, write) in FIELDS.items():
        value = getattr(choice, name)
        if value != DEFAULTS[name]:
            params[short] = write(value)
    if choice.preset != "paper":
        params["preset"] = choice.preset
    changed = differences(choice.shape, SHAPE_PRESETS[choice.preset])
    return params | {PARAMETERS[name].short: value_text(value) for name, value in changed.items()}


def from_params(params: Mapping[str, str]) -> tuple[Choice, tuple[str, ...]]:
    """A choice from the address' query parameters.

    Args:
        params: as the browser sent them: not to be trusted.

    Returns:
        The choice, and one sentence for every parameter that could not be used. Whether the recording exists is for
        the caller to find out.
    """
    problems: list[str] = []
    choice = Choice()
    unknown = sorted(set(params) - set(READERS))
    if unknown:
        problems.append(f"The address has unknown parameters: {', '.join(unknown)[:80]!r}.")
    for short, read in READERS.items():
        if short in params:
            try:
                choice = read(choice, params[short])
            except (ValueError, ArgumentError) as error:
                problems.append(f"The address has {short}={params[short][:40]!r}: ignored; {error}.")
    return choice, tuple(problems)


def value_text(value: Any) -> str:
    """A parameter as an address says it."""
    if isinstance(value, HeightRange):
        return f"{value.reference}:{value.low_mm:g}:{value.high_mm:g}"
    if isinstance(value, tuple):
        return BETWEEN.join(map("-".join, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _preset(text: str) -> str:
    return _one_of(text, *SHAPE_PRESETS, what="presets")


def _one_of(text: str, *options: str, what: str = "values") -> str:
    if text not in options:
        raise ArgumentError(f"available {what}: {', '.join(options)}")
    return text


def _with(choice: Choice, text: str, *, name: str, parse: Callable[[str], Any]) -> Choice:
    return replace(choice, **{name: parse(text)})


def _with_shape(choice: Choice, text: str, *, name: str) -> Choice:
    change: dict[str, Any] = {name: PARAMETERS[name].parse(text)}
    return replace(choice, shape=replace(choice.shape, **change))


def _with_preset(choice: Choice, text: str) -> Choice:
    return replace(choice, shape=SHAPE_PRESETS[_preset(text)])


def _name(text: str) -> str:
    """Whatever people may call a thing; whether there is one of that name is for the page to find out."""
    if not text.strip() or len(text) > NAME_MAX or not text.isprintable():
        raise ArgumentError(f"expected 1 to {NAME_MAX} printable characters")
    return text


def _numbers(text: str) -> tuple[tuple[str, float | None], ...]:
    """Numbers that were typed, such as ``h:120~C:`` for a height of 120 mm and no capacity."""
    names, found = {symbol: name for name, symbol in TYPED.items()}, {}
    for part in text.split(BETWEEN):
        symbol, colon, number = part.partition(":")
        if symbol not in names or not colon:
            raise ArgumentError(f"expected numbers of {', '.join(names)}, such as h:120{BETWEEN}w_t:80")
        found[names[symbol]] = Number("", "", TYPED_LOW, TYPED_HIGH, 0.01).parse(number) if number else None
    return tuple(found.items())


def _write_numbers(numbers: tuple[tuple[str, float | None], ...]) -> str:
    return BETWEEN.join(f"{TYPED[name]}:{'' if value is None else value_text(value)}" for name, value in numbers)


def _names(text: str) -> tuple[str, ...]:
    return tuple(_name(part) for part in text.split(BETWEEN))


def _flags(text: str) -> tuple[str, ...]:
    return tuple(_one_of(part, ANY, *FLAGS, what="flags") for part in text.split(BETWEEN))


def _dataset(text: str) -> str:
    if not DATASET.fullmatch(text) or not text.isprintable():
        raise ArgumentError("expected the dataset's name, '-' and the eight digits of its fingerprint")
    return text


def _frame(text: str) -> int:
    frame = read_number(text, whole=True)
    if not 0 <= frame < 10_000_000:
        raise ArgumentError("frames are numbered from 0")
    return int(frame)


def _offsets(text: str) -> tuple[tuple[str, float], ...]:
    """Offsets by view, such as ``view1:0.4~view2:-0.1``."""
    parts = [part.partition(":") for part in text.split(BETWEEN)]
    return Matching(offsets_s=tuple((view, read_number(number, whole=False)) for view, _, number in parts)).offsets_s


def _crop(text: str) -> tuple[float, float]:
    start, _, end = text.partition("-")
    start_s, end_s = (round(read_number(part, whole=False), 2) for part in (start, end))
    if not 0 <= start_s < end_s:
        raise ArgumentError("expected START-END in seconds")
    return start_s, end_s


def _camera(text: str) -> View:
    return camera_view([read_number(part, whole=False) for part in text.split("_")])


def camera_view(numbers: Sequence[float]) -> View:
    """A view of the hull from six numbers, rounded as the address holds them.

    Raises:
        ArgumentError: they are not six numbers of at most ``CAMERA_MAX``.
    """
    if len(numbers) != 6 or not all(abs(number) <= CAMERA_MAX for number in numbers):
        raise ArgumentError(f"expected six numbers from -{CAMERA_MAX:g} to {CAMERA_MAX:g}: eye and centre")
    x, y, z, *centre = (round(number, CAMERA_DIGITS) + 0.0 for number in numbers)
    return x, y, z, centre[0], centre[1], centre[2]


def _whole(low: int, high: int) -> Callable[[str], int]:
    return lambda text: int(Number("", "", low, high, 1).parse(text))


def _options(*options: str) -> Callable[[str], str]:
    return lambda text: _one_of(text, *options)


def _switch(text: str) -> bool:
    return Switch("", "").parse(text)


FIELDS: dict[str, Field] = {
    "dataset": Field("dataset", _dataset),
    "recording": Field("recording", str),
    "pair": Field("pair", read_pair, "-".join),
    "frame": Field("frame", _frame),
    "match": Field("match", _options("index")),
    "offset": Field("offsets_s", _offsets, lambda found: BETWEEN.join(f"{view}:{value_text(s)}" for view, s in found)),
    "masks": Field("masks", _options("by-hand")),
    "edit": Field("edited", _options(*METHOD_VIEWS)),
    "crop": Field("crop_s", _crop, lambda crop_s: "-".join(f"{end_s:.2f}" for end_s in crop_s)),
    "estimate": Field("estimate", lambda text: text if text == SHOWN else _preset(text)),
    "selection": Field("selection", _options(*SELECTION_PRESETS)),
    "ch": Field("channel", lambda text: _whole(1, CHANNELS)(text) - 1, lambda channel: str(channel + 1)),
    "compare": Field("compared", lambda text: text if text == NOTHING else _preset(text)),
    "scope": Field("scope", _options(*get_args(Scope))),
    "errors": Field("shows_errors", _switch),
    "axes": Field("has_axes", _switch),
    "camera": Field("camera", _camera, lambda view: "_".join(f"{number:g}" for number in view)),
    "axis": Field("axis", _options(*get_args(AxisRule))),
    "padding": Field("padding_px", _whole(0, PADDING_MAX_PX)),
    "typed": Field("numbers", _numbers, _write_numbers),
    "container": Field("container", _names, BETWEEN.join),
    "filling": Field("filling", _names, BETWEEN.join),
    "level": Field("level", _names, BETWEEN.join),
    "scenario": Field("scenario", _names, BETWEEN.join),
    "files": Field("lacks", _options("all", "complete")),
    "view": Field("view", _name),
    "run": Field("run", _name),
    "section": Field("section", _name),
    "protocol": Field("protocol", _name),
    "without": Field("without", _flags, BETWEEN.join),
    "metric": Field("metric", _name),
    "classes": Field("classes", _name),
    "beside": Field("beside", _name),
    "against": Field("against", _name),
    "within": Field("within_percent", Number("", "", 1, 100, 1.0, "%").parse, value_text),
    "sure": Field("sure_percent", Number("", "", 0, 100, 1.0, "%").parse, value_text),
    "rows": Field("rows", _names, BETWEEN.join),
    "failed": Field("only_failed", _switch),
    "pins": Field("collection", _name),
}
"""By name in the address: the field of a choice, and how it is read and written."""

DEFAULTS: dict[str, Any] = {name: getattr(Choice(), name) for name, _, _ in FIELDS.values()}

READERS: dict[str, Callable[[Choice, str], Choice]] = {
    "preset": _with_preset,
    **{short: partial(_with, name=name, parse=parse) for short, (name, parse, _) in FIELDS.items()},
    **{parameter.short: partial(_with_shape, name=name) for name, parameter in PARAMETERS.items()},
}
"""By name in the address, in the order in which they are read: a choice after the parameter's text."""
