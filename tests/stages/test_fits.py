import numpy as np
import pytest

from corsmal.estimation import fit_frame
from corsmal.parameters import PAIRS, ShapeParameters
from corsmal.stages import fits as fitting
from corsmal.stages.detections import load_detections
from corsmal.stages.fits import NUMBERS, load_fit
from corsmal.store import Store
from tests.tiny import FRAMES

CHOICE = {"pair": PAIRS[0], "frame": 2, "centre_rule": "horizontal third", "shape": ShapeParameters(circumferences=40)}


@pytest.fixture(scope="module")
def with_files(dataset):
    return dataset["000000"]


def assert_same(fit, other):
    assert (fit.pair, fit.frame) == (other.pair, other.frame)
    for name in ("heights_mm", "radii_mm", "converged", "centroid_m", "direction"):
        np.testing.assert_array_equal(getattr(fit.hull, name), getattr(other.hull, name))
    assert [getattr(fit.hull, name) for name in NUMBERS] == [getattr(other.hull, name) for name in NUMBERS]
    for name in ("capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "reason", "bottom", "top"):
        assert getattr(fit.dimensions, name) == getattr(other.dimensions, name)
    np.testing.assert_array_equal(fit.dimensions.kept, other.dimensions.kept)


def forbid_fitting(monkeypatch):
    def refuse(*_args, **_choices):
        raise AssertionError("this should have come from the store")

    monkeypatch.setattr(fitting, "fit_masks", refuse)


@pytest.mark.parametrize("shape", [CHOICE["shape"], ShapeParameters.tuned()], ids=["paper", "tuned"])
def test_a_fit_is_the_same_from_the_store(with_files, store, monkeypatch, shape):
    choice = CHOICE | {"shape": shape}
    found = load_detections(with_files, store=store)
    plain = fit_frame(with_files, found.views, **choice)
    assert plain.ok
    assert_same(load_fit(with_files, found, **choice, store=store), plain)
    forbid_fitting(monkeypatch)
    assert_same(load_fit(with_files, found, **choice, store=store), plain)


@pytest.mark.parametrize(
    "change",
    [
        {"pair": PAIRS[1]},
        {"frame": 3},
        {"centre_rule": "none"},
        {"shape": ShapeParameters(circumferences=40, max_difference_mm=2)},
    ],
)
def test_another_choice_is_another_fit(with_files, store, monkeypatch, change):
    found = load_detections(with_files, store=store)
    load_fit(with_files, found, **CHOICE, store=store)
    forbid_fitting(monkeypatch)
    with pytest.raises(AssertionError, match="from the store"):
        load_fit(with_files, found, **{**CHOICE, **change}, store=store)


@pytest.mark.parametrize("damage", [lambda _: b"", lambda content: content[:300], lambda _: b"x" * 900])
def test_a_stored_fit_that_was_damaged_is_fitted_again(with_files, store, damage):
    found = load_detections(with_files, store=store)
    plain = load_fit(with_files, found, **CHOICE, store=store)
    [path] = store.root.rglob("*.npz")
    path.write_bytes(damage(path.read_bytes()))
    assert_same(load_fit(with_files, found, **CHOICE, store=store), plain)
    assert_same(load_fit(with_files, found, **CHOICE, store=Store(store.root)), plain)
    assert list(store.root.rglob("*.broken"))


def test_a_store_that_cannot_be_written_does_not_stop_a_fit(with_files, blocked):
    found = load_detections(with_files, store=blocked)
    assert_same(load_fit(with_files, found, **CHOICE, store=blocked), fit_frame(with_files, found.views, **CHOICE))
    assert "cannot be written" in blocked.problems[-1]


def test_a_fit_that_failed_says_why_every_time_and_is_not_kept(with_files, store):
    found = load_detections(with_files, store=store)
    for _ in range(2):
        fit = load_fit(with_files, found, **{**CHOICE, "frame": FRAMES}, store=store)
        assert fit.dimensions.reason == f"frame {FRAMES} of view3 was not inspected"
    assert not list(store.root.rglob("*.npz"))


def test_a_view_that_the_recording_lacks_is_a_failed_fit(dataset, store):
    recording = dataset["000001"]
    found = load_detections(recording, store=store)
    fit = load_fit(recording, found, **{**CHOICE, "pair": PAIRS[1]}, store=store)
    assert fit.dimensions.reason == "view2 has no video"
