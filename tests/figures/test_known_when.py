import numpy as np
import pytest

from corsmal.dataset import Annotation
from corsmal.figures.known_when import known_when_figure
from corsmal.figures.style import BEST, CONTAINER, LEVEL_COLOURS, PRESET_COLOURS, TOTAL, TYPE_COLOURS
from corsmal.stages.moments import Moment
from tests.figures.test_sound import made_picture, of_axis, texts

HEARD = {"type_p0": 0.1, "type_p1": 0.2, "type_p2": 0.7, "type_p3": 0.0} | dict.fromkeys(("level_p0", "level_p1"), 0.5)


def moment(time_s, capacity_ml, *, status="fitted", half_ml=None, container_g=10.0, object_g=None, heard=True):
    row = {
        "status": status,
        "capacity_ml": capacity_ml,
        "container_mass_g": container_g,
        "object_mass_g": object_g,
        **(HEARD | {"level_p2": 0.0} if heard else dict.fromkeys([*HEARD, "level_p2"])),
    }
    if half_ml is not None:
        row |= {"capacity_ml_low": capacity_ml - half_ml, "capacity_ml_high": capacity_ml + half_ml}
    return Moment(time_s, row)


MOMENTS = [
    moment(0.5, None, status="failed", container_g=None),
    moment(1.0, 500.0, half_ml=50.0, object_g=200.0),
    moment(1.5, 520.0, half_ml=20.0, object_g=210.0),
    moment(2.0, 510.0, object_g=215.0),
]


def panel_of(figure, start):
    """The y axis of the panel whose caption starts so."""
    panels = [text for text in texts(figure) if text.startswith("<b>")]
    number = next(index for index, text in enumerate(panels, 1) if text.startswith(f"<b>{start}"))
    return f"y{number}" if number > 1 else "y"


def test_capacity_is_a_line_with_gaps_above_the_band_of_its_intervals():
    figure = known_when_figure(MOMENTS, end_s=2.0)
    band, line = of_axis(figure, panel_of(figure, "Capacity"))
    assert list(line.x) == [0.5, 1.0, 1.5, 2.0]
    assert list(line.y) == [None, 500.0, 520.0, 510.0]
    assert list(band.x) == [1.0, 1.5, 1.5, 1.0, None]
    assert list(band.y) == [550.0, 540.0, 500.0, 450.0, None]
    assert (line.line.color, band.fillcolor) == (PRESET_COLOURS["tuned"],) * 2
    papers = known_when_figure(MOMENTS, end_s=2.0, preset="paper")
    assert {part.line.color for part in of_axis(papers, panel_of(papers, "Capacity"))[1:]} == {PRESET_COLOURS["paper"]}
    assert list(line.customdata) == ["", " (90 %: 450–550 mL)", " (90 %: 500–540 mL)", ""]
    assert "<b>Capacity</b> from the frames so far, band: 90 % interval" in texts(figure)


def test_without_intervals_there_is_no_band():
    figure = known_when_figure([moment(1.0, 500.0)], end_s=1.0)
    assert [trace.name for trace in of_axis(figure, panel_of(figure, "Capacity"))] == ["capacity"]
    assert "<b>Capacity</b> from the frames so far" in texts(figure)


def test_a_training_mean_is_not_drawn_as_if_it_were_measured():
    figure = known_when_figure([moment(1.0, 640.0, status="fallback: training mean", object_g=1.0)], end_s=1.0)
    assert [list(trace.y) for trace in figure.data if trace.mode == "lines+markers"] == [[None]] * 3


def test_probabilities_are_areas_in_the_colours_of_their_classes():
    figure = known_when_figure(MOMENTS, end_s=2.0)
    for start, colours in (("Type", TYPE_COLOURS), ("Level", LEVEL_COLOURS)):
        areas = of_axis(figure, panel_of(figure, start))
        assert {trace.name: trace.fillcolor for trace in areas} == colours
        np.testing.assert_allclose(areas[0].x, [0.5, 1.0, 1.5, 2.0])
        np.testing.assert_allclose(sum(trace.y for trace in areas), 100, rtol=1e-5)


def test_masses_of_container_and_object_are_drawn_apart():
    figure = known_when_figure(MOMENTS, end_s=2.0)
    container, both = of_axis(figure, panel_of(figure, "Mass"))
    assert (container.line.color, both.line.color) == (CONTAINER, TOTAL)
    assert list(container.y) == [None, 10.0, 10.0, 10.0]
    assert list(both.y) == [None, 200.0, 210.0, 215.0]


def test_panels_of_which_nothing_is_known_are_left_out():
    silent = [moment(1.0, 500.0, container_g=None, heard=False)]
    figure = known_when_figure(silent, end_s=1.0)
    assert texts(figure) == ["<b>Capacity</b> from the frames so far"]
    with_sound = known_when_figure(silent, end_s=1.0, picture=made_picture())
    assert texts(with_sound)[0].startswith("<b>Log-mel</b> by the paper's front end: ln power")
    assert with_sound.layout.images[0].yref == "y"
    assert with_sound.layout.yaxis.title.text == "kHz"


def test_axes_have_units_and_share_the_time():
    figure = known_when_figure(MOMENTS, end_s=2.0, picture=made_picture())
    units = [figure.layout[f"yaxis{number}"].title.text for number in ("", 2, 3, 4, 5)]
    assert units == ["kHz", "%", "%", "mL", "g"]
    assert figure.layout.xaxis.title.text == "time (s)"
    assert figure.layout.xaxis.range == (0, 2.0)
    assert {trace.xaxis or "x" for trace in figure.data} == {"x"}


def test_truth_is_dashed_at_its_value():
    annotation = Annotation(capacity_ml=520.0, container_mass_g=10.0, filling_mass_g=190.0)
    figure = known_when_figure(MOMENTS, end_s=2.0, annotation=annotation)
    lines = [(shape.y0, shape.y1, shape.yref) for shape in figure.layout.shapes]
    capacity, mass = (panel_of(figure, start) for start in ("Capacity", "Mass"))
    assert lines == [(520.0, 520.0, capacity), (10.0, 10.0, mass), (200.0, 200.0, mass)]
    assert {"annotated 520 mL", "annotated 10 g", "annotated 200 g"} <= set(texts(figure))


def test_an_empty_containers_mass_is_marked_once():
    annotation = Annotation(container_mass_g=10.0, filling_mass_g=0.0)
    assert len(known_when_figure(MOMENTS, end_s=2.0, annotation=annotation).layout.shapes) == 1


def test_the_fitted_frame_is_marked_through_all_panels():
    figure = known_when_figure(MOMENTS, end_s=2.0, best=(1.5, "frame 45"))
    [line] = figure.layout.shapes
    assert (line.x0, line.x1, line.yref, line.line.color) == (1.5, 1.5, "paper", BEST)
    assert texts(figure)[-1] == "frame 45"


@pytest.mark.parametrize("count", [1, 2])
def test_the_first_moments_can_be_drawn(count):
    figure = known_when_figure(MOMENTS[:count], end_s=2.0)
    assert figure.layout.height > 100
