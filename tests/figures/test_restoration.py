import base64
import itertools

import cv2
import numpy as np
import pytest

from corsmal.figures.restoration import mask_png, restoration_figure, restored_figure
from corsmal.figures.sensitivity import sensitivity_figure
from corsmal.figures.style import ADDED, CONTAINER, OUTSIDE, TRUTH, rgb
from corsmal.mass import Axis, RestoredMask

SIZE = (60, 80)
CROP = (10, 5, 50, 45)


def box(left, right):
    """Rows 15 to 34 and these columns, the last excluded."""
    mask = np.zeros(SIZE, dtype=bool)
    mask[15:35, left:right] = True
    return mask


SEEN, GAINED = box(30, 40), box(20, 30)
IMAGE = np.full((*SIZE, 3), (200, 30, 30), dtype=np.uint8)
INPUT = np.array([[0, 0.25], [0.5, 1]], dtype=np.float32)


UPRIGHT = Axis((29.5, 30.0), (0.0, -1.0))


def made(amodal=None, axis=UPRIGHT):
    restored = RestoredMask(SEEN | GAINED, CROP, axis, GAINED, "" if axis else "no base")
    return restoration_figure(IMAGE, SEEN, restored, network_input=INPUT, resize="stretch", amodal=amodal)


def titles(figure):
    return [tuple(note.text.replace("<b>", "").replace("</b>", "").split("<br>")) for note in figure.layout.annotations]


def picture(figure, panel):
    """One panel's picture, (H, W, 3), and how many of its pixels lie in one of the frame."""
    source = figure.layout.images[panel].source.removeprefix("data:image/jpeg;base64,")
    decoded = cv2.imdecode(np.frombuffer(base64.b64decode(source), np.uint8), cv2.IMREAD_COLOR)
    return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB), decoded.shape[1] // (CROP[2] - CROP[0])


def nearest(figure, panel, x, y, colours):
    """Which colour's hue a pixel of the frame has most of in a panel."""
    pixels, factor = picture(figure, panel)
    left, top = (x - CROP[0]) * factor, (y - CROP[1]) * factor
    colour = pixels[top : top + factor, left : left + factor].reshape(-1, 3).mean(axis=0)
    tinted = {name: colour - colour.mean() for name in colours}
    aims = {name: np.array(rgb(name)) - np.mean(rgb(name)) for name in colours}
    return min(colours, key=lambda name: float(np.linalg.norm(tinted[name] - 0.55 * aims[name])))


def test_panels_say_what_they_show_and_the_number_to_read_off():
    assert titles(made()) == [
        ("Seen", "200 px"),
        ("Restored", "200 px added (+100.0 %), axis upright"),
        ("Network input", "2 × 2 px, stretched"),
    ]


def test_the_restored_panel_stands_alone_where_there_is_little_room():
    restored = RestoredMask(SEEN | GAINED, CROP, UPRIGHT, GAINED)
    alone = restored_figure(IMAGE, SEEN, restored)
    assert titles(alone) == titles(made())[1:2]
    assert [trace.name for trace in alone.data] == ["seen", "added", "axis"]


@pytest.mark.parametrize(("x", "text"), [(0.1, "axis leans 5.7° right"), (-0.1, "axis leans 5.7° left")])
def test_the_axis_leans_to_the_side_of_its_upper_end(x, text):
    figure = made(axis=Axis((29.5, 30.0), (x, -np.sqrt(1 - x**2))))
    assert titles(figure)[1][1].endswith(text)


def test_iou_is_told_before_and_after():
    figure = made(amodal=box(25, 40))  # of 300 px: 200 seen, 100 of the added ones right, 100 too much
    assert titles(figure)[2] == ("Against the truth", "IoU 0.667 before, 0.750 after")


def test_every_kind_of_pixel_has_its_colour_against_the_truth():
    figure = made(amodal=box(25, 44))
    colours = (CONTAINER, ADDED, OUTSIDE, TRUTH)
    assert nearest(figure, 2, 35, 25, colours) == CONTAINER
    assert nearest(figure, 2, 27, 25, colours) == ADDED
    assert nearest(figure, 2, 22, 25, colours) == OUTSIDE
    assert nearest(figure, 2, 42, 25, colours) == TRUTH
    assert nearest(figure, 2, 12, 10, colours) == TRUTH  # the frame itself is grey


