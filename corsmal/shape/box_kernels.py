"""The compiled loop of the fit of a box."""

import numba
import numpy as np


@numba.njit(nogil=True, cache=True, error_model="numpy")
def reach_errors(  # type: ignore[no-untyped-def]
    boxes, projections, directions, reach_px
):  # pragma: no cover - compiled
    """(B, V·D) pixels by which the silhouettes of boxes reach beyond masks.

    Args: boxes (B, 9) place of the middle (m), width, depth, height (m), turn and the two slopes of the axis;
    projections (V, 3, 4); directions (D, 2) unit vectors of the image; reach_px (V, D) how far the masks reach.
    """
    views, ways = reach_px.shape
    errors, corner, places = np.empty((len(boxes), views * ways)), np.empty(3), np.empty((8, 2))
    for b in range(len(boxes)):
        length = np.sqrt(boxes[b, 7] ** 2 + boxes[b, 8] ** 2 + 1)
        i, j, k = boxes[b, 7] / length, boxes[b, 8] / length, 1 / length
        level = np.sqrt(j * j + k * k)  # the frame is that of ``corsmal.shape.outlines.Axis``
        cosine, sine = np.cos(boxes[b, 6]), np.sin(boxes[b, 6])
        for v in range(views):
            camera = projections[v]
            for c in range(8):
                x = boxes[b, 3] * (0.5 if c & 4 else -0.5)
                y = boxes[b, 4] * (0.5 if c & 2 else -0.5)
                z = boxes[b, 5] * (0.5 if c & 1 else -0.5)
                x, y = cosine * x - sine * y, sine * x + cosine * y
                corner[0] = boxes[b, 0] + x * level + z * i
                corner[1] = boxes[b, 1] - x * i * j / level + y * k / level + z * j
                corner[2] = boxes[b, 2] - x * i * k / level - y * j / level + z * k
                depth = camera[2, 0] * corner[0] + camera[2, 1] * corner[1] + camera[2, 2] * corner[2] + camera[2, 3]
                for row in range(2):
                    at = camera[row, 0] * corner[0] + camera[row, 1] * corner[1] + camera[row, 2] * corner[2]
                    places[c, row] = (at + camera[row, 3]) / max(depth, 1e-6)
            for d in range(ways):
                reach = -np.inf
                for c in range(8):
                    reach = max(reach, places[c, 0] * directions[d, 0] + places[c, 1] * directions[d, 1])
                errors[b, v * ways + d] = reach - reach_px[v, d]
    return errors
