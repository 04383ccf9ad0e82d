"""What a report is made of."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import pandas as pd
import plotly.graph_objects as go

from corsmal.figures.pins import Pin

Tone = Literal["", "better", "worse"]


@dataclass(frozen=True)
class Text:
    """Sentences, a paragraph each."""

    sentences: Sequence[str]


@dataclass(frozen=True)
class Answers:
    """Questions of a reader with their answers, in order."""

    by_question: Mapping[str, str]


@dataclass(frozen=True)
class TileLine:
    """A number on a tile.

    Args:
        label: what it is.
        value: the number with its unit.
        note: what it is compared with, and how sure it is.
        tone: whether it is better or worse than that.
    """

    label: str
    value: str
    note: str = ""
    tone: Tone = ""


@dataclass(frozen=True)
class Tile:
    """Numbers of one kind; ``hint`` says in a few words what kind that is."""

    title: str
    hint: str
    lines: Sequence[TileLine]


@dataclass(frozen=True)
class Tiles:
    """Tiles side by side."""

    tiles: Sequence[Tile]


@dataclass(frozen=True, eq=False)
class Table:
    """A table with its caption; headings are shown as ``evaluation.exporting.heading`` has them, fractions rounded.

    Args:
        table: its index is not shown.
        caption: what it shows.
        digits: after the decimal point.
    """

    table: pd.DataFrame
    caption: str = ""
    digits: int = 1


@dataclass(frozen=True, eq=False)
class Table2:
    """The paper's Table 2: ``cells`` from ``evaluation.cell_table``, of one protocol.

    Args:
        cells: the numbers.
        caption: what they are.
        is_like_with_like: whether the best of a run's number and the published one is set in bold.
    """

    cells: pd.DataFrame
    caption: str
    is_like_with_like: bool


@dataclass(frozen=True, eq=False)
class Chart:
    """A figure with its caption, ``height_px`` high at a width of ``pictures.WIDTH_PX``."""

    figure: go.Figure
    caption: str
    height_px: int = 420


@dataclass(frozen=True, eq=False)
class Pinned:
    """What was pinned, with all that its record says."""

    pin: Pin


@dataclass(frozen=True)
class Commands:
    """Lines for a terminal."""

    lines: Sequence[str]


Block = Text | Answers | Tiles | Table | Table2 | Chart | Pinned | Commands


@dataclass(frozen=True)
class Section:
    """A part of a report; ``starts_page`` on paper."""

    heading: str
    blocks: Sequence[Block]
    starts_page: bool = False


@dataclass(frozen=True)
class Banner:
    """Where the data come from, which no reader may miss.

    Args:
        kind: in a word or two, such as ``Synthetic data``.
        text: the rest.
        is_warning: whether the numbers must not be taken for results on real recordings.
    """

    kind: str
    text: str
    is_warning: bool


@dataclass(frozen=True)
class Report:
    """A whole report.

    Args:
        title: its name.
        author: who made it; may be empty.
        made: when, for people.
        banner: where the data come from.
        sections: in order.
    """

    title: str
    author: str
    made: str
    banner: Banner
    sections: Sequence[Section]

    def figures(self) -> Iterator[Chart | Pinned]:
        """The blocks that hold a Plotly figure, in order: their place is the figure's key in ``report_html``."""
        for section in self.sections:
            for block in section.blocks:
                if isinstance(block, Chart) or (isinstance(block, Pinned) and block.pin.figure is not None):
                    yield block
