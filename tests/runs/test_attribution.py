from dataclasses import replace

import pytest

from corsmal.detection import ViewDetections
from corsmal.errors import NotFoundError
from corsmal.estimation import estimate, fit_frame, training_means
from corsmal.parameters import PAIRS
from corsmal.quantities import GEOMETRY
from corsmal.runs.attribution import STAGES, blame_rows, load_blame
from corsmal.runs.run import record_run
from corsmal.selection import select_best_frame
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors
from corsmal.store import Store
from tests.fakes import FakeFilling, FakeMass

IDS = ("000000", "000001", "000002")
WITHOUT_DETECTIONS = 2


@pytest.fixture(scope="module")
def shared_store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="module")
def predictors(dataset):
    return Predictors(means=training_means(dataset.table), filling=FakeFilling(2, 1), mass=FakeMass(20.0))


@pytest.fixture(scope="module")
def run(dataset, predictors, shared_store):
    return record_run("first", dataset, IDS, predictors, store=shared_store)


@pytest.fixture(scope="module")
def true_views(dataset, shared_store):
    """Every mask but those of the frame that scores best, so that the truth chooses another one."""

    def views(recording):
        if recording.id == IDS[WITHOUT_DETECTIONS]:
            recording = dataset["000000"]
        found = load_detections(recording, store=shared_store).views
        best = select_best_frame(found, pair=PAIRS[0]).frame
        return {
            name: replace(view, by_frame={frame: view[frame] for frame in view if frame != best})
            for name, view in found.items()
        }

    return views


@pytest.fixture(scope="module")
def replaced(run, dataset, predictors, shared_store, true_views):
    return blame_rows(run, dataset, predictors, store=shared_store, true_views=true_views)


def test_every_stage_has_a_row_for_every_recording(replaced):
    assert tuple(replaced) == STAGES
    for rows in replaced.values():
        assert [row["recording_id"] for row in rows] == list(IDS)


def test_true_masks_are_estimated_like_any(replaced, dataset, true_views, predictors):
    for name, row in zip(IDS, replaced["masks"], strict=True):
        recording = dataset[name]
        result = estimate(recording, detections=true_views(recording), means=predictors.means)
        for quantity in GEOMETRY:
            assert row[quantity] == getattr(result, quantity)
    assert replaced["masks"][WITHOUT_DETECTIONS]["status"] == "fitted"


def test_the_true_best_frame_is_fitted_with_the_detected_masks(replaced, run, dataset, true_views, shared_store):
    recording = dataset["000000"]
    true = select_best_frame(true_views(recording), pair=PAIRS[0])
    assert true.frame is not None
    assert true.frame != run.rows[0]["best_frame"]
    found = load_detections(recording, store=shared_store).views
    by_hand = fit_frame(recording, found, pair=PAIRS[0], frame=true.frame, centre_rule=true.centre_rule)
    row = replaced["best frame"][0]
    assert row["best_frame"] == true.frame
    assert row["capacity_ml"] == by_hand.dimensions.capacity_ml


def test_a_true_frame_that_no_detector_saw_is_of_no_use(replaced, predictors):
    row = replaced["best frame"][WITHOUT_DETECTIONS]
    assert row["status"] == "fallback: training mean"
    assert row["capacity_ml"] == predictors.means["capacity_ml"]


def test_true_dimensions_are_annotated_and_the_mass_is_told_from_them(run, dataset, predictors, store):
    mass = FakeMass(33.0)
    rows = blame_rows(run, dataset, replace(predictors, mass=mass), store=store)["dimensions"]
    for name, row in zip(IDS, rows, strict=True):
        for quantity in GEOMETRY:
            assert row[quantity] == getattr(dataset[name].annotation, quantity)
    assert mass.inputs["width_top_mm"] == dataset["000001"].annotation.width_top_mm  # the last that was fitted
    assert rows[0]["container_mass_g"] == 33.0
    assert rows[WITHOUT_DETECTIONS]["container_mass_g"] == predictors.means["container_mass_g"]


def test_what_was_heard_stays_and_masses_follow(replaced, run):
    for rows in replaced.values():
        for row, before in zip(rows, run.rows, strict=True):
            for name in ("filling_type", "filling_level", "type_p2"):
                assert row.get(name) == before.get(name)
    row = replaced["dimensions"][0]
    assert row["filling_mass_g"] == pytest.approx(0.5 * row["capacity_ml"] * 0.82)
    assert row["object_mass_g"] == pytest.approx(row["filling_mass_g"] + 20.0)


def test_without_true_masks_dimensions_alone_are_replaced(run, dataset, predictors, store):
    assert list(blame_rows(run, dataset, predictors, store=store)) == ["dimensions"]


def test_a_recording_without_truth_is_a_failed_row_with_the_reason(run, dataset, predictors, store):
    def nothing(recording) -> dict[str, ViewDetections]:
        raise NotFoundError(f"no truth of {recording.id}")

    rows = blame_rows(run, dataset, predictors, store=store, true_views=nothing)["masks"]
    assert [row["status"] for row in rows] == ["failed"] * 3
    assert rows[1]["notes"] == "no truth of 000001"


def test_the_result_is_kept_until_the_run_changes(replaced, run, shared_store):
    assert load_blame(run, store=shared_store) == replaced
    assert load_blame(replace(run, rows=run.rows[:1]), store=shared_store) is None


def test_stopped_work_keeps_nothing(run, dataset, predictors, store):
    steps = []
    rows = blame_rows(
        run,
        dataset,
        predictors,
        store=store,
        progress=lambda done, total: steps.append((done, total)),
        cancelled=lambda: len(steps) > 1,
    )
    assert steps == [(0, 3), (1, 3)]
    assert len(rows["dimensions"]) == 1
    assert load_blame(run, store=store) is None
