"""Fits that cannot be true are no estimates; the recording is a generated one with true masks."""

import pickle
import shutil

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.estimation import estimate, plausibility
from corsmal.parameters import ShapeParameters

MEANS = {"capacity_ml": 600.0, "width_top_mm": 90.0, "width_bottom_mm": 70.0, "height_mm": 120.0}


def changed(tiny_dataset_root, folder, views, change):
    """The first tiny recording with the translations of some views changed."""
    root = folder / "set"
    for part in ("view1", "view2", "view3"):
        shutil.copytree(tiny_dataset_root / part, root / part)
    for view in views:
        path = root / view / "calib" / "000000.pickle"
        content = pickle.loads(path.read_bytes(), encoding="latin1")
        content[1]["rgb"]["tvec"] = change(content[1]["rgb"]["tvec"])
        path.write_bytes(pickle.dumps(content, protocol=2))
    return open_dataset(root)["000000"]


ALL = ("view1", "view2", "view3")


@pytest.mark.parametrize(("factor", "unit"), [(1000, "mm"), (100, "cm")])
def test_cameras_in_another_unit_give_the_same_estimate_which_says_so(tiny_dataset_root, tmp_path, factor, unit):
    expected = estimate(open_dataset(tiny_dataset_root)["000000"])
    found = estimate(changed(tiny_dataset_root, tmp_path, ALL, lambda tvec: tvec * factor))
    assert found.status == expected.status == "fitted"
    assert found.capacity_ml == pytest.approx(expected.capacity_ml, rel=1e-6)
    assert found.flags == ("unit-assumed",)
    assert sum(f"taken for {unit}" in note for note in found.notes) == 3
    assert (expected.flags, expected.notes) == ((), ())
    assert found.row()["flags"] == "unit-assumed"


@pytest.mark.parametrize(
    ("views", "change", "reason"),
    [
        (ALL, lambda tvec: tvec * 5, "m from the container, expected 0.2 to 5 m (is its 'tvec' in metres?)"),
        (ALL, lambda tvec: tvec * 1e6, "m from the container, expected 0.2 to 5 m (is its 'tvec' in metres?)"),
        (ALL, lambda tvec: tvec * 0.1, "m from the container, expected 0.2 to 5 m (is its 'tvec' in metres?)"),
        (("view3",), lambda tvec: tvec + np.array([[0.0], [0.2], [0.0]]), "the views do not meet"),
    ],
)
def test_a_fit_that_cannot_be_true_is_none(tiny_dataset_root, tmp_path, views, change, reason):
    found = estimate(changed(tiny_dataset_root, tmp_path, views, change), means=MEANS)
    assert (found.status, found.capacity_ml) == ("fallback: training mean", 600.0)
    assert "implausible" in found.flags
    [said, *_] = [note for note in found.notes if "not plausible: " in note]
    assert reason in said


@pytest.mark.parametrize("name", ["CAPACITY_ML", "SIZE_MM", "MISS_MAX"])
def test_the_limits_hold_for_size_and_for_the_distance_of_rays(tiny_dataset_root, monkeypatch, name):
    limits = {"CAPACITY_ML": (10.0, 100.0), "SIZE_MM": (300.0, 400.0), "MISS_MAX": -1.0}
    monkeypatch.setattr(plausibility, name, limits[name])
    found = estimate(open_dataset(tiny_dataset_root)["000000"], shape=ShapeParameters.paper())
    assert found.status == "failed"
    words = {"CAPACITY_ML": "a capacity of", "SIZE_MM": "a height of", "MISS_MAX": "the views do not meet"}
    assert all(words[name] in note for note in found.notes)
    assert found.flags == ("implausible",)
