from collections.abc import Iterator

import pytest

from corsmal.dataset import open_dataset
from corsmal.engines.tasks import open_detector, open_predictors
from corsmal.estimation import TrainingMeans
from corsmal.runs import make_run
from corsmal.runs.run import save_run
from corsmal.stages.estimates import Predictors
from corsmal.stages.settings import EstimateSettings
from corsmal.store import Store
from tests.fakes import FakeFilling, FakeMass


@pytest.fixture(scope="module")
def dataset(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)


@pytest.fixture(scope="module")
def fake_networks() -> Iterator[dict[str, object]]:
    """What settings open in place of networks; a test may put others there."""
    networks: dict[str, object] = {"filling": FakeFilling(2, 1), "mass": FakeMass(20.0)}

    def open_fakes(settings: EstimateSettings) -> Predictors:
        return Predictors(settings.shape, settings.means, **networks)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(EstimateSettings, "open", open_fakes)
        yield networks
    open_predictors.cache_clear()
    open_detector.cache_clear()


@pytest.fixture(scope="module")
def settings(dataset, request):
    request.getfixturevalue("fake_networks")
    return EstimateSettings(means=TrainingMeans.of(dataset))


@pytest.fixture(scope="module")
def first_run(dataset, settings, tmp_path_factory):
    """A run named ``first``."""
    return make_run("first", dataset, settings, store=Store(tmp_path_factory.mktemp("store")))


@pytest.fixture
def run(first_run, store):
    """The same, held by the test's own store."""
    save_run(first_run, store=store)
    return first_run
