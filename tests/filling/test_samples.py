import numpy as np
import pandas as pd
import pytest

from corsmal.errors import ArgumentError
from corsmal.filling import FillingSample, filling_samples
from corsmal.filling.samples import Batches, padded, random_crop
from tests.filling.made import WIDTH, made_features, made_samples


@pytest.mark.parametrize("rows", [1, 2, 3, 10, 431])
def test_crops_start_in_the_first_two_fifths_and_end_in_the_last_two(rows):
    rng = np.random.default_rng(0)
    crops = np.array([random_crop(rows, rng) for _ in range(2000)])
    starts, ends = crops.T
    assert starts.min() == 0
    assert starts.max() == (int(0.4 * rows) if rows > 10 else int(np.ceil(0.4 * rows)) - 1)
    assert ends.min() >= np.ceil(0.6 * rows)
    assert ends.max() == rows
    assert (starts < ends).all()
    if rows == 431:
        assert starts.mean() == pytest.approx(0.2 * rows, rel=0.05)
        assert ends.mean() == pytest.approx(0.8 * rows, rel=0.02)


def contents(batch):
    """(type, level, rows) of the recordings of a batch."""
    return [
        (int(kind), int(level), int(rows))
        for kind, level, rows in zip(batch.types, batch.levels, batch.mask.sum(dim=1), strict=True)
    ]


def test_every_pass_has_every_recording_once_and_whole():
    samples = made_samples(23)
    epoch = Batches(samples, size=4, tasks=("level", "both"), rng=np.random.default_rng(0))
    batches = list(epoch)
    assert len(epoch) == len(batches)
    assert [batch.task for batch in batches] == ["level"] * 6 + ["both"] * 6
    assert [len(batch.types) for batch in batches] == [4, 4, 4, 4, 4, 3] * 2
    expected = sorted((sample.filling_type, sample.filling_level, sample.rows) for sample in samples)
    passes = [sorted(entry for batch in half for entry in contents(batch)) for half in (batches[:6], batches[6:])]
    assert passes == [expected, expected]
    assert contents(batches[0]) != contents(batches[6])


def test_type_pass_sees_crops_and_only_when_drawn():
    samples = made_samples(40)
    whole = sum(sample.rows for sample in samples)
    for task, rng, cropped in (
        ("type", np.random.default_rng(0), True),
        ("type", None, False),
        ("level", np.random.default_rng(0), False),
    ):
        batches = Batches(samples, size=8, tasks=(task,), rng=rng)
        rows = sum(rows for batch in batches for _, _, rows in contents(batch))
        assert (rows < whole) is cropped
        assert rows >= 0.2 * whole


def test_batch_holds_the_features_and_zeros():
    samples = made_samples(3)
    crops = [(1, 3), (0, 3), (2, samples[2].rows)]
    batch = padded("type", samples, crops)
    longest = max(end - start for start, end in crops)
    assert batch.features.shape == (3, 2, longest, WIDTH)
    for index, (sample, (start, end)) in enumerate(zip(samples, crops, strict=True)):
        rows = end - start
        np.testing.assert_array_equal(batch.features[index, :, :rows], sample.features[:, start:end])
        assert batch.mask[index].tolist() == [row < rows for row in range(longest)]
        assert not batch.features[index, :, rows:].any()
    assert batch.types.tolist() == [sample.filling_type for sample in samples]
    assert batch.levels.tolist() == [sample.filling_level for sample in samples]


def test_same_generator_draws_the_same_batches():
    samples = made_samples(20)
    first, again, other = (
        [contents(batch) for batch in Batches(samples, size=8, tasks=("type",), rng=np.random.default_rng(seed))]
        for seed in (0, 0, 1)
    )
    assert first == again
    assert first != other


def test_samples_are_the_recordings_with_truth_and_features():
    table = pd.DataFrame(
        {"container_id": [1, 2, 3, 4], "filling_type": [0, 1, pd.NA, 3], "filling_level": [0, 2, 1, 1]},
        index=pd.Index(["000001", "000002", "000003", "000004"]),
        dtype="Int64",
    )
    features = {name: made_features(4) for name in ("000001", "000002", "000003")}
    first, second = filling_samples(table, features)
    assert (first.recording_id, first.container_id, first.filling_type, first.filling_level) == ("000001", 1, 0, 0)
    assert (second.recording_id, second.container_id, second.filling_type, second.filling_level) == ("000002", 2, 1, 2)
    assert second.features is features["000002"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"features": np.zeros((4, WIDTH), np.float32)}, "features of 000007 must be"),
        ({"features": np.zeros((1, 0, WIDTH), np.float32)}, "features of 000007 must be"),
        ({"features": np.zeros((1, 4, WIDTH))}, "float32"),
        ({"features": np.full((1, 4, WIDTH), np.nan, np.float32)}, "must be finite"),
        ({"filling_type": 4}, "filling_type of 000007 must be 0 to 3"),
        ({"filling_level": -1}, "filling_level of 000007 must be 0 to 2"),
    ],
)
def test_what_is_no_sample_is_refused(changes, message):
    given = {"features": made_features(4), "filling_type": 0, "filling_level": 0, **changes}
    with pytest.raises(ArgumentError, match=message):
        FillingSample(recording_id="000007", container_id=1, **given)
