from dataclasses import replace

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.dataset import open_dataset
from corsmal.engines.tasks import open_predictors
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.estimation import choose_frames, estimate, fit_frame
from corsmal.evaluation import ablation_table, attribution_table, estimates_table
from corsmal.parameters import PAIRS, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs import attribution, make_run
from corsmal.runs.attribution import (
    STAGES,
    ablate,
    ablation_presets,
    attribute_run,
    known_stages,
    load_attribution,
)
from corsmal.selection import select_best_frame
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from corsmal.synthetic.writing.dataset import write_demo
from tests.fakes import FakeMass

IDS = ("000000", "000001", "000002")
WITHOUT_DETECTIONS = 2
FEW = replace(ShapeParameters.tuned(), frames=6)


@pytest.fixture(scope="module")
def shared_store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("store"))


@pytest.fixture(scope="module")
def run(dataset, settings, shared_store):
    return make_run("first", dataset, settings, store=shared_store)


def true_views(recording, dataset, store):
    """Every mask but those of the frame that scores best, so that the truth chooses another one."""
    if recording.id == IDS[WITHOUT_DETECTIONS]:
        recording = dataset["000000"]
    found = load_detections(recording, store=store).views
    best = select_best_frame(found, pair=PAIRS[0]).frame
    return {
        name: replace(view, by_frame={frame: view[frame] for frame in view if frame != best})
        for name, view in found.items()
    }


@pytest.fixture
def known(dataset, store, monkeypatch):
    """The true masks of all recordings are known."""
    monkeypatch.setattr(attribution, "_true", lambda recording, _: true_views(recording, dataset, store))
    monkeypatch.setattr(attribution, "known_stages", lambda *_, **__: STAGES)
    open_predictors.cache_clear()


@pytest.fixture
def replaced(run, dataset, store, request):
    request.getfixturevalue("known")
    return attribute_run(run, dataset, store=store)


def test_every_stage_has_a_row_for_every_recording(replaced):
    assert tuple(replaced) == STAGES
    for rows in replaced.values():
        assert [row["recording_id"] for row in rows] == list(IDS)


def test_true_masks_are_estimated_like_any(replaced, dataset, store):
    for name, row in zip(IDS, replaced["masks"], strict=True):
        recording = dataset[name]
        result = estimate(recording, detections=true_views(recording, dataset, store))
        for quantity in GEOMETRY:
            assert row[quantity] == getattr(result, quantity)
    assert replaced["masks"][WITHOUT_DETECTIONS]["status"] == "fitted"


def test_the_true_best_frame_is_fitted_with_the_detected_masks(replaced, run, dataset, store):
    recording = dataset["000000"]
    true = select_best_frame(true_views(recording, dataset, store), pair=PAIRS[0])
    assert true.frame is not None
    assert true.frame != run.rows[0]["best_frame"]
    found = load_detections(recording, store=store).views
    by_hand = fit_frame(recording, found, pair=PAIRS[0], frame=true.frame, centre_rule=true.centre_rule)
    row = replaced["best frame"][0]
    assert row["best_frame"] == true.frame
    assert row["capacity_ml"] == by_hand.dimensions.capacity_ml


@pytest.mark.usefixtures("known")
def test_several_true_frames_are_fitted_where_the_preset_fits_several(run, dataset, store, monkeypatch):
    several = replace(run, settings=replace(run.settings, shape=replace(FEW, frames=3)))
    recording = dataset["000000"]
    true = true_views(recording, dataset, store)
    _, frames = choose_frames(true, pair=PAIRS[0], shape=several.settings.shape)
    fitted = []

    def counting(recording, *, detections, **options):
        fitted.append(sorted(set(detections["view3"]) & set(detections["view1"])))
        return estimate(recording, detections=detections, **options)

    monkeypatch.setattr(attribution, "estimate", counting)
    monkeypatch.setattr(attribution, "known_stages", lambda *_, **__: ("best frame",))
    attribute_run(replace(several, rows=run.rows[:1]), dataset, store=store)
    assert fitted == [frames]
    assert len(frames) == 3


def test_a_true_frame_that_no_detector_saw_is_of_no_use(replaced, dataset, settings):
    row = replaced["best frame"][WITHOUT_DETECTIONS]
    assert row["status"] == "fallback: training mean"
    means = settings.means.for_container(dataset["000002"].annotation)
    assert row["capacity_ml"] == means["capacity_ml"]


def test_true_dimensions_are_annotated_and_the_mass_network_is_given_them(
    run, dataset, store, monkeypatch, fake_networks
):
    mass = FakeMass(20.0)
    monkeypatch.setitem(fake_networks, "mass", mass)
    open_predictors.cache_clear()
    rows = attribute_run(run, dataset, store=store)["dimensions"]
    for name, row in zip(IDS, rows, strict=True):
        for quantity in GEOMETRY:
            assert row[quantity] == getattr(dataset[name].annotation, quantity)
    assert mass.inputs["width_top_mm"] == dataset["000001"].annotation.width_top_mm  # the last that was fitted
    assert rows[0]["container_mass_g"] == 20.0
    means = run.settings.means.for_container(dataset["000002"].annotation)
    assert rows[WITHOUT_DETECTIONS]["container_mass_g"] == means["container_mass_g"]


