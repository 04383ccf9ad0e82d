from dataclasses import fields, replace

import pytest

from corsmal.parameters import HeightRange, ShapeParameters
from corsmal.ui.choice import Choice
from corsmal.ui.url import FIELDS, from_params, to_params

CHOICES = [
    Choice(),
    Choice("000618"),
    Choice("000618", ("view3", "view2"), 0, ShapeParameters.lode()),
    Choice("a-b_c", None, 76, ShapeParameters(circumferences=200, max_difference_mm=1.35)),
    Choice(
        "1", None, None, replace(ShapeParameters.lode(), points=31, height_range=HeightRange("centroid", -150, 150))
    ),
    Choice("000618", None, 3, ShapeParameters.tuned()),
    Choice("000618", ("view1", "view2"), 3, ShapeParameters.released(), selection="paper"),
    Choice("1", shape=replace(ShapeParameters.released(), pairs=(("view2", "view3"),), height_rule="ends")),
    Choice("1", shape=replace(ShapeParameters.tuned(), tilt_deg=0.0, wall_mm=1.5, boxes=False, all_views=False)),
    Choice("000618", None, 7, crop_s=(1.2, 7.45), channel=0),
    Choice("000618", crop_s=(0.0, 0.25), channel=7),
    Choice("000618", estimate="paper"),
    Choice(
        "1", None, None, ShapeParameters(fit_rule="all", width_rule="widest", radius_min_mm=0.5, radius_max_mm=99.5)
    ),
    Choice("000618", dataset="train set-0a1b2c3d", compared="nothing", scope="cameras", shows_errors=True),
    Choice("1", has_axes=True, camera=(1.25, -0.5, 0.001, 0.0, 0.0, -99.999), axis="whole", padding_px=0),
    Choice("1", container=("red cup", "tea box"), filling=("rice",), level=("half",), scenario=("held",), lacks="all"),
    Choice("1", view="reproduction", run="a run & more", section="Errors", protocol="paper", metric="mass_mape"),
    Choice("1", classes="filling_level", beside="counts", against="b", within_percent=12.0, collection="μ-group"),
    Choice("1", sure_percent=70.0),
    Choice("1", numbers=(("height_mm", 120.5), ("capacity_ml", None), ("mm_per_px", 0.25))),
    Choice("1", rows=("red cup",), only_failed=True, without=("any", "implausible")),
    Choice("1", match="index"),
    Choice("1", masks="by-hand", edited="view1"),
    Choice("1", offsets_s=(("view1", 0.4), ("view3", -0.0333))),
]


@pytest.mark.parametrize("choice", CHOICES)
def test_an_address_opens_what_it_was_written_for(choice):
    assert from_params(to_params(choice)) == (choice, ())


def test_every_field_of_a_choice_is_in_the_address():
    assert {field.name for field in fields(Choice)} == {"shape"} | {name for name, _, _ in FIELDS.values()}


def test_a_cameras_place_is_rounded_once():
    choice, problems = from_params({"camera": "0.1_-0.0_1.23456_0_2_3"})
    assert choice.camera == (0.1, 0.0, 1.235, 0.0, 2.0, 3.0)
    assert to_params(choice)["camera"] == "0.1_0_1.235_0_2_3"
    assert not problems


def test_defaults_stay_out_of_the_address():
    assert to_params(Choice("000618")) == {"recording": "000618"}
    assert to_params(Choice("1", shape=ShapeParameters.lode())) == {"recording": "1", "preset": "lode"}
    assert to_params(Choice("1", shape=ShapeParameters.tuned())) == {"recording": "1", "preset": "tuned"}
    assert to_params(Choice("1", shape=ShapeParameters.released())) == {"recording": "1", "preset": "released"}
    assert to_params(Choice("1", shape=ShapeParameters(pairs=(("view1", "view2"), ("view3", "view2"))))) == {
        "recording": "1",
        "pairs": "view1-view2~view3-view2",
    }
    assert to_params(Choice("1", crop_s=(1.2, 7.45), channel=2)) == {"recording": "1", "crop": "1.20-7.45", "ch": "3"}
    assert to_params(Choice("1", shape=ShapeParameters(circumferences=146))) == {"recording": "1", "L": "146"}