def test_the_legend_names_every_kind_once():
    named = [trace.name for trace in made(amodal=box(25, 44)).data if trace.showlegend]
    assert named == ["seen", "added", "axis", "still missing", "too much"]


def test_kinds_without_pixels_are_not_named():
    named = [trace.name for trace in made(amodal=SEEN | GAINED).data if trace.showlegend]
    assert named == ["seen", "added", "axis"]


def test_panels_of_the_frame_span_the_padded_box_in_its_pixels():
    layout = made(amodal=SEEN).layout
    for number in ("", "2", "3"):
        assert list(layout[f"xaxis{number}"].range) == [9.5, 49.5]
        assert list(layout[f"yaxis{number}"].range) == [44.5, 4.5]
    assert [(image.x, image.y, image.sizex, image.sizey) for image in layout.images] == [(9.5, 4.5, 40, 40)] * 3


def test_panels_lie_side_by_side_without_touching():
    layout = made(amodal=SEEN).layout
    domains = [layout[f"xaxis{number}"].domain for number in ("", "2", "3", "4")]
    assert domains[0][0] == 0
    assert domains[-1][1] == pytest.approx(1)
    assert all(left[1] < right[0] for left, right in itertools.pairwise(domains))


def test_the_axis_crosses_the_whole_box():
    axis = next(trace for trace in made().data if trace.name == "axis")
    assert axis.xaxis == "x2"
    np.testing.assert_allclose(axis.x, [29.5, 29.5])
    np.testing.assert_allclose(sorted(axis.y), [5, 45])


def test_without_an_axis_none_is_drawn_and_the_panel_says_so():
    figure = made(axis=None)
    assert "axis" not in [trace.name for trace in figure.data]
    assert titles(figure)[1] == ("Restored", "no axis: nothing added")


def test_the_networks_input_is_shown_pixel_by_pixel():
    heatmap = next(trace for trace in made().data if trace.type == "heatmap")
    np.testing.assert_array_equal(heatmap.z, [[0, 25], [50, 100]])
    assert (heatmap.zmin, heatmap.zmax, heatmap.zsmooth) == (0, 100, None)


@pytest.mark.parametrize(("image", "grey"), [(SEEN, 255 * SEEN), (INPUT, [[0, 64], [128, 255]])])
def test_png_holds_the_mask(image, grey):
    read = cv2.imdecode(np.frombuffer(mask_png(image), np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(read, grey)


CHANGES = np.array([-0.3, 0.0, 0.3])
MASSES = {"h": np.array([70.0, 100, 130]), "w_t": np.array([110.0, 100, 90])}
VALUES = {"h": 120.0, "w_t": 80.0}


def test_a_line_for_each_number_says_what_ten_per_cent_do():
    lines = sensitivity_figure(CHANGES, MASSES, values=VALUES).data[:2]
    assert [line.name for line in lines] == ["h (+10 %: +10.0 g)", "w_t (+10 %: -3.3 g)"]
    np.testing.assert_allclose(lines[0].x, [-30, 0, 30])
    np.testing.assert_allclose(lines[0].y, [70, 100, 130])
    np.testing.assert_allclose(lines[0].customdata, [84, 120, 156])


def test_the_point_of_now_lies_where_the_lines_meet():
    now = sensitivity_figure(CHANGES, MASSES, values=VALUES).data[2]
    assert (list(now.x), list(now.y)) == ([0], [100])


def test_the_true_mass_is_a_line_across():
    line = sensitivity_figure(CHANGES, MASSES, values=VALUES, true_g=134.0).data[-1]
    assert line.name == "true mass: 134 g"
    np.testing.assert_allclose(np.column_stack([line.x, line.y]), [(-30, 134), (30, 134)])
    assert len(sensitivity_figure(CHANGES, MASSES, values=VALUES).data) == 3
