"""A report as one HTML file: what it is made of, and how that becomes a page that opens without a network."""

from corsmal.figures.report.blocks import (
    Answers,
    Banner,
    Block,
    Chart,
    Commands,
    Pinned,
    Report,
    Section,
    Table,
    Table2,
    Text,
    Tile,
    TileLine,
    Tiles,
)
from corsmal.figures.report.page import report_html
from corsmal.figures.report.pictures import draw_report

__all__ = [
    "Answers",
    "Banner",
    "Block",
    "Chart",
    "Commands",
    "Pinned",
    "Report",
    "Section",
    "Table",
    "Table2",
    "Text",
    "Tile",
    "TileLine",
    "Tiles",
    "draw_report",
    "report_html",
]
