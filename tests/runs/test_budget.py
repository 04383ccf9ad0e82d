import pytest

from corsmal.dataset import open_dataset
from corsmal.parameters import METHOD_VIEWS
from corsmal.quantities import GEOMETRY
from corsmal.runs.budget import (
    WAYS,
    budget_table,
    errors_pct,
    geometry_budget,
    score_against_error,
    true_best_frames,
)
from corsmal.stages import true_views
from corsmal.synthetic.writing.dataset import write_demo


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    root = tmp_path_factory.mktemp("budget") / "demo"
    write_demo(root, containers=(1,), recordings_per_container=1, size=(320, 180), workers=0)
    return open_dataset(root)


def test_detections_as_good_as_the_truth_lose_nothing(dataset):
    budget = geometry_budget(dataset, true_views)
    assert list(budget["way"]) == list(WAYS)
    assert (budget["status"] == "fitted").all()
    assert (budget[list(GEOMETRY)].nunique() == 1).all()
    assert (budget["capacity_ml"] < 60).all()


def test_recordings_without_detections_are_counted_and_in_no_mean(dataset):
    table = budget_table(geometry_budget(dataset, lambda _: {}))
    assert table.loc[("red cup", WAYS[0]), "failed"] == 0
    assert table.loc[("red cup", WAYS[1]), "failed"] == 1
    assert table.loc[("red cup", WAYS[1]), list(GEOMETRY)].isna().all()
    assert table.loc[("average", WAYS[0]), "height_mm"] == table.loc[("red cup", WAYS[0]), "height_mm"]


class Perfect:
    """A perfect detector: it knows by their order which frame of which view comes."""

    name = digest = "perfect"

    def __init__(self, views, frames):
        self._answers = iter([views[name][frame] for name in METHOD_VIEWS for frame in frames])

    def detect(self, frames):
        return [next(self._answers) for _ in frames]


def test_true_best_frames_are_detected_where_a_search_left_them_out(dataset):
    views = true_views(dataset["000000"])
    detector = Perfect(views, true_best_frames(views))
    budget = geometry_budget(dataset, lambda _: {}, detector=detector).set_index("way")
    assert budget.loc[WAYS[1], "status"] == "failed"
    assert budget.loc[WAYS[2], "capacity_ml"] == budget.loc[WAYS[0], "capacity_ml"]


def test_errors_by_hand(dataset):
    # the red cup holds 520 mL and is 98, 61 and 119 mm
    errors = errors_pct(dataset["000000"], [260.0, 98.0, None, 130.9])
    assert errors["capacity_ml"] == pytest.approx(50)
    assert errors["width_top_mm"] == 0
    assert errors["height_mm"] == pytest.approx(10)
    assert errors["width_bottom_mm"] != errors["width_bottom_mm"]


def test_scores_stand_beside_errors(dataset):
    table = score_against_error(dataset, step=4)
    assert len(table) > 3
    assert (table["score"] > 0).all()
    assert table["rank"].between(0, 1).all()
