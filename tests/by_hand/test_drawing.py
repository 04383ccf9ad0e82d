"""The tools on arrays, against what each pixel's middle says."""

from functools import partial

import numpy as np
import pytest

from corsmal.by_hand import brush, eraser, fill, polygon
from corsmal.by_hand.drawing import OUTSIDE
from corsmal.errors import ArgumentError

SHAPE = (40, 60)


def empty():
    return np.zeros(SHAPE, dtype=bool)


def distance_to_segment(start, end):
    """Of every pixel's middle to a segment of pixels' (x, y)."""
    rows, columns = np.indices(SHAPE) + 0.5
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    along = end - start
    places = np.stack([columns, rows], axis=-1) - start
    share = np.clip(places @ along / max(along @ along, 1e-9), 0, 1)
    return np.linalg.norm(places - share[..., None] * along, axis=-1)


@pytest.mark.parametrize(("start", "end"), [((20, 20), (20, 20)), ((10, 12), (45, 30)), ((30, 8), (30, 33))])
def test_a_stroke_covers_the_pixels_within_its_radius(start, end):
    drawn = brush(empty(), [start, end], radius_px=6).mask
    distance = distance_to_segment(start, end)
    assert drawn[distance < 5].all()
    assert not drawn[distance > 7].any()


def test_the_eraser_removes_what_the_brush_would_add():
    everything = np.ones(SHAPE, dtype=bool)
    points = [(12, 30), (44, 9)]
    erased = eraser(everything, points, radius_px=5).mask
    np.testing.assert_array_equal(~erased, brush(empty(), points, radius_px=5).mask)
    assert everything.all()  # what was given is not changed


def test_a_polygon_holds_the_pixels_whose_middle_it_holds():
    drawn = polygon(empty(), [(10, 5), (30, 5), (30, 25), (10, 25)]).mask
    rows, columns = np.nonzero(drawn)
    assert drawn[5:25, 10:30].all()
    assert (rows.min(), rows.max(), columns.min(), columns.max()) in {(5, 24, 10, 29), (5, 25, 10, 30)}


def test_a_polygon_replaces_the_mask():
    mask = empty()
    mask[30:35, 40:50] = True
    drawn = polygon(mask, [(5, 5), (20, 5), (12, 20)]).mask
    assert not drawn[32, 45]
    assert drawn[8, 12]
    assert mask[32, 45]


def test_a_polygon_may_leave_the_picture():
    drawn = polygon(empty(), [(-100, 10), (30, 10), (30, 500), (-100, 500)])
    assert drawn.said == ""
    assert drawn.mask[15:, :29].all()
    assert not drawn.mask[:9].any()


def test_a_hole_is_filled_and_nothing_else():
    mask = empty()
    mask[10:30, 10:40] = True
    mask[15:20, 15:25] = False
    filled = fill(mask, (18, 17))
    assert filled.mask[10:30, 10:40].all()
    assert filled.mask.sum() == 20 * 30
    assert filled.said == ""


@pytest.mark.parametrize(
    ("point", "said"),
    [((2, 2), "open to the picture's border"), ((12, 12), "in the mask already"), ((-3, 5), OUTSIDE)],
)
def test_what_cannot_be_filled_is_said(point, said):
    mask = empty()
    mask[10:30, 10:40] = True
    filled = fill(mask, point)
    assert said in filled.said
    np.testing.assert_array_equal(filled.mask, mask)


@pytest.mark.parametrize("tool", [brush, eraser])
def test_a_stroke_outside_the_picture_draws_nothing_and_says_so(tool):
    mask = empty()
    mask[5:9, 5:9] = True
    drawn = tool(mask, [(-50, -50), (-80, -20)], radius_px=10)
    assert drawn.said == OUTSIDE
    np.testing.assert_array_equal(drawn.mask, mask)


def test_a_polygon_outside_the_picture_draws_nothing_and_says_so():
    assert polygon(empty(), [(-50, -50), (-20, -50), (-20, -20)]).said == OUTSIDE


@pytest.mark.parametrize(
    "points",
    [
        [],
        [(1, 2, 3)],
        [(np.nan, 1.0)],
        [(np.inf, 1.0)],
        [(1e9, 0)],
        [(10**400, 0)],
        [(10**5000, 0)],
        "text",
        [("a", 1)],
    ],
    ids=["none", "three numbers", "NaN", "infinity", "far away", "beyond floats", "beyond texts", "a text", "a letter"],
)
def test_points_that_are_none_are_refused(points):
    for tool in (partial(brush, radius_px=3), partial(eraser, radius_px=3), polygon):
        with pytest.raises(ArgumentError, match="points must be"):
            tool(empty(), points)
    if len(points) == 1:
        with pytest.raises(ArgumentError, match="points must be"):
            fill(empty(), points[0])


def test_a_radius_and_a_mask_that_are_none_are_refused():
    with pytest.raises(ArgumentError, match="radius_px must lie between"):
        brush(empty(), [(1, 1)], radius_px=0)
    for radius_px in (np.nan, np.inf, 10**400, 10**5000, None, [1, 2]):
        with pytest.raises(ArgumentError, match="radius_px must be"):
            brush(empty(), [(1, 1)], radius_px=radius_px)
    with pytest.raises(ArgumentError, match="mask must be"):
        brush(np.zeros(SHAPE), [(1, 1)], radius_px=2)
