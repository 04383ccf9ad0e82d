import json
from pathlib import Path

import numpy as np
import pytest

from corsmal.errors import ArgumentError, NotFoundError
from corsmal.synthetic.scene.containers import ANNOTATED_IDS, CONTAINER_IDS, demo_container
from corsmal.synthetic.scene.profiles import Profile, cup, solved


def test_a_cylinders_volume_is_known():
    assert Profile([0, 100], [30, 30]).volume_ml == pytest.approx(np.pi * 9 * 10)


def test_a_cones_volume_is_a_third_of_the_cylinders():
    assert Profile([0, 100], [0, 30]).volume_ml == pytest.approx(np.pi * 9 * 10 / 3)


def test_half_of_a_cylinder_stands_half_as_high():
    assert Profile([10, 110], [30, 30]).height_holding(np.pi * 9 * 5) == pytest.approx(60, abs=1e-3)


@pytest.mark.parametrize("radii", [[1.0], [1.0, -1.0], [[1.0, 2.0]]])
def test_a_profile_that_cannot_be_is_refused(radii):
    with pytest.raises(ArgumentError, match=r"heights_mm"):
        Profile([0.0, 1.0], radii)


def test_a_capacity_that_no_member_of_the_family_has_is_refused():
    def shape(power):
        return cup(power, top_mm=80, bottom_mm=60, height_mm=100, wall_mm=1, floor_mm=2)

    with pytest.raises(ArgumentError, match=r"capacity_ml must lie in .* got 5000"):
        solved(shape, capacity_ml=5000, limits=(0.5, 2))


@pytest.mark.parametrize("container_id", CONTAINER_IDS)
def test_sizes_and_capacity_are_those_of_the_profile(container_id):
    container = demo_container(container_id)
    if container.outer is None:
        volume = container.width_top_mm * container.depth_mm * container.height_mm / 1000
        assert container.capacity_ml == pytest.approx(volume, abs=1e-3)
        return
    assert container.inner.volume_ml == pytest.approx(container.capacity_ml, rel=0.01)
    assert 2 * container.outer.radii_mm[0] == pytest.approx(container.width_bottom_mm)
    assert 2 * container.outer.radii_mm[-1] == pytest.approx(container.width_top_mm)
    assert container.outer.heights_mm[[0, -1]].tolist() == [0, container.height_mm]


@pytest.mark.parametrize("container_id", [i for i in CONTAINER_IDS if demo_container(i).is_round])
def test_the_cavity_lies_inside_the_wall(container_id):
    container = demo_container(container_id)
    heights = np.linspace(container.inner.heights_mm[0], container.height_mm, 50)
    gaps = [container.outer.radius_at(height) - container.inner.radius_at(height) for height in heights]
    assert container.inner.heights_mm[0] > 0
    assert min(gaps) > 0.3


def test_the_first_nine_are_the_annotated_ones(real_dataset_root: Path):
    rows = json.loads((real_dataset_root / "ccm_train_annotation.json").read_text(encoding="utf-8"))["annotations"]
    for container_id in ANNOTATED_IDS:
        container = demo_container(container_id)
        row = next(row for row in rows if row["container id"] == container_id)
        assert container.capacity_ml == pytest.approx(row["container capacity"], rel=0.01)
        for attribute, key in (
            ("width_top_mm", "width at the top"),
            ("width_bottom_mm", "width at the bottom"),
            ("height_mm", "height"),
            ("depth_mm", "depth"),
            ("mass_g", "container mass"),
        ):
            assert getattr(container, attribute) == row[key]


def test_a_container_that_is_not_there_is_named():
    with pytest.raises(NotFoundError, match=r"no demo container 16; there are 1 to 15"):
        demo_container(16)
