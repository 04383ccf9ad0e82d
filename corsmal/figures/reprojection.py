"""The fitted circumferences over the picture and mask that they were fitted to."""

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.figures.drawing import Drawing, Drawn
from corsmal.figures.overlay import Image, jpeg_uri, paint_mask
from corsmal.figures.style import CONTAINER, INSIDE, OUTSIDE, axis, pixels_below, plain_layout, rgb, scatter
from corsmal.geometry import Camera
from corsmal.parameters import ShapeParameters
from corsmal.shape import Hull, circumference_points, on_mask

MARGIN_PX = 40
TINT = 0.3


@Drawing
def reprojection_figure(
    image: Image, mask: NDArray[np.bool_], camera: Camera, hull: Hull, *, parameters: ShapeParameters
) -> Drawn:
    """The converged circumferences' points in one view: those on and those off the mask.

    Args:
        image: (H, W, 3) uint8 RGB; the figure, in its pixels, is cropped around the mask.
        mask: (H, W) bool, the container's.
        camera: of this view.
        hull: the fitted hull.
        parameters: that it was fitted with.
    """
    points = parameters.points
    rings = circumference_points(hull, points=points, angle_rule=parameters.angle_rule)[hull.converged]
    pixels = camera.project(rings.reshape(-1, 3))
    radii = np.repeat(hull.radii_mm[hull.converged], points)
    heights = np.repeat(hull.heights_mm[hull.converged], points)
    inside = on_mask(mask, pixels, pixel_rule=parameters.pixel_rule)
    traces = [
        scatter(
            *pixels[chosen].T.astype(np.float32),
            mode="markers",
            customdata=np.column_stack([radii[chosen], heights[chosen]]).astype(np.float32),
            name=f"{name}: {int(chosen.sum()):,}",
            marker={"color": colour, "size": 4},
            hovertemplate="radius %{customdata[0]:.1f} mm<br>z %{customdata[1]:.1f} mm",
        )
        | {"type": "scattergl"}
        for name, chosen, colour in (("on the mask", inside, INSIDE), ("off the mask", ~inside, OUTSIDE))
    ]
    left, top, right, bottom = _crop(mask, image.shape)
    crop = image[top:bottom, left:right].copy()
    paint_mask(crop, mask[top:bottom, left:right], rgb_colour=rgb(CONTAINER), opacity=TINT)
    plain = {"showgrid": False, "zeroline": False}
    layout = plain_layout(
        images=[pixels_below(jpeg_uri(crop), (left, top, right, bottom))],
        xaxis=axis("x (pixels)", range=[left - 0.5, right - 0.5], **plain),
        yaxis=axis("y (pixels)", range=[bottom - 0.5, top - 0.5], scaleanchor="x", **plain),
    )
    return traces, layout


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
