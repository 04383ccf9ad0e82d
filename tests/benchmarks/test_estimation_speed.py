"""One recording's estimate, kept and computed. Compare the rows of one run."""

import json
from dataclasses import replace

import pytest
import torch

from corsmal.estimation import RecordingMasks, estimate, mass_inputs
from corsmal.filling import FillingPredictor, log_mel
from corsmal.mass import MassPredictor
from corsmal.parameters import METHOD_VIEWS, PAIRS, ShapeParameters
from corsmal.shape import fit_hull, measure_hull
from corsmal.stages.estimates import KIND, Predictors, load_estimate
from corsmal.store import Store
from tests.networks import write_networks

keeping = pytest.mark.benchmark(group="kept estimate", max_time=0.4)
computing = pytest.mark.benchmark(group="estimate")


@pytest.fixture(scope="module")
def predictors(tmp_path_factory):
    paths = write_networks(tmp_path_factory.mktemp("networks"))
    return Predictors(filling=FillingPredictor(paths["filling"]), mass=MassPredictor(paths["mass"]))


@pytest.fixture
def kept(recording, predictors, tmp_path):
    """A store that holds the estimate."""
    store = Store(tmp_path / "kept")
    assert load_estimate(recording, predictors, store=store)["status"] == "fitted"
    return store


@keeping
def test_a_kept_estimate_of_one_recording(benchmark, recording, predictors, kept):
    assert benchmark(load_estimate, recording, predictors, store=kept)["status"] == "fitted"


@keeping
def test_bare_reading_of_its_row(benchmark, kept):
    [key] = kept.keys(KIND)
    assert benchmark(kept.json, KIND, key)


@computing
@pytest.mark.parametrize("preset", ["paper", "lode", "tuned"])
def test_a_new_estimate_of_one_recording(benchmark, recording, predictors, preset, tmp_path):
    chosen = replace(predictors, shape=getattr(ShapeParameters, preset)())
    numbers = iter(range(100))

    def fresh():
        return (recording, chosen), {"store": Store(tmp_path / str(next(numbers)))}

    row = benchmark.pedantic(load_estimate, setup=fresh, rounds=5)
    assert row["status"] == "fitted"


@computing
@pytest.mark.parametrize("preset", ["paper", "lode", "tuned"])
def test_bare_parsing_fits_stft_and_forward_passes(benchmark, recording, opened, predictors, preset):
    shape = getattr(ShapeParameters, preset)()
    found = estimate(recording, detections=opened.found.views, shape=shape)
    weighed = mass_inputs(found, RecordingMasks(recording, opened.found.views))
    views = METHOD_VIEWS if shape.all_views else PAIRS[0]
    cameras = [recording.views[view].camera() for view in views]
    masks = [opened.found.views[view][opened.frame].mask(0) for view in views]
    assert fit_hull(cameras, masks, shape).ok
    samples = recording.audio().samples
    features = torch.from_numpy(log_mel(samples))[None]
    window = torch.hann_window(2048)
    paths = [view.detections_path for view in recording.views.values() if view.detections_path]
    image = torch.from_numpy(predictors.mass.predict(**weighed).network_input)[None, None]
    numbers = torch.ones(1, predictors.mass.config.numbers)

    @torch.inference_mode()
    def bare():
        for path in paths:
            json.loads(path.read_bytes())
        for _ in range(shape.frames):
            measure_hull(fit_hull(cameras, masks, shape), shape)
        torch.stft(torch.from_numpy(samples.copy()), 2048, 1024, window=window, return_complex=True)
        return predictors.filling._models[0](features), predictors.mass.model(image, numbers)

    assert benchmark.pedantic(bare, rounds=5, warmup_rounds=1)
