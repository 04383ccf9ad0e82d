"""What was pinned for a report: a figure, a picture or a sound, with the numbers it showed and where it came from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import plotly.graph_objects as go

from corsmal.errors import ArgumentError

Medium = Literal["image/jpeg", "image/png", "audio/wav"]


@dataclass(frozen=True, eq=False)
class Pin:
    """Something that was pinned for a report.

    Args:
        title: one line: what it shows, of which recording.
        figure: a figure, which stays interactive; or else
        content: a picture's or a sound's bytes.
        medium: what ``content`` is.
        numbers: what was shown beside it, by label; each text has its unit, such as ``"563 mL"``.
        parameters: what it was computed with, by name, the preset first.
        dataset: name of the dataset.
        recording: id.
        frame: frame index, if it shows one.
        run: name of the run whose numbers it shows.
        link: the page's address with the whole state, without the server: ``"shape?recording=000618&frame=25"``.
        note: what the person who pinned it wants to say.

    Raises:
        ArgumentError: it holds neither a figure nor a content with its medium, or both.
    """

    title: str
    figure: go.Figure | None = None
    content: bytes = b""
    medium: Medium | None = None
    numbers: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, str] = field(default_factory=dict)
    dataset: str | None = None
    recording: str | None = None
    frame: int | None = None
    run: str | None = None
    link: str | None = None
    note: str = ""

    def __post_init__(self) -> None:
        if (self.figure is None) == (not self.content) or bool(self.content) != (self.medium in get_args(Medium)):
            raise ArgumentError("a pin must hold either a figure, or a content and its medium")
