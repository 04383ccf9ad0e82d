import numpy as np
import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.mass import MassRow
from corsmal.mass.network import MassConfig
from corsmal.mass.samples import Batches, MassSamples, held_out
from tests.mass.made import BOX, CUP, container

SMALL = {"size": (90, 120), "base": (60, 70)}


def small(profile):
    return tuple((width / 4, height / 4) for width, height in profile)


def made_row(index=0, *, profile=CUP, name="1", mass_g=10.0, **changes):
    mask = container(small(profile), **SMALL, tilt_deg=index % 7 - 3)
    numbers = {"width_top_mm": 98.0 + index % 5, "width_bottom_mm": 61.0, "height_mm": 119.0, "mm_per_px": 1.4}
    return MassRow(f"{name}-{index}", name, mask, **{**numbers, **changes}, mass_g=mass_g)


def made_rows(count=10):
    for index in range(count):
        yield made_row(index)
        yield made_row(index, profile=BOX, name="7", mass_g=59.0, height_mm=241.0, width_top_mm=193.0)


def test_rows_that_cannot_be_used_are_counted_by_their_reason():
    rows = [
        made_row(0),
        made_row(1, height_mm=None),
        made_row(2, height_mm=None),
        made_row(3, width_top_mm=-1.0),
        MassRow("4", "1", np.zeros((9, 9), bool), 98.0, 61.0, 119.0, 1.4, 10.0),
        made_row(5, mm_per_px=None),
    ]
    samples = MassSamples.of(iter(rows), MassConfig.paper())
    assert samples.recordings == (("1", "1-0"), ("1", "1-5"))
    assert samples.images.shape == (2, 112, 112)
    np.testing.assert_array_equal(samples.numbers, [[98, 61, 119]] * 2)
    assert samples.dropped == {
        "height_mm is missing": 2,
        "width_top_mm must be positive, got -1": 1,
        "the mask is empty": 1,
    }
    assert MassSamples.of(rows, MassConfig.tuned()).dropped["mm_per_px is missing"] == 1


def test_no_rows_are_no_samples():
    samples = MassSamples.of([], MassConfig.tuned())
    assert (len(samples), samples.images.shape, samples.numbers.shape) == (0, (0, 112, 112), (0, 4))


def test_a_row_needs_a_true_mass():
    for mass_g in (0.0, -1.0, float("nan")):
        with pytest.raises(ArgumentError, match="mass_g must be a positive number"):
            made_row(mass_g=mass_g)


def test_a_fifth_of_each_containers_recordings_is_held_out_whole():
    pairs = [(str(container), str(recording)) for container in (1, 2) for recording in range(10) for _ in range(3)]
    held = held_out(pairs, share=0.2, seed=0)
    assert held.shape == (60,)
    for container_id in ("1", "2"):
        out = {pair for pair, is_out in zip(pairs, held, strict=True) if is_out and pair[0] == container_id}
        assert len(out) == 2
    assert held.sum() == 2 * 2 * 3
    np.testing.assert_array_equal(held, held_out(pairs, share=0.2, seed=0))
    assert (held != held_out(pairs, share=0.2, seed=1)).any()


def test_the_only_recording_of_a_container_is_trained_on():
    np.testing.assert_array_equal(held_out([("1", "a"), ("2", "b"), ("2", "c")], share=0.9, seed=0)[0], False)
    assert held_out([("1", "a")], share=0.9, seed=0).tolist() == [False]
    assert held_out([], share=0.2, seed=0).shape == (0,)


def test_batches_hold_every_row_once_but_never_a_single_one():
    samples = MassSamples.of(made_rows(5), MassConfig.paper())
    for size, sizes in ((4, [4, 4, 2]), (3, [3, 3, 3]), (20, [10])):
        batches = Batches(samples, size, np.random.default_rng(0))
        assert [len(masses) for _, _, masses in batches] == sizes
        assert len(batches) == len(sizes)
    in_order = list(Batches(samples, 3, None))
    assert [len(masses) for _, _, masses in in_order] == [3, 3, 3, 1]
    np.testing.assert_array_equal(torch.cat([masses for _, _, masses in in_order]), samples.masses_g)
    images = torch.cat([images for images, _, _ in in_order])
    assert images.shape == (10, 1, 112, 112)
    np.testing.assert_allclose(images[:, 0].numpy() * 255, samples.images, atol=1e-4)


def test_shuffled_batches_keep_masks_numbers_and_masses_together():
    samples = MassSamples.of(made_rows(5), MassConfig.paper())
    for _, numbers, masses in Batches(samples, 4, np.random.default_rng(3)):
        assert ((numbers[:, 2] == 241) == (masses == 59)).all()
