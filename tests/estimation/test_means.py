from dataclasses import asdict, replace
from types import SimpleNamespace

import pytest

from corsmal.dataset import Annotation, Dataset, Recording, open_dataset
from corsmal.errors import ArgumentError
from corsmal.estimation.means import TrainingMeans
from corsmal.quantities import MEASURED

CUP = Annotation(
    container_id=1, capacity_ml=500.0, width_top_mm=90.0, width_bottom_mm=60.0, height_mm=120.0, container_mass_g=10.0
)
GLASS = replace(CUP, container_id=4, capacity_ml=300.0, height_mm=100.0, container_mass_g=None)
BOX = replace(CUP, container_id=7, capacity_ml=3000.0, height_mm=300.0, container_mass_g=60.0)


def a_dataset(tmp_path, *annotations):
    recordings = {f"{index:06d}": Recording(f"{index:06d}", annotation=each) for index, each in enumerate(annotations)}
    return Dataset(tmp_path, recordings)


def test_means_are_over_recordings(tmp_path):
    means = TrainingMeans.of(a_dataset(tmp_path, CUP, CUP, GLASS)).for_container(None)
    assert means["capacity_ml"] == pytest.approx((500 + 500 + 300) / 3)
    assert means["height_mm"] == pytest.approx((120 + 120 + 100) / 3)
    assert means["container_mass_g"] == 10.0


def test_a_container_is_judged_by_the_means_of_the_others(tmp_path):
    means = TrainingMeans.of(a_dataset(tmp_path, CUP, CUP, GLASS, BOX))
    assert means.for_container(CUP)["capacity_ml"] == pytest.approx((300 + 3000) / 2)
    assert means.for_container(GLASS)["capacity_ml"] == pytest.approx((500 + 500 + 3000) / 3)


def test_another_container_of_the_same_number_leaves_all(tmp_path):
    means = TrainingMeans.of(a_dataset(tmp_path, CUP, GLASS))
    assert means.for_container(replace(CUP, capacity_ml=501.0)) == means.for_container(None)


def test_a_set_of_one_container_has_no_means_for_itself(tmp_path):
    assert TrainingMeans.of(a_dataset(tmp_path, CUP)).for_container(CUP) == {}


def test_what_is_annotated_in_part_does_not_count(tmp_path):
    means = TrainingMeans.of(a_dataset(tmp_path, CUP, replace(GLASS, height_mm=None)))
    assert means.for_container(None)["capacity_ml"] == 500.0


def test_a_set_without_truth_has_no_means(tmp_path):
    with pytest.raises(ArgumentError, match="are not known"):
        TrainingMeans.of(a_dataset(tmp_path, Annotation(container_id=1), None))


def test_means_survive_json(tmp_path):
    means = TrainingMeans.of(a_dataset(tmp_path, CUP, GLASS))
    assert TrainingMeans.from_json(asdict(means)) == means


@pytest.mark.parametrize("content", [{}, {"source": "a", "containers": [{"container_id": 1}]}, SimpleNamespace()])
def test_other_json_is_refused(content):
    with pytest.raises(ArgumentError, match="means of a training set"):
        TrainingMeans.from_json(content)


def test_the_training_annotation_gives_the_published_means(real_dataset_root):
    means = TrainingMeans.of(open_dataset(real_dataset_root)).for_container(None)
    assert [means[name] for name in MEASURED] == pytest.approx([639.69, 91.54, 75.58, 130.28, 39.91], abs=0.005)
