import json

import pytest

from corsmal.dataset import Recording, open_dataset
from corsmal.demo.opening import open_demo
from corsmal.errors import FileError
from corsmal.stages.known_profiles import known_profile
from corsmal.store import Store


def test_a_real_recordings_profile_is_the_annotated_frustum(tiny_dataset_root):
    found = known_profile(open_dataset(tiny_dataset_root)["000000"], 3)
    assert found is not None
    assert found.source == "annotated size"
    assert list(found.radii_mm) == [30.5, 49]
    assert found.base_mm is None


def test_without_annotated_sizes_nothing_is_known():
    assert known_profile(Recording("000618"), 0) is None


def test_a_synthetic_recordings_profile_is_its_outer_wall_at_the_frames_base(tmp_path):
    path = tmp_path / "000000.json"
    wall = {"outer_heights_mm": [0, 10, 20], "outer_radii_mm": [30, 5, 40]}
    path.write_text(json.dumps({"profile": wall, "base_m": [[0, 0, 0.1], [0, 0, 0.25]]}))
    found = known_profile(Recording("000000", truth_path=path), 1)
    assert found is not None
    assert (list(found.radii_mm), found.source, found.base_mm) == ([30, 5, 40], "true profile", 250)
    late = known_profile(Recording("000000", truth_path=path), 2)
    assert late is not None
    assert late.base_mm is None


@pytest.mark.parametrize("text", ["{", "{}", '{"profile": {"outer_heights_mm": [0]}, "base_m": []}'])
def test_a_broken_truth_is_named(tmp_path, text):
    path = tmp_path / "000000.json"
    path.write_text(text)
    with pytest.raises(FileError, match=r"000000\.json: is broken"):
        known_profile(Recording("000000", truth_path=path), 0)


def test_a_box_of_the_demo_has_its_annotated_size_and_a_cup_its_wall(tmp_path):
    dataset = open_dataset(open_demo(store=Store(tmp_path)))
    assert {known_profile(dataset[name], 0).source for name in ("000000", "000005")} == {"true profile"}
    assert known_profile(dataset["000013"], 0).source == "annotated size"
