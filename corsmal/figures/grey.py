"""Figures in greys that stay apart on paper."""

import base64
import re
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np

from corsmal.figures.style import Part

DARKEST, LIGHTEST = 40, 185
"""Of 255, of lines, bars and points; the greys between are spread evenly."""
WHITE = 250
"""What is lighter is the paper, or a line that sets points off from it, and stays as it is."""
SCALE_LIGHT, SCALE_DARK = 250, 120
"""Of colour scales, whose dark end still lets black text be read."""

_HEX = re.compile(r"#([0-9a-fA-F]{6})")
_RGB = re.compile(r"rgba?\(\s*([\d.]+)\s*,\s*([\d.]+)\s*,\s*([\d.]+)\s*(?:,\s*([\d.]+)\s*)?\)")
_IN_TEXT = re.compile(r"(?<=color:)#[0-9a-fA-F]{6}")
_PICTURE = re.compile(r"data:image/(png|jpeg);base64,(.+)", re.DOTALL)


def in_grey(figure: Part) -> dict[str, Any]:
    """A figure in greys.

    The colours of lines, bars, points and surfaces become greys at even distances, in the order of their lightness:
    colours that are equally light stay apart. Colour scales run from light to dark, from their first colour to their
    last, those with two ends too. Pictures are made grey.

    Args:
        figure: ``data`` and ``layout`` as plain values, as ``go.Figure.to_dict`` gives them.
    """
    found = {colour for colour in _colours(figure["data"]) if _lightness(colour) < WHITE}
    used = sorted(found, key=lambda colour: (_lightness(colour), colour))
    levels = np.linspace(DARKEST, LIGHTEST, max(len(used), 2)).round().astype(int)
    greys = dict(zip(used, levels.tolist(), strict=False))
    parts: dict[str, Any] = _grey(figure, greys)
    return parts


def _colours(value: Any) -> Iterator[tuple[int, int, int]]:
    """All colours of traces but those of scales."""
    if isinstance(value, dict):
        for name, part in value.items():
            if name != "colorscale":
                yield from _colours(part)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _colours(part)
    elif isinstance(value, str) and (found := _parse(value)) is not None:
        yield found[0]


def _grey(value: Any, greys: dict[tuple[int, int, int], int]) -> Any:
    if isinstance(value, dict):
        return {name: _scale(part) if name == "colorscale" else _grey(part, greys) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_grey(part, greys) for part in value]
    if not isinstance(value, str):
        return value
    found = _parse(value)
    if found is not None:
        colour, alpha = found
        return _text(greys.get(colour, round(_lightness(colour))), alpha)
    if _PICTURE.fullmatch(value):
        return _grey_picture(value)
    return _IN_TEXT.sub(lambda match: str(_grey(match.group(), greys)), value)


def _scale(value: Any) -> Any:
    """A colour scale from light to dark."""
    if not isinstance(value, list | tuple):
        return [[0.0, _text(SCALE_LIGHT)], [1.0, _text(SCALE_DARK)]]
    return [[place, _text(round(SCALE_LIGHT + place * (SCALE_DARK - SCALE_LIGHT)))] for place, _ in value]


def _parse(text: str) -> tuple[tuple[int, int, int], str | None] | None:
    """A colour and its opacity; None for any other text."""
    if found := _HEX.fullmatch(text):
        red, green, blue = bytes.fromhex(found.group(1))
        return (red, green, blue), None
    if found := _RGB.fullmatch(text):
        red, green, blue = (min(255, round(float(part))) for part in found.groups()[:3])
        return (red, green, blue), found.group(4)
    return None


def _lightness(colour: tuple[int, int, int]) -> float:
    return float(np.dot(colour, (0.299, 0.587, 0.114)))


def _text(level: int, alpha: str | None = None) -> str:
    return f"#{level:02X}{level:02X}{level:02X}" if alpha is None else f"rgba({level},{level},{level},{alpha})"


def _grey_picture(source: str) -> str:
    """A picture in a text as grey PNG; as it is where it cannot be read."""
    found = _PICTURE.fullmatch(source)
    content = base64.b64decode(found.group(2)) if found else b""
    image = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    if image is None:
        return source
    packed = cv2.imencode(".png", image)[1].tobytes()
    return f"data:image/png;base64,{base64.b64encode(packed).decode('ascii')}"
