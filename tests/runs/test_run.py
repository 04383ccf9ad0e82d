import os
from dataclasses import replace

import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError, FileError, NotFoundError
from corsmal.estimation import training_means
from corsmal.parameters import ShapeParameters
from corsmal.runs.run import Run, data_digest, delete_run, list_runs, load_run, record_run, save_run
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.store import Store
from tests.fakes import FakeFilling, FakeMass
from tests.tiny import write_tiny_dataset

IDS = ("000000", "000001", "000002")


@pytest.fixture(scope="module")
def predictors(dataset):
    return Predictors(means=training_means(dataset.table), filling=FakeFilling(2, 1), mass=FakeMass(20.0))


@pytest.fixture(scope="module")
def made(dataset, predictors, tmp_path_factory):
    return record_run("first", dataset, IDS, predictors, store=Store(tmp_path_factory.mktemp("store")))


@pytest.fixture
def run(made, store):
    """A run that the test's own store holds."""
    save_run(made, store=store)
    return made


def assert_same(run: Run, other: Run | None) -> None:
    assert other is not None
    for name in Run.__dataclass_fields__:
        assert getattr(run, name) == getattr(other, name)
    assert run.key == other.key


def test_a_run_holds_the_estimates_and_what_they_were_made_with(run, dataset, predictors, tmp_path):
    other = Store(tmp_path / "other")
    assert list(run.rows) == [load_estimate(recording, predictors, store=other) for recording in dataset]
    assert run.is_complete
    assert run.shape == ShapeParameters.paper()
    assert run.networks == {"filling": "fake filling (2, 1)", "mass": "fake mass 20.0"}
    assert run.data_digest == data_digest(dataset)


def test_a_run_survives_the_program(run, dataset, store):
    assert_same(run, load_run("first", dataset=dataset.root, store=Store(store.root)))


def test_own_parameters_survive_too(dataset, predictors, store):
    shape = replace(ShapeParameters.lode(), circumferences=40, max_difference_mm=0.35)
    record_run("own", dataset, IDS[:1], replace(predictors, shape=shape), store=store)
    assert load_run("own", dataset=dataset.root, store=store).shape == shape


def test_a_stopped_run_goes_on_where_it_was(dataset, predictors, store):
    asked = iter([False, True, True])
    stopped = record_run("first", dataset, IDS, predictors, store=store, cancelled=lambda: next(asked))
    assert [row["recording_id"] for row in stopped.rows] == ["000000"]
    assert not stopped.is_complete
    whole = record_run("first", dataset, IDS, predictors, store=store)
    assert whole.is_complete
    assert whole.created == stopped.created
    again = record_run("first", dataset, IDS, predictors, store=store, cancelled=lambda: True)
    assert again.rows == whole.rows  # what was there is not lost when it is stopped at once


def test_recordings_are_prepared_before_they_are_estimated_unless_it_is_stopped(dataset, predictors, store):
    prepared = []
    record_run("a", dataset, IDS, predictors, store=store, before=prepared.append, cancelled=lambda: len(prepared) > 1)
    assert [recording.id for recording in prepared] == ["000000", "000001"]
    assert len(load_run("a", dataset=dataset.root, store=store).rows) == 1


@pytest.mark.usefixtures("run")
def test_a_name_that_other_settings_took_is_refused(dataset, predictors, store):
    other = replace(predictors, shape=ShapeParameters.lode())
    with pytest.raises(ArgumentError, match="'first' is taken by a run with other settings"):
        record_run("first", dataset, IDS, other, store=store)
    with pytest.raises(ArgumentError, match="choose another name or delete it"):
        record_run("first", dataset, IDS[:1], predictors, store=store)
    delete_run("first", dataset=dataset.root, store=store)
    assert record_run("first", dataset, IDS[:1], other, store=store).is_complete


@pytest.mark.parametrize("name", ["", "   ", "x" * 61, "a\nb"])
def test_what_can_be_no_name_is_refused(dataset, predictors, store, name):
    with pytest.raises(ArgumentError, match="a run's name must be 1 to 60 printable characters"):
        record_run(name, dataset, IDS[:1], predictors, store=store)


def test_recordings_must_be_there(dataset, predictors, store):
    with pytest.raises(ArgumentError, match="at least one"):
        record_run("a", dataset, [], predictors, store=store)
    with pytest.raises(NotFoundError, match="no recording '000009'"):
        record_run("a", dataset, ["000009"], predictors, store=store)
    assert list_runs(store=store) == []


def test_runs_are_listed_by_dataset_the_newest_first(run, dataset, store):
    save_run(replace(run, name="newer", created="2999-01-01T00:00:00+00:00"), store=store)
    save_run(replace(run, dataset="/elsewhere"), store=store)
    assert [found.name for found in list_runs(store=store, dataset=dataset.root)] == ["newer", "first"]
    assert len(list_runs(store=store)) == 3
    assert [found.dataset for found in list_runs(store=store, dataset="/elsewhere")] == ["/elsewhere"]


def test_a_deleted_run_is_gone_and_deleting_it_again_is_nothing(run, dataset, store):
    for _ in range(2):
        delete_run(run.name, dataset=dataset.root, store=store)
        assert list_runs(store=store) == []


@pytest.mark.usefixtures("run")
@pytest.mark.parametrize("content", [{}, {"name": "x"}, {"shape": 3}, {"shape": {"height_range": {}}, "rows": None}])
def test_what_another_version_wrote_is_no_run(store, content):
    path = next((store.root / "runs").glob("*/*.json"))
    store.save_json("runs", path.stem, content)
    assert list_runs(store=store) == []


@pytest.mark.usefixtures("run")
def test_a_broken_file_is_set_aside(store):
    next((store.root / "runs").glob("*/*.json")).write_bytes(b"{")
    assert list_runs(store=store) == []
    assert "unreadable" in store.problems[-1]


def test_changed_files_and_rows_have_other_digests(run, tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=1)
    before = data_digest(open_dataset(root))
    os.utime(root / "audio" / "000000.wav", ns=(1, 1))
    assert data_digest(open_dataset(root)) != before
    assert replace(run, rows=run.rows[:1]).key != run.key
    assert replace(run, data_digest=before).key != run.key
    assert replace(run, name="other").key == run.key


def test_a_run_that_cannot_be_kept_is_an_error(dataset, predictors, blocked):
    with pytest.raises(FileError, match="the run could not be kept"):
        record_run("a", dataset, IDS[:1], predictors, store=blocked)
