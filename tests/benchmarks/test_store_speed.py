"""Keeping and reading results, checksums and renaming included. Compare the rows of one run."""

import json

import numpy as np
import pytest

from corsmal.digests import digest

KEY = digest("benchmark")
writing_arrays = pytest.mark.benchmark(group="keep arrays", max_time=0.3)
reading_arrays = pytest.mark.benchmark(group="read arrays", max_time=0.3)
reading_row = pytest.mark.benchmark(group="read a row", max_time=0.2)


@pytest.fixture(scope="module")
def rows():
    """Log-mel rows of ten seconds, 0.9 MB."""
    return np.random.default_rng(0).normal(size=(8, 431, 128)).astype(np.float16)


@writing_arrays
def test_keep_log_mel_rows(benchmark, store, rows):
    assert benchmark(lambda: store.save_arrays("speed", KEY, rows=rows))


@writing_arrays
def test_bare_writing_of_the_bytes(benchmark, tmp_path, rows):
    assert benchmark(lambda: (tmp_path / "bytes").write_bytes(rows.tobytes()))


@reading_arrays
def test_read_kept_log_mel_rows(benchmark, store, rows):
    store.save_arrays("speed", KEY, rows=rows)
    assert benchmark(store.arrays, "speed", KEY)["rows"].shape == rows.shape


@reading_arrays
def test_bare_reading_of_the_bytes(benchmark, tmp_path, rows):
    np.save(tmp_path / "rows.npy", rows)
    assert benchmark(lambda: np.load(tmp_path / "rows.npy")).shape == rows.shape


@reading_row
def test_read_a_kept_row(benchmark, store):
    store.save_json("speed", KEY, {f"column {number}": number / 3 for number in range(40)})
    assert benchmark(store.json, "speed", KEY)


@reading_row
def test_bare_reading_and_parsing(benchmark, store):
    store.save_json("speed", KEY, {f"column {number}": number / 3 for number in range(40)})
    path = store.file("speed", KEY, ".json")
    assert benchmark(lambda: json.loads(path.read_bytes().partition(b"\n")[0]))
