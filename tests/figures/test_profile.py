import numpy as np
import pytest

from corsmal.figures import profile_figure
from corsmal.figures.style import PRESET_COLOURS
from corsmal.shape import Dimensions, Hull, KnownProfile
from tests.figures.made import made_dimensions, made_hull, traces

ANNOTATED = KnownProfile.frustum(61.0, 98.0, 119.0)


def test_radii_are_told_apart_by_what_became_of_them():
    found = traces(profile_figure(made_hull(), made_dimensions()))
    assert {name: list(zip(trace.x, trace.y, strict=True)) for name, trace in found.items()} == {
        "kept": [(40, 50), (40.5, 60), (41, 70), (60, 90)],
        "rejected by d_max": [(55, 40), (41.5, 80)],
        "unfitted": [(2.5, 30)],
    }
    assert found["kept"].mode == "lines+markers"
    assert found["rejected by d_max"].mode == "markers"


def test_the_ends_are_lines_across_the_figure_with_their_widths():
    layout = profile_figure(made_hull(), made_dimensions()).layout
    assert [(line.x0, line.x1, line.y0, line.y1) for line in layout.shapes] == [(0, 1, 50, 50), (0, 1, 70, 70)]
    assert {line.xref for line in layout.shapes} == {"x domain"}
    assert [(note.y, note.text) for note in layout.annotations] == [
        (50, "i_b, lower end: 80.0 mm wide"),
        (70, "i_t, upper end: 82.0 mm wide"),
    ]


def test_ends_at_the_same_height_and_width_keep_both_their_captions():
    dimensions = Dimensions(1.0, 80.0, 80.0, 0.1, kept=np.array([2, 3, 4]), bottom=2, top=2)
    assert len(profile_figure(made_hull(), dimensions).layout.annotations) == 2


def test_the_annotated_frustum_stands_on_the_lower_end():
    figure = profile_figure(made_hull(), made_dimensions(), known=ANNOTATED)
    truth = traces(figure)["annotated size, from the lower end up"]
    assert list(truth.x) == [0, 30.5, 49, 0]
    assert list(truth.y) == [50, 50, 169, 169]


def test_a_true_profile_stands_where_its_base_is_whatever_was_fitted():
    true = KnownProfile([0, 10, 20], [30, 5, 40], "true profile", base_mm=44)
    truth = traces(profile_figure(made_hull(), Dimensions(reason="d_max is too small"), known=true))["true profile"]
    assert list(truth.x) == [0, 30, 5, 40, 0]
    assert list(truth.y) == [44, 44, 54, 64, 64]


def test_each_preset_has_its_colour_on_either_side_of_a_comparison():
    hull = made_hull()
    for fitted, other in (("paper", "tuned"), ("tuned", "paper")):
        found = traces(profile_figure(hull, made_dimensions(), preset=fitted, beside=(other, hull)))
        assert found["kept"].marker.color == found["kept"].line.color == PRESET_COLOURS[fitted]
        assert found[other].line.color == PRESET_COLOURS[other]


def test_scales_are_equal_and_the_widest_radius_is_inside():
    layout = profile_figure(made_hull(), made_dimensions()).layout
    assert layout.yaxis.scaleanchor == "x"
    assert layout.xaxis.range == pytest.approx((0, 66))


def test_heights_far_from_the_container_do_not_make_it_small():
    heights_mm = np.linspace(-100, 400, 51)
    converged = (heights_mm >= 0) & (heights_mm <= 120)
    hull = Hull(heights_mm, np.where(converged, 40.0, 2.5), converged, np.zeros(3))
    figure = profile_figure(hull, Dimensions(reason="none"))
    assert figure.layout.yaxis.range == pytest.approx((-36, 156))
    assert len(traces(figure)["unfitted; double-click to see all"].y) == 51 - 13
    taller = KnownProfile([0, 200], [40, 40], "true profile", base_mm=0)
    assert profile_figure(hull, Dimensions(reason="none"), known=taller).layout.yaxis.range == pytest.approx((-60, 260))
    assert profile_figure(made_hull(), made_dimensions()).layout.yaxis.range is None


def test_failed_measures_leave_the_radii_without_ends_and_truth():
    figure = profile_figure(made_hull(), Dimensions(reason="d_max is too small"), known=ANNOTATED)
    assert set(traces(figure)) == {"rejected by d_max", "unfitted"}
    assert len(figure.layout.shapes) == 0


def test_a_failed_hull_is_an_empty_figure():
    figure = profile_figure(Hull.failed("no"), Dimensions(reason="no"), known=ANNOTATED)
    assert len(figure.data) == 0
    assert list(figure.layout.xaxis.range) == pytest.approx([0, 1.1 * 98 / 2])


def test_another_hull_is_a_line_over_the_radii():
    hull = made_hull()
    other = Hull(hull.heights_mm, hull.radii_mm + 30, hull.converged, hull.centroid_m)
    figure = profile_figure(hull, made_dimensions(), beside=("tuned", other))
    line = traces(figure)["tuned"]
    assert list(line.x) == [85, 70, 70.5, 71, 71.5, 90]
    assert list(line.y) == [40, 50, 60, 70, 80, 90]
    assert figure.layout.xaxis.range == pytest.approx((0, 99))
