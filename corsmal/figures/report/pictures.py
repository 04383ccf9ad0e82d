"""The figures of a report as pictures: they show without a script and are what is printed."""

from collections.abc import Callable
from typing import Any

from corsmal.figures.export import Picture, Progress, draw_pictures
from corsmal.figures.paper import is_spatial, on_paper, still
from corsmal.figures.report.blocks import Chart, Pinned, Report

WIDTH_PX, SPATIAL_WIDTH_PX = 960, 720
HEIGHT_PX, SPATIAL_HEIGHT_PX = 420, 500
"""Of pinned figures without a height of their own."""
SPATIAL_SCALE = 1.25
"""Pixels of a picture of something in space, per pixel of the page."""

MEDIA = {"svg": "image/svg+xml", "png": "image/png"}


def figure_parts(block: Chart | Pinned) -> dict[str, Any]:
    """A block's figure as plain values, of the size that it has in a report."""
    figure = block.figure if isinstance(block, Chart) else block.pin.figure
    if figure is None:
        return {"data": [], "layout": {}}
    parts = on_paper(figure, is_still=False)
    width, height = (SPATIAL_WIDTH_PX, SPATIAL_HEIGHT_PX) if is_spatial(parts) else (WIDTH_PX, HEIGHT_PX)
    own = block.height_px if isinstance(block, Chart) else parts["layout"].get("height") or height
    parts["layout"] |= {"width": width, "height": own}
    return parts


def picture_format(parts: dict[str, Any]) -> str:
    """Vectors, or pixels for what is in space."""
    return "png" if is_spatial(parts) else "svg"


def draw_report(
    report: Report, *, progress: Progress | None = None, cancelled: Callable[[], bool] = lambda: False
) -> list[bytes]:
    """Draw a report's figures as pictures, for ``report_html``.

    Args:
        report: its figures take about a second each, and the browser that draws them a few more to start.
        progress: is called after each.
        cancelled: is asked before each whether to stop.

    Returns:
        The pictures, in the order of ``Report.figures``; when cancelled, those that are done.

    Raises:
        NotFoundError: there is neither Chrome nor Chromium here.
        ExportError: the browser failed.
    """
    pictures = [_picture(figure_parts(block)) for block in report.figures()]
    return draw_pictures(pictures, progress=progress, cancelled=cancelled)


def _picture(parts: dict[str, Any]) -> Picture:
    layout, file_format = parts["layout"], picture_format(parts)
    scale = 1.0 if file_format == "svg" else SPATIAL_SCALE
    return still(parts), {"format": file_format, "width": layout["width"], "height": layout["height"], "scale": scale}
