"""A report as one HTML file that opens, prints and turns its hulls without a network."""

import base64
import gzip
import hashlib
import html
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import plotly.offline

from corsmal.errors import ArgumentError
from corsmal.figures.report.blocks import Block, Report, Section
from corsmal.figures.report.writing import Writer

_POLICY = (
    "default-src 'none'; img-src data: blob:; media-src data:; style-src 'unsafe-inline'; "
    "script-src 'sha256-{digest}' 'strict-dynamic' 'unsafe-eval' blob:; base-uri 'none'; form-action 'none'"
)
"""What a browser lets the file do: run its own script, which unpacks Plotly. Nothing is fetched or sent."""


def report_html(report: Report, *, pictures: Sequence[bytes] = ()) -> str:
    """A report as a page.

    Everything is in it. Figures are shown as pictures, which is also what is printed; a click makes one live, so that
    it can be turned and its numbers read. Plotly is in the file once, packed, and is only unpacked for that, or where
    pictures are missing: the reader's browser then draws them.

    Args:
        report: what it says.
        pictures: from ``draw_report``; empty: the reader's browser draws them when the page is opened.

    Raises:
        ArgumentError: there are pictures, but not one for each figure.
    """
    count = sum(1 for _ in report.figures())
    if pictures and len(pictures) != count:
        raise ArgumentError(f"pictures must be one for each of the {count} figures, got {len(pictures)}")
    writer = Writer(pictures)
    body = "".join([_header(report), *(_section(section, writer) for section in report.sections)])
    script = _asset("report.js") if count else ""
    policy = _POLICY.format(digest=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode())
    head = (
        f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{html.escape(report.title)}'
        f'</title><meta http-equiv="Content-Security-Policy" content="{html.escape(policy, quote=True)}">'
        f"<style>{_asset('report.css')}</style>"
    )
    plotly = f'<script type="text/plain" id="plotly">{_packed_plotly()}</script><script>{script}</script>'
    page = f"<main>{body}</main>{plotly if count else ''}"
    return f'<!doctype html><html lang="en"><head>{head}</head><body>{page}</body></html>'


def _header(report: Report) -> str:
    by = " · ".join(html.escape(part) for part in (report.author, report.made) if part)
    kind = "warning" if report.banner.is_warning else "fact"
    banner = f"<b>{html.escape(report.banner.kind)}.</b> {html.escape(report.banner.text)}"
    title = f'<h1>{html.escape(report.title)}</h1><p class="by">{by}</p>'
    return f'<header>{title}<p class="banner {kind}">{banner}</p></header>'


def _section(section: Section, writer: Writer) -> str:
    blocks: list[Block] = list(section.blocks)
    start = ' class="page"' if section.starts_page else ""
    return f"<section{start}><h2>{html.escape(section.heading)}</h2>{''.join(map(writer.block, blocks))}</section>"


@cache
def _packed_plotly() -> str:
    """Plotly's code, packed to less than half: as text that a page can unpack."""
    code = plotly.offline.get_plotlyjs().encode()
    return base64.b64encode(gzip.compress(code, compresslevel=6, mtime=0)).decode("ascii")


@cache
def _asset(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
