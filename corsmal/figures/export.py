"""Figures as SVG, PDF and PNG files for a paper or a talk.

They are drawn by Kaleido, the exporter that Plotly's makers maintain: it runs the pages' own Plotly in a Chrome or
Chromium without a window, so that a file looks like the page. Files hold vectors, except for 3D, which is a picture. No
network is needed: Plotly's code comes from the installed package, and MathJax, which Kaleido would fetch, is switched
off. Its predecessor Orca is no longer maintained, and the browser's own export (``Plotly.toImage``) writes no PDF and
needs an open page. Without a browser everything else works; exporting says in one sentence how to install one.
"""

import asyncio
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Literal, get_args

import plotly.graph_objects as go

from corsmal.errors import ArgumentError, CorsmalError, NotFoundError, check_choice
from corsmal.figures.paper import FONT_PX, on_paper
from corsmal.figures.style import Part
from corsmal.files import writing

FigureFormat = Literal["svg", "pdf", "png"]
FIGURE_FORMATS: tuple[FigureFormat, ...] = get_args(FigureFormat)

PX_PER_INCH, POINTS_PER_INCH, MM_PER_INCH = 96.0, 72.0, 25.4
WIDTH_MM = 160.0
"""Of text on A4 paper."""
ASPECT = 0.62
"""Height over width of a figure that has no height of its own."""
DPI = 300.0
WIDTH_PX_MAX = 10_000
TIMEOUT_S = 90.0

NO_BROWSER = (
    "Drawing figures as files needs Chrome or Chromium, and there is none: install it (on Debian: apt-get install "
    "chromium), or set BROWSER_PATH to its program."
)

Picture = tuple[dict[str, Any], dict[str, Any]]
"""A figure's plain values, and Kaleido's options: format, width, height and scale."""

_browsers = threading.BoundedSemaphore(2)
"""Browsers of one process at a time, however many visitors download figures."""

Progress = Callable[[int, int], None]
"""Is called with the number done and their total."""


class ExportError(CorsmalError):
    """The browser that draws figures failed; the text says with what."""


def export_figure(
    figure: go.Figure | Part,
    path: str | Path | None = None,
    *,
    file_format: FigureFormat | None = None,
    width_mm: float | None = None,
    width_px: int | None = None,
    font_pt: float = 8.0,
    is_grey: bool = False,
) -> bytes:
    """Draw a figure as a file.

    The whole figure is scaled so that its text has the wanted size: lines, points and margins keep their proportions
    to the text. Its height is its own; one without a height is ``ASPECT`` as high as wide.

    Args:
        figure: the figure, or the parts of a ``Drawing``.
        path: where it is written; an older file is replaced. None: it is only returned.
        file_format: ``svg``, ``pdf`` or ``png``; default: the path's ending.
        width_mm: of the file, for paper; a PNG has 300 pixels per inch. Default: 160, the text's width on A4.
        width_px: of the file in pixels, for a screen, instead of ``width_mm``.
        font_pt: size of the text, in points: 1/72 inch, on a screen 4/3 pixels.
        is_grey: whether it is drawn in greys that stay apart, see ``in_grey``.

    Returns:
        The file's content.

    Raises:
        ArgumentError: the format is unknown, or a size is not positive or too large.
        NotFoundError: there is neither Chrome nor Chromium here.
        ExportError: the browser failed.
        FileError: the file cannot be written.

    Example:
        >>> export_figure(profile_figure(hull, dimensions), "profile.pdf", width_mm=86, font_pt=8)  # doctest: +SKIP
    """
    wanted = file_format or Path(path or "").suffix.removeprefix(".")
    check_choice("file_format", wanted, FIGURE_FORMATS)
    picture = picture_of(
        figure, file_format=wanted, width_mm=width_mm, width_px=width_px, font_pt=font_pt, is_grey=is_grey
    )
    [content] = draw_pictures([picture])
    if path is not None:
        with writing(Path(path), advice="choose another file") as part:
            part.write_bytes(content)
    return content


def picture_of(
    figure: go.Figure | Part,
    *,
    file_format: str,
    width_mm: float | None = None,
    width_px: int | None = None,
    font_pt: float = 8.0,
    is_grey: bool = False,
) -> Picture:
    """What ``draw_pictures`` takes; the arguments are those of ``export_figure``.

    Raises:
        ArgumentError: a size is not positive or too large.
    """
    if width_mm is not None and width_px is not None:
        raise ArgumentError(f"width_mm and width_px exclude each other, got {width_mm} and {width_px}")
    inches = (WIDTH_MM if width_mm is None else width_mm) / MM_PER_INCH
    width = inches * PX_PER_INCH if width_px is None else float(width_px)
    if not 0 < width <= WIDTH_PX_MAX:
        raise ArgumentError(f"the width must be above 0 and at most {WIDTH_PX_MAX} pixels, got {width:g}")
    if not 1 <= font_pt <= 100:
        raise ArgumentError(f"font_pt must be from 1 to 100 points, got {font_pt:g}")
    scale = font_pt * PX_PER_INCH / POINTS_PER_INCH / FONT_PX
    parts = on_paper(figure, is_grey=is_grey)
    drawn_px = max(width / scale, 10.0)
    height_px = parts["layout"].get("height") or ASPECT * drawn_px
    if file_format == "png" and width_px is None:
        scale *= DPI / PX_PER_INCH
    return parts, {"format": file_format, "width": drawn_px, "height": float(height_px), "scale": scale}


def find_browser() -> str | None:
    """The program that would draw figures; None where there is none."""
    from choreographer.browsers.chromium import Chromium  # noqa: PLC0415 - only exporting needs it

    named = os.environ.get("BROWSER_PATH")
    if named:
        return named if Path(named).is_file() else None
    found = Chromium.find_browser(skip_local=False)
    return None if found is None else str(found)


def draw_pictures(
    pictures: Sequence[Picture], *, progress: Progress | None = None, cancelled: Callable[[], bool] = lambda: False
) -> list[bytes]:
    """Draw several figures in one browser, which takes seconds to start.

    Args:
        pictures: from ``picture_of``.
        progress: is called after each.
        cancelled: is asked before each whether to stop.

    Returns:
        The files' contents, in order; when cancelled, those that are done.

    Raises:
        NotFoundError: there is neither Chrome nor Chromium here.
        ExportError: the browser failed.
    """
    if not pictures:
        return []
    with _browsers, ThreadPoolExecutor(1) as executor:  # the caller may have an event loop of its own
        return executor.submit(lambda: asyncio.run(_draw(pictures, progress, cancelled))).result()


async def _draw(pictures: Sequence[Picture], progress: Progress | None, cancelled: Callable[[], bool]) -> list[bytes]:
    from kaleido import Kaleido  # noqa: PLC0415 - only exporting needs it
    from kaleido.errors import ChromeNotFoundError  # noqa: PLC0415 - as above

    done: list[bytes] = []
    try:
        async with Kaleido(n=1, timeout=TIMEOUT_S, mathjax=False) as browser:
            for parts, options in pictures:
                if cancelled():
                    break
                done.append(await browser.calc_fig(parts, opts=options))
                if progress is not None:
                    progress(len(done), len(pictures))
    except ChromeNotFoundError as error:
        raise NotFoundError(NO_BROWSER) from error
    except Exception as error:  # Kaleido's errors have no common root
        raise ExportError(f"the browser that draws figures failed: {error!r}") from error
    return done
