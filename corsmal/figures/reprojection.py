"""The fitted circumferences over the picture and mask that they were fitted to."""

import base64

import cv2
import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from corsmal.figures.overlay import Image, jpeg
from corsmal.figures.style import CONTAINER, INSIDE, OUTSIDE, plain_layout, rgb
from corsmal.geometry import Camera
from corsmal.shape import Hull, circumference_points, on_mask

MARGIN_PX = 40


def reprojection_figure(image: Image, mask: NDArray[np.bool_], camera: Camera, hull: Hull, *, points: int) -> go.Figure:
    """The converged circumferences' points in one view: those on the mask and those off it told apart.

    Args:
        image: (H, W, 3) uint8 RGB.
        mask: (H, W) bool, the container's.
        camera: of this view.
        hull: the fitted hull.
        points: N, points per circumference.

    Returns:
        A figure in pixels, cropped around the mask, x to the right and y down.
    """
    rings = circumference_points(hull, points=points)[hull.converged]
    pixels = camera.project(rings.reshape(-1, 3))
    radii = np.repeat(hull.radii_mm[hull.converged], points)
    heights = np.repeat(hull.heights_mm[hull.converged], points)
    figure = go.Figure(layout=plain_layout())
    left, top, right, bottom = _crop(mask, image.shape)
    figure.add_layout_image(
        source=_data_uri(_tinted(image, mask)[top:bottom, left:right]),
        x=left - 0.5,
        y=top - 0.5,
        sizex=right - left,
        sizey=bottom - top,
        xref="x",
        yref="y",
        sizing="stretch",
        layer="below",
    )
    inside = on_mask(mask, pixels)
    for name, chosen, colour in (("on the mask", inside, INSIDE), ("off the mask", ~inside, OUTSIDE)):
        figure.add_scattergl(
            x=pixels[chosen, 0].astype(np.float32),
            y=pixels[chosen, 1].astype(np.float32),
            customdata=np.column_stack([radii[chosen], heights[chosen]]).astype(np.float32),
            name=f"{name}: {int(chosen.sum()):,}",
            mode="markers",
            marker={"color": colour, "size": 4},
            hovertemplate="radius %{customdata[0]:.1f} mm<br>z %{customdata[1]:.1f} mm",
        )
    figure.update_xaxes(range=[left - 0.5, right - 0.5], title="x (pixels)", showgrid=False, zeroline=False)
    figure.update_yaxes(
        range=[bottom - 0.5, top - 0.5], title="y (pixels)", scaleanchor="x", showgrid=False, zeroline=False
    )
    return figure


def _crop(mask: NDArray[np.bool_], shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of the mask's box with a margin; the whole image for an empty mask."""
    x, y, width, height = cv2.boundingRect(mask.view(np.uint8))
    if width == 0:
        return 0, 0, shape[1], shape[0]
    return (
        max(0, x - MARGIN_PX),
        max(0, y - MARGIN_PX),
        min(shape[1], x + width + MARGIN_PX),
        min(shape[0], y + height + MARGIN_PX),
    )


def _tinted(image: Image, mask: NDArray[np.bool_]) -> Image:
    picture = image.copy()
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    picture[mask] = (0.7 * picture[mask] + 0.3 * np.array(rgb(CONTAINER))).astype(np.uint8)
    cv2.drawContours(picture, contours, -1, rgb(CONTAINER), 1)
    return picture


def _data_uri(image: Image) -> str:
    return "data:image/jpeg;base64," + base64.b64encode(jpeg(image, quality=92)).decode()
