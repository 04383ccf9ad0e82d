import pickle
from dataclasses import replace

import pytest

from corsmal.engines.engine import attempt
from corsmal.errors import ArgumentError
from corsmal.estimation import estimate
from corsmal.parameters import ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs import make_run
from corsmal.runs import sweep as sweeping
from corsmal.runs.sweep import Axis, Grid, load_sweep, run_grid, sweep_run
from corsmal.store import Store

IDS = ("000000", "000001", "000002")
COUNTS, STEPS_MM = Axis("circumferences", (20, 60)), Axis("max_difference_mm", (0.0, 0.4, 1.0, 5.0))
GRID = Grid(IDS, COUNTS, STEPS_MM)
SETTINGS = 8


@pytest.fixture(scope="module")
def run(dataset, settings, tmp_path_factory):
    return make_run("first", dataset, settings, store=sweeping.Store(tmp_path_factory.mktemp("store")))


@pytest.fixture
def fits(monkeypatch):
    """The recordings and numbers of circumferences that were fitted, not read or measured again."""
    seen = []

    def counting(recording, views, **choices):
        seen.append((recording.id, choices["shape"].circumferences))
        return plain(recording, views, **choices)

    plain = sweeping.fit_frame
    monkeypatch.setattr(sweeping, "fit_frame", counting)
    return seen


def with_shape(run, **changes):
    return replace(run, settings=replace(run.settings, shape=ShapeParameters(**changes)))


def test_every_setting_measures_what_an_estimate_with_it_would(run, dataset, store):
    rows = sweep_run(run, dataset, GRID, store=store)
    assert len(rows) == len(dataset) * SETTINGS
    for row in rows:
        settings = {name: row[name] for name in ("circumferences", "max_difference_mm")}
        alone = estimate(dataset[row["recording_id"]], shape=ShapeParameters(**settings))
        assert [row[name] for name in GEOMETRY] == [getattr(alone, name) for name in GEOMETRY]


def test_a_fit_of_many_frames_is_swept_over_what_it_depends_on(run, dataset, store):
    tuned = replace(run, settings=replace(run.settings, shape=replace(ShapeParameters.tuned(), frames=2)))
    grid = run_grid(tuned, IDS[:1], Axis("frames", (1,)), Axis("wall_mm", (0.0,)))
    assert (grid.across.values, grid.down.values) == ((1, 2), (0.0, 1.0))  # its own setting is there too
    for row in sweep_run(tuned, dataset, grid, store=store):
        shape = replace(tuned.settings.shape, frames=row["frames"], wall_mm=row["wall_mm"])
        alone = estimate(dataset[row["recording_id"]], shape=shape)
        assert [row[name] for name in GEOMETRY] == [getattr(alone, name) for name in GEOMETRY]


def test_a_parameter_that_does_nothing_is_not_swept(run):
    lode = replace(run, settings=replace(run.settings, shape=ShapeParameters.lode()))
    with pytest.raises(ArgumentError, match="does not depend on max_difference_mm; it does on circumferences, points"):
        run_grid(lode, IDS, COUNTS, STEPS_MM)
    with pytest.raises(ArgumentError, match="two different parameters"):
        run_grid(run, IDS, COUNTS, COUNTS)


def test_recordings_that_cannot_be_measured_have_no_numbers(run, dataset, store):
    rows = sweep_run(run, dataset, replace(GRID, recordings=("000002",)), store=store)  # without detections
    assert len(rows) == SETTINGS
    assert {row[name] for row in rows for name in GEOMETRY} == {None}


def test_a_hull_is_fitted_once_for_each_number_of_circumferences(run, dataset, store, fits):
    sweep_run(run, dataset, Grid(IDS[:1], Axis("circumferences", (40, 60)), STEPS_MM), store=store)
    assert sorted(fits) == [("000000", 40), ("000000", 60)]


def test_what_was_measured_is_read_the_next_time(run, dataset, store, fits):
    first = sweep_run(run, dataset, GRID, store=store)
    count = len(fits)
    assert sweep_run(run, dataset, GRID, store=store) == first
    assert len(fits) == count
    sweep_run(with_shape(run, points=23), dataset, GRID, store=store)
    assert len(fits) > count


def test_a_sweep_is_kept_for_its_run_grid_and_version(run, dataset, store, monkeypatch):
    rows = sweep_run(run, dataset, GRID, store=store)
    assert load_sweep(run, GRID, store=store) == rows
    assert load_sweep(with_shape(run, points=23), GRID, store=store) is None
    assert load_sweep(run, replace(GRID, across=Axis("circumferences", (20,))), store=store) is None
    monkeypatch.setattr(sweeping, "METHOD_VERSION", sweeping.METHOD_VERSION + 1)
    assert load_sweep(run, GRID, store=store) is None


def test_another_version_of_the_method_measures_anew(run, dataset, store, fits, monkeypatch):
    sweep_run(run, dataset, GRID, store=store)
    count = len(fits)
    monkeypatch.setattr(sweeping, "METHOD_VERSION", sweeping.METHOD_VERSION + 1)
    sweep_run(run, dataset, GRID, store=store)
    assert len(fits) == 2 * count


def test_an_engine_measures_in_whatever_order_and_elsewhere(run, dataset, store, tmp_path):
    def backwards(task, recordings, **_):
        task = pickle.loads(pickle.dumps(task))
        for index in reversed(range(len(recordings))):
            yield attempt(task, index, recordings[index])

    expected = sweep_run(run, dataset, GRID, store=store)
    assert sweep_run(run, dataset, GRID, store=Store(tmp_path / "other"), engine=backwards) == expected


def test_progress_is_reported_and_stopping_keeps_what_was_done(run, dataset, store, fits):
    steps = []
    rows = sweep_run(
        run,
        dataset,
        GRID,
        store=store,
        progress=lambda done, total: steps.append((done, total)),
        cancelled=lambda: len(steps) > 1,
    )
    assert steps == [(0, 3), (1, 3)]
    assert {row["recording_id"] for row in rows} == {"000000"}
    assert load_sweep(run, GRID, store=store) is None
    count = len(fits)
    sweep_run(run, dataset, replace(GRID, recordings=IDS[:1]), store=store)
    assert len(fits) == count


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"across": replace(COUNTS, values=())}, "at least one"),
        ({"recordings": ()}, "at least one"),
        ({"across": replace(COUNTS, values=(1, 20))}, "circumferences must be at least 2"),
        ({"down": replace(STEPS_MM, values=(-0.1,))}, "max_difference_mm must not be negative"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(run, dataset, store, change, said):
    with pytest.raises(ArgumentError, match=said):
        sweep_run(run, dataset, replace(GRID, **change), store=store)
