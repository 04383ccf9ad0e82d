from dataclasses import replace

import pytest

from corsmal.dataset import open_dataset
from corsmal.parameters import ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs.ablation import ablation_errors, ablation_table, ablations
from corsmal.stages import true_views
from corsmal.synthetic.writing.dataset import write_demo


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    root = tmp_path_factory.mktemp("ablation") / "demo"
    write_demo(root, containers=(1,), recordings_per_container=1, size=(320, 180), workers=0)
    return open_dataset(root)


@pytest.fixture(scope="module")
def errors(dataset):
    few = replace(ShapeParameters.tuned(), frames=6)
    presets = {"paper": ShapeParameters.paper(), "tuned": few}
    return ablation_errors(dataset, true_views, presets=presets)


def test_every_part_is_left_out_once():
    tuned = ShapeParameters.tuned()
    for name, parameters in ablations().items():
        changed = [key for key, value in vars(parameters).items() if value != getattr(tuned, key)]
        assert len(changed) == (1 if name.startswith("tuned,") else len(changed))
        assert (parameters == tuned) == (name == "tuned")


def test_tuned_is_nearer_to_the_red_cup_than_the_paper(errors):
    mean = errors[errors["masks"] == "true"].set_index("preset")[list(GEOMETRY)].mean(axis=1)
    assert mean["tuned"] < mean["paper"] / 2
    assert mean["tuned"] < 6


def test_detections_as_good_as_the_truth_give_the_same(errors):
    true, detected = (errors[errors["masks"] == masks][list(GEOMETRY)].to_numpy() for masks in ("true", "detected"))
    assert (true == detected).all()


def test_the_table_counts_failures_and_what_is_inside(dataset):
    presets = {"tuned": replace(ShapeParameters.tuned(), frames=6)}
    table = ablation_table(ablation_errors(dataset, lambda _: {}, presets=presets))
    assert table.loc[("detected", "tuned", "all"), "failed"] == 1
    assert table.loc[("true", "tuned", "seen"), "failed"] == 0
    assert table.loc[("true", "tuned", "all"), "height_mm inside"] in {0, 100}