@pytest.mark.parametrize(
    ("params", "word"),
    [
        ({"frame": "-1"}, "frame"),
        ({"frame": "1e3x"}, "frame"),
        ({"frame": "nan"}, "frame"),
        ({"frame": "2.5"}, "whole"),
        ({"pair": "view1-view4"}, "view1, view2, view3"),
        ({"pair": "view1-view1"}, "view1, view2, view3"),
        ({"pairs": "view1-view2~view2-view1"}, "differ"),
        ({"pairs": ""}, "view1, view2, view3"),
        ({"selection": "best"}, "paper, released"),
        ({"pixels": "cut"}, "rounded, truncated"),
        ({"preset": "best"}, "paper, released, lode"),
        ({"estimate": "best"}, "paper, released, lode"),
        ({"L": "1000000000"}, "10–500"),
        ({"L": "12.5"}, "whole"),
        ({"dmax": "inf"}, "finite"),
        ({"fit": "most"}, "any"),
        ({"width": "<script>"}, "ends"),
        ({"z": "masks"}, "masks:LOW:HIGH"),
        ({"z": "moon:-1:1"}, "masks"),
        ({"z": "world:10:-10"}, "low_mm"),
        ({"z": "world:-1e9:1e9"}, "2000"),
        ({"boxes": "yes"}, "True or False"),
        ({"tilt": "90"}, "0–15"),
        ({"crop": "1.2"}, "finite"),
        ({"match": "sound"}, "index"),
        ({"offset": "view9:1"}, "view1"),
        ({"offset": "view1:nan"}, "finite"),
        ({"offset": "view1"}, "finite"),
        ({"offset": "view1:1~view1:2"}, "each view once"),
        ({"without": "loud"}, "any, detections-interpreted"),
        ({"crop": "2-1"}, "START-END"),
        ({"crop": "-1-2"}, "finite"),
        ({"crop": "0-inf"}, "finite"),
        ({"crop": "1.001-1.002"}, "START-END"),
        ({"ch": "0"}, "1–8"),
        ({"ch": "9"}, "1–8"),
        ({"ch": "mean"}, "whole"),
        ({"colour": "red"}, "colour"),
        ({"dataset": "train"}, "fingerprint"),
        ({"dataset": "../../etc/passwd"}, "fingerprint"),
        ({"dataset": "a\nb-0a1b2c3d"}, "fingerprint"),
        ({"compare": "best"}, "paper, released, lode"),
        ({"scope": "room"}, "container, cameras"),
        ({"errors": "1"}, "True or False"),
        ({"camera": "1_2_3"}, "six numbers"),
        ({"camera": "1_2_3_4_5_nan"}, "finite"),
        ({"camera": "1_2_3_4_5_1e9"}, "six numbers"),
        ({"axis": "left"}, "base, whole"),
        ({"padding": "81"}, "0–80"),
        ({"typed": "h"}, "w_t, w_b, h, s, C"),
        ({"typed": "x:1"}, "w_t, w_b, h, s, C"),
        ({"typed": "h:0"}, "0.01–20000"),
        ({"files": "some"}, "all, complete"),
        ({"container": "red cup~"}, "printable"),
        ({"run": " "}, "printable"),
        ({"run": "x" * 81}, "printable"),
        ({"section": "\x07"}, "printable"),
        ({"within": "0"}, "1–100"),
        ({"sure": "101"}, "0–100"),
    ],
)
def test_what_cannot_be_read_is_reported_and_left_at_its_default(params, word):
    choice, problems = from_params({"recording": "000618", **params})
    assert choice == Choice("000618")
    assert len(problems) == 1
    assert word in problems[0]


def test_parameters_that_exclude_each_other_are_reported():
    choice, problems = from_params({"rmax": "10", "rmin": "9.5"})
    assert choice.shape.radius_max_mm == 10
    assert not problems
    _, problems = from_params({"preset": "lode", "rmax": "x", "L": "20"})
    assert len(problems) == 1
