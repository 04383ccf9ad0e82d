import json
from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError
from corsmal.estimation import TrainingMeans, estimate
from corsmal.filling import FillingPredictor
from corsmal.mass import MassPredictor
from corsmal.parameters import ShapeParameters
from corsmal.stages import moments as knowing
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.moments import Moment, coarse_to_fine, kept_estimate, known_since_s, known_when, moments_s
from tests.networks import write_networks
from tests.tiny import write_audio, write_tiny_dataset, write_video

FPS = 30
SHAPES = {"paper": ShapeParameters(circumferences=40), "tuned": replace(ShapeParameters.tuned(), frames=3)}


@pytest.fixture(scope="module")
def recording(dataset):
    return dataset["000000"]


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    """Networks that have learnt nothing: their answers depend on all that they are given."""
    paths = write_networks(tmp_path_factory.mktemp("networks"))
    return {"filling": FillingPredictor(paths["filling"]), "mass": MassPredictor(paths["mass"])}


@pytest.fixture(params=SHAPES)
def predictors(request, dataset, networks):
    return Predictors(SHAPES[request.param], TrainingMeans.of(dataset), **networks)


@pytest.fixture(scope="module")
def ended_earlier(tmp_path_factory):
    """The same recording whose recorders were stopped after seven frames."""
    frames = 7
    root = write_tiny_dataset(tmp_path_factory.mktemp("earlier"), recordings=1, frames=frames)
    write_audio(root / "audio" / "000000.wav", seconds=frames / FPS, seed=0)
    return frames / FPS, open_dataset(root)["000000"]


def plain_estimate(recording, predictors):
    """Slow: with nothing kept."""
    return estimate(
        recording,
        shape=predictors.shape,
        means=predictors.means.for_container(recording.annotation),
        filling=predictors.filling,
        mass=predictors.mass,
    )


def moments_of(recording, predictors, times_s, store):
    return list(known_when(recording, load_detections(recording, store=store), predictors, times_s, store=store))


def test_the_last_moment_is_the_estimate_of_the_recording(recording, predictors, store):
    last_s = moments_s(recording)[-1]
    [moment] = moments_of(recording, predictors, [last_s], store)
    assert moment == Moment(last_s, plain_estimate(recording, predictors).row())
    of_a_run = load_estimate(recording, predictors, store=store)
    assert {name: of_a_run[name] for name in moment.row} == moment.row


def test_a_moment_is_the_estimate_of_the_recording_that_ended_then(recording, predictors, ended_earlier, store):
    end_s, shorter = ended_earlier
    [moment] = moments_of(recording, predictors, [end_s], store)
    assert moment.row == plain_estimate(shorter, predictors).row()
    assert moment.row != plain_estimate(recording, predictors).row()


def test_before_anything_was_seen_only_the_sound_speaks(recording, predictors, store):
    detections = load_detections(recording, store=store)
    later = {name: {frame: found[frame] for frame in found if frame > 5} for name, found in detections.views.items()}
    [moment] = known_when(recording, replace(detections, views=later), predictors, [4 / FPS], store=store)
    assert (moment.is_fitted, moment.row["status"]) == (False, "fallback: training mean")
    assert moment.row["filling_type"] is not None


def test_a_recording_without_sound_is_known_by_sight(dataset, predictors, store):
    silent = dataset["000001"]
    moments = moments_of(silent, predictors, moments_s(silent, steps=3), store)
    assert [moment.row["type_p0"] for moment in moments] == [None] * 3
    assert moments[-1].is_fitted


def test_moments_are_kept(recording, predictors, store, monkeypatch):
    times_s = moments_s(recording, steps=4)
    first = moments_of(recording, predictors, times_s, store)
    monkeypatch.setattr(knowing, "kept_estimate", None)
    assert moments_of(recording, predictors, times_s, store) == first
    assert [json.loads(json.dumps(moment.row)) for moment in first] == [moment.row for moment in first]


def row(**changes):
    values = {"status": "fitted", "filling_type": 2, "filling_level": 1, "capacity_ml": 500.0, "container_mass_g": 10.0}
    return values | changes


def test_answers_are_known_since_they_do_not_change_any_more():
    rows = [
        row(filling_level=2, capacity_ml=440.0, container_mass_g=None),
        row(filling_level=2, capacity_ml=460.0, status="fallback: training mean"),
        row(filling_type=1, capacity_ml=549.0, container_mass_g=30.0),
        row(),
    ]
    moments = [Moment(float(time_s), each) for time_s, each in enumerate(rows, 1)]
    since = {"filling_type": 4.0, "filling_level": 3.0, "capacity_ml": 3.0, "container_mass_g": 4.0}
    assert known_since_s(moments) == since
    unknown = Moment(5.0, row(status="failed", filling_type=None, filling_level=None, capacity_ml=None))
    assert known_since_s([*moments, unknown]) == {}
    assert known_since_s([]) == {}


def test_only_what_is_kept_is_read_where_nothing_is_to_be_computed(recording, predictors, store):
    times_s = moments_s(recording, steps=4)
    moments_of(recording, predictors, times_s[1:2], store)
    detections = load_detections(recording, store=store)
    kept = list(known_when(recording, detections, predictors, times_s, store=store, only_kept=True))
    assert [moment.time_s for moment in kept] == [times_s[1]]


def test_the_record_behind_the_numbers_has_the_fitted_hull(recording, predictors, store):
    found = kept_estimate(recording, load_detections(recording, store=store), predictors, store=store)
    plain = plain_estimate(recording, predictors)
    assert found.row() == plain.row()
    np.testing.assert_array_equal(found.fit.hull.radii_mm, plain.fit.hull.radii_mm)
    np.testing.assert_array_equal(found.mass.restored.mask, plain.mass.restored.mask)


def test_times_reach_to_the_end_of_what_lasts_longest(tmp_path):
    root = write_tiny_dataset(tmp_path, recordings=1, frames=6)
    write_audio(root / "audio" / "000000.wav", seconds=0.1)
    assert moments_s(open_dataset(root)["000000"], steps=2) == pytest.approx((0.1, 0.2))
    write_audio(root / "audio" / "000000.wav", seconds=0.5)
    assert moments_s(open_dataset(root)["000000"], steps=2) == pytest.approx((0.25, 0.5))
    write_video(root / "view2" / "rgb" / "000000.mp4", [np.zeros((36, 64, 3), np.uint8)] * 30)
    assert moments_s(open_dataset(root)["000000"], steps=1) == pytest.approx((1.0,))


def test_nothing_that_can_be_read_has_no_times(recording):
    assert moments_s(replace(recording, views={}, audio_path=None)) == ()


def test_times_that_cannot_be_are_refused(recording, predictors, store):
    with pytest.raises(ArgumentError, match="steps must be at least 1, got 0"):
        moments_s(recording, steps=0)
    with pytest.raises(ArgumentError, match="times_s must be positive"):
        moments_of(recording, predictors, [0.0], store)


@pytest.mark.parametrize("total", [1, 2, 5, 16])
def test_the_end_comes_first_then_the_gaps_are_halved(total):
    times_s = list(np.arange(1.0, total + 1))
    order = coarse_to_fine(times_s)
    assert sorted(order) == times_s
    assert order[0] == total
    if total == 16:
        assert order[:4] == [16, 8, 12, 4]