def test_without_true_masks_only_dimensions_are_replaced(run, dataset, store):
    assert list(attribute_run(run, dataset, store=store)) == ["dimensions"]


def test_masks_by_hand_are_the_true_ones_of_their_recording(run, dataset, store):
    recording = dataset["000000"]
    assert list(attribute_run(run, dataset, store=store)) == ["dimensions"]
    found = load_detections(recording, store=store).views
    for name in PAIRS[0]:
        mask = found[name][5].mask(0)
        mask[:, : np.flatnonzero(mask.any(axis=0))[0] + 8] = False
        history = MaskHistory(recording.id, recording.views[name], store=store)
        history.keep(HandMask.of(mask, frame=5), after=0)
    assert load_attribution(run, dataset, store=store) is None  # the truth is another one now
    rows = attribute_run(run, dataset, store=store)
    assert {stage: len(found) for stage, found in rows.items()} == {"masks": 1, "best frame": 1, "dimensions": 3}
    assert (rows["masks"][0]["best_frame"], rows["best frame"][0]["best_frame"]) == (5, 5)
    assert rows["masks"][0]["width_top_mm"] < rows["best frame"][0]["width_top_mm"]
    table = attribution_table(
        run.table,
        {stage: estimates_table(each) for stage, each in rows.items()},
        dataset.table,
        rng=np.random.default_rng(0),
    )
    assert set(table[table["stage"] == "masks"]["recordings"]) == {1}


@pytest.mark.usefixtures("known")
def test_a_recording_without_truth_is_a_failed_row_with_the_reason(run, dataset, store, monkeypatch):
    def nothing(recording, _):
        raise NotFoundError(f"no truth of {recording.id}")

    monkeypatch.setattr(attribution, "_true", nothing)
    rows = attribute_run(run, dataset, store=store)["masks"]
    assert [row["status"] for row in rows] == ["failed"] * 3
    assert rows[1]["notes"] == "no truth of 000001"


def test_the_result_is_kept_until_the_run_changes(replaced, run, dataset, store):
    assert load_attribution(run, dataset, store=store) == replaced
    assert load_attribution(replace(run, rows=run.rows[:1]), dataset, store=store) is None


def test_stopped_work_keeps_nothing(run, dataset, store):
    done = []
    rows = attribute_run(
        run, dataset, store=store, progress=lambda step, _: done.append(step), cancelled=lambda: 1 in done
    )
    assert len(rows["dimensions"]) == 1
    assert load_attribution(run, dataset, store=store) is None


def test_networks_that_changed_are_refused(run, dataset, store):
    other = replace(run, digests={**run.digests, "mass": "another"})
    with pytest.raises(ArgumentError, match="weights changed since the run was made: make a new run"):
        attribute_run(other, dataset, store=store)


def test_recordings_that_are_gone_are_left_out(run, dataset, store):
    fewer = type(dataset)(dataset.root, {name: dataset[name] for name in IDS[:2]})
    rows = attribute_run(run, fewer, store=store)["dimensions"]
    assert [row["recording_id"] for row in rows] == list(IDS[:2])


@pytest.fixture(scope="module")
def synthetic(tmp_path_factory):
    root = tmp_path_factory.mktemp("synthetic") / "demo"
    write_demo(root, containers=(1,), recordings_per_container=1, size=(320, 180), workers=0)
    return open_dataset(root)


@pytest.fixture(scope="module")
def ablated(synthetic, tmp_path_factory):
    presets = {"paper": ShapeParameters.paper(), "tuned": FEW}
    steps = []
    rows = ablate(
        synthetic,
        store=Store(tmp_path_factory.mktemp("empty")),
        presets=presets,
        progress=lambda *step: steps.append(step),
    )
    assert steps == [(0, 2), (1, 2), (1, 2), (2, 2)]
    return {condition: estimates_table(found) for condition, found in rows.items()}


def test_all_stages_are_known_of_synthetic_recordings(synthetic, dataset, store):
    assert known_stages(synthetic, store=store) == STAGES
    assert known_stages([*synthetic, *dataset], store=store) == STAGES
    assert known_stages(dataset, store=store) == ("dimensions",)


def test_every_part_is_left_out_once():
    tuned = ShapeParameters.tuned()
    for name, parameters in ablation_presets().items():
        changed = [key for key, value in vars(parameters).items() if value != getattr(tuned, key)]
        assert len(changed) == (1 if name.startswith("tuned,") else len(changed))
        assert (parameters == tuned) == (name == "tuned")


def test_tuned_is_nearer_to_the_red_cup_than_the_paper(ablated, synthetic):
    table = ablation_table(ablated, synthetic.table)[list(GEOMETRY)].mean(axis=1)
    assert table["true", "tuned", "all"] < table["true", "paper", "all"] / 2
    assert table["true", "tuned", "all"] < 6


def test_recordings_without_detections_are_counted_and_in_no_mean(ablated, synthetic):
    table = ablation_table(ablated, synthetic.table)
    assert table.loc[("detected", "tuned", "all"), "failed"] == 1
    assert table.loc[("detected", "tuned", "all"), list(GEOMETRY)].isna().all()
    assert table.loc[("true", "tuned", "seen"), "failed"] == 0
    assert table.loc[("true", "tuned", "all"), "height_mm inside"] in {0, 100}
