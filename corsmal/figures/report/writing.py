"""The blocks of a report as HTML."""

import base64
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import singledispatchmethod

import pandas as pd
import soundfile
from plotly.io.json import to_json_plotly

from corsmal.evaluation.exporting import MISSING, heading
from corsmal.figures.paper import is_spatial
from corsmal.figures.pins import Pin
from corsmal.figures.report.blocks import Answers, Block, Chart, Commands, Pinned, Table, Table2, Text, Tile, Tiles
from corsmal.figures.report.captions import escaped, pin_caption
from corsmal.figures.report.pictures import MEDIA, figure_parts, picture_format
from corsmal.figures.report.table2 import table_2_html

SOUND_AS = ("MP3", "audio/mpeg")
"""How a sound is packed: to a tenth of a WAV, and every browser plays it."""


class Writer:
    """Writes the blocks of a report and numbers its figures.

    Args:
        pictures: of the Plotly figures in order; empty where the reader's browser draws them.
    """

    def __init__(self, pictures: Sequence[bytes]) -> None:
        self._pictures: Iterator[bytes] = iter(pictures)
        self._figures = 0

    @singledispatchmethod
    def block(self, block: Block) -> str:
        """A block as HTML; every text is escaped."""
        raise TypeError(f"no such block: {block!r}")

    @block.register
    def _(self, block: Text) -> str:
        return "".join(f"<p>{escaped(sentence)}</p>" for sentence in block.sentences if sentence)

    @block.register
    def _(self, block: Answers) -> str:
        rows = (f"<dt>{escaped(name)}</dt><dd>{escaped(answer)}</dd>" for name, answer in block.by_question.items())
        return f'<dl class="answers">{"".join(rows)}</dl>'

    @block.register
    def _(self, block: Tiles) -> str:
        return f'<div class="tiles">{"".join(map(_tile, block.tiles))}</div>'

    @block.register
    def _(self, block: Table) -> str:
        return f'<div class="scroll">{_table(block)}</div>'

    @block.register
    def _(self, block: Table2) -> str:
        return f'<div class="scroll">{table_2_html(block)}</div>'

    @block.register
    def _(self, block: Commands) -> str:
        return f"<pre>{escaped(chr(10).join(block.lines))}</pre>"

    @block.register
    def _(self, block: Chart) -> str:
        return self._plot(block, escaped(block.caption), alt=block.caption)

    @block.register
    def _(self, block: Pinned) -> str:
        caption = pin_caption(block.pin)
        if block.pin.figure is not None:
            return self._plot(block, caption, alt=block.pin.title, kind="plot pinned")
        return f'<figure class="pinned">{_content(block.pin)}{self._caption(caption)}</figure>'

    def _plot(self, block: Chart | Pinned, caption: str, *, alt: str, kind: str = "plot") -> str:
        """A figure as a picture, and what makes it live."""
        parts = figure_parts(block)
        content = next(self._pictures, b"")
        layout = parts["layout"]
        shown = _image(content, MEDIA[picture_format(parts)], alt) if content else ""
        shape = f'style="aspect-ratio: {layout["width"]} / {layout["height"]}" role="img" aria-label="{escaped(alt)}"'
        action, mark = ("Turn in 3D", " data-spatial") if is_spatial(parts) else ("Show values", "")
        return (
            f'<figure class="{kind}"{mark}><div class="picture" {shape}>{shown}</div>'
            f'<div class="live" hidden></div><button type="button" hidden>{action}</button>'
            f'<script type="application/json">{_json(parts)}</script>{self._caption(caption)}</figure>'
        )

    def _caption(self, caption: str) -> str:
        self._figures += 1
        return f"<figcaption><b>Figure {self._figures}.</b> {caption}</figcaption>"


def _json(parts: Mapping[str, object]) -> str:
    """A figure within a script element, which no text in it can end."""
    text = str(to_json_plotly(parts)).replace("<", r"\u003c").replace("\u2028", r"\u2028").replace("\u2029", r"\u2029")
    json.loads(text)
    return text


def _tile(tile: Tile) -> str:
    lines = "".join(
        f'<tr class="{line.tone}"><th>{escaped(line.label)}</th><td>{escaped(line.value)}</td>'
        f"<td>{escaped(line.note)}</td></tr>"
        for line in tile.lines
    )
    return f"<div><h3>{escaped(tile.title)}</h3><p>{escaped(tile.hint)}</p><table>{lines}</table></div>"


def _table(block: Table) -> str:
    table = block.table
    is_number = [pd.api.types.is_numeric_dtype(dtype) for dtype in table.dtypes]
    sides = ['class="number"' if right else "" for right in is_number]
    heads = "".join(
        f"<th {side}>{escaped(heading(str(name)))}</th>" for name, side in zip(table.columns, sides, strict=True)
    )
    cells = (
        (f"<td {side}>{_cell(value, block.digits)}</td>" for value, side in zip(row, sides, strict=True))
        for row in table.itertuples(index=False, name=None)
    )
    rows = "".join(f"<tr>{''.join(row)}</tr>" for row in cells)
    caption = f"<caption>{escaped(block.caption)}</caption>" if block.caption else ""
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(value: object, digits: int) -> str:
    if value is None or value is pd.NA or (isinstance(value, float) and pd.isna(value)) or value == "":
        return MISSING
    return f"{value:.{digits}f}".replace("-", "−") if isinstance(value, float) else escaped(value)


def _image(content: bytes, medium: str, alt: str) -> str:
    return f'<img alt="{escaped(alt)}" src="data:{medium};base64,{base64.b64encode(content).decode("ascii")}">'


def _content(pin: Pin) -> str:
    if pin.medium == "audio/wav":
        content, medium = _packed_sound(pin.content)
        packed = base64.b64encode(content).decode("ascii")
        return (
            f'<audio controls src="data:{medium};base64,{packed}"></audio>'
            '<p class="paper">A sound: it can be played in the HTML file.</p>'
        )
    return _image(pin.content, str(pin.medium), pin.title)


def _packed_sound(content: bytes) -> tuple[bytes, str]:
    """A WAV as MP3; as it is where it cannot be packed."""
    packed = io.BytesIO()
    try:
        samples, rate_hz = soundfile.read(io.BytesIO(content), dtype="float32")
        soundfile.write(packed, samples, rate_hz, format=SOUND_AS[0])
    except (soundfile.SoundFileError, TypeError, ValueError):
        return content, "audio/wav"
    return packed.getvalue(), SOUND_AS[1]
