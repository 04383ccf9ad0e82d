from dataclasses import replace

import pytest

from corsmal.errors import ArgumentError
from corsmal.estimation import estimate
from corsmal.parameters import ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.runs import sweep as sweeping
from corsmal.runs.sweep import sweep_recordings

COUNTS, STEPS_MM = (20, 60), (0.0, 0.4, 1.0, 5.0)
GRID = {"circumferences": COUNTS, "max_differences_mm": STEPS_MM, "shape": ShapeParameters.paper()}


@pytest.fixture
def fits(monkeypatch):
    """The settings that were fitted, not read or measured again."""
    seen = []

    def counting(recording, views, **choices):
        seen.append((recording.id, choices["shape"].circumferences))
        return plain(recording, views, **choices)

    plain = sweeping.fit_frame
    monkeypatch.setattr(sweeping, "fit_frame", counting)
    return seen


def test_every_setting_measures_what_an_estimate_with_it_would(dataset, store):
    rows = sweep_recordings(dataset, **GRID, store=store)
    assert len(rows) == len(dataset) * len(COUNTS) * len(STEPS_MM)
    for row in rows:
        shape = replace(GRID["shape"], circumferences=row["circumferences"], max_difference_mm=row["max_difference_mm"])
        alone = estimate(dataset[row["recording_id"]], shape=shape)
        assert [row[name] for name in GEOMETRY] == [getattr(alone, name) for name in GEOMETRY]


def test_recordings_that_cannot_be_measured_have_no_numbers(dataset, store):
    rows = sweep_recordings([dataset["000002"]], **GRID, store=store)  # without detections
    assert len(rows) == len(COUNTS) * len(STEPS_MM)
    assert {row[name] for row in rows for name in GEOMETRY} == {None}


def test_a_hull_is_fitted_once_for_each_number_of_circumferences(dataset, store, fits):
    steps_mm = (0.5, 1.0, 5.0)
    sweep_recordings(
        [dataset["000000"]], circumferences=(40, 60), max_differences_mm=steps_mm, shape=GRID["shape"], store=store
    )
    assert sorted(fits) == [("000000", 40), ("000000", 60)]


def test_what_was_measured_is_read_the_next_time(dataset, store, fits):
    first = sweep_recordings(dataset, **GRID, store=store)
    count = len(fits)
    assert sweep_recordings(dataset, **GRID, store=store) == first
    assert len(fits) == count
    sweep_recordings([dataset["000000"]], **{**GRID, "shape": ShapeParameters(points=23)}, store=store)
    assert len(fits) > count


def test_progress_is_told_and_stopping_keeps_what_was_done(dataset, store, fits):
    steps = []
    rows = sweep_recordings(
        dataset,
        **GRID,
        store=store,
        progress=lambda done, total: steps.append((done, total)),
        cancelled=lambda: len(steps) > 1,
    )
    assert steps == [(0, 3), (1, 3)]
    assert {row["recording_id"] for row in rows} == {"000000"}
    count = len(fits)
    sweep_recordings([dataset["000000"]], **GRID, store=store)
    assert len(fits) == count


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"circumferences": ()}, "at least one value"),
        ({"max_differences_mm": []}, "at least one value"),
        ({"circumferences": (1, 20)}, "circumferences must be at least 2"),
        ({"max_differences_mm": (-0.1,)}, "max_difference_mm must not be negative"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(dataset, store, change, said):
    with pytest.raises(ArgumentError, match=said):
        sweep_recordings(dataset, **{**GRID, **change}, store=store)
