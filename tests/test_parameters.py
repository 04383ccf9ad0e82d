import pytest

from corsmal.errors import ArgumentError
from corsmal.parameters import HeightRange, SelectionParameters, ShapeParameters


def test_paper_holds_the_numbers_of_table_1():
    paper = ShapeParameters.paper()
    assert (paper.circumferences, paper.points, paper.radii) == (145, 19, 145)
    assert (paper.radius_max_mm, paper.radius_min_mm, paper.max_difference_mm) == (75, 2.5, 1)
    assert (paper.fit_rule, paper.height_range) == ("any", HeightRange("masks", -20, 20))


def test_lode_asks_all_views_over_its_fixed_range():
    lode = ShapeParameters.lode()
    assert (lode.circumferences, lode.fit_rule, lode.width_rule) == (500, "all", "widest")
    assert lode.height_range == HeightRange("world", -100, 400)


@pytest.mark.parametrize(
    "changes",
    [
        {"circumferences": 1},
        {"points": 2},
        {"radii": 1},
        {"radius_min_mm": 0},
        {"radius_min_mm": 80},
        {"radius_max_mm": float("nan")},
        {"max_difference_mm": -1},
        {"max_difference_mm": float("nan")},
        {"fit_rule": "most"},
        {"width_rule": "middle"},
        {"method": "guess"},
        {"tilt_deg": -1},
        {"tilt_deg": float("nan")},
        {"wall_mm": 11},
        {"frames": 0},
    ],
)
def test_impossible_shape_parameters_are_refused(changes):
    with pytest.raises(ArgumentError, match=next(iter(changes))):
        ShapeParameters(**changes)


def test_impossible_ranges_and_filters_are_refused():
    with pytest.raises(ArgumentError, match="low_mm"):
        HeightRange("world", 10, 10)
    with pytest.raises(ArgumentError, match="reference"):
        HeightRange("moon", -10, 10)
    with pytest.raises(ArgumentError, match="score_min"):
        SelectionParameters(score_min=1.5)
    with pytest.raises(ArgumentError, match="detections_max"):
        SelectionParameters(detections_max=0)
