import json
from dataclasses import asdict, replace

import numpy as np
import pytest
import safetensors.torch
import torch

from corsmal.errors import ArgumentError, FileError
from corsmal.filling import FillingModel, read_filling, save_filling
from tests.filling.made import SMALL, made_features


def models(*configs):
    return [FillingModel(config).eval() for config in configs]


@pytest.mark.parametrize("count", [1, 8])
def test_what_is_written_is_read_back(tmp_path, count):
    written = models(*(replace(SMALL, standardise=index % 2 == 1) for index in range(count)))
    for model in written:
        model.learn_statistics([made_features(5), made_features(9)])
    save_filling(tmp_path / "deep" / "filling.safetensors", written)
    found = read_filling(tmp_path / "deep" / "filling.safetensors")
    assert [model.config for model in found] == [model.config for model in written]
    features = torch.from_numpy(made_features(7))[None]
    for before, after in zip(written, found, strict=True):
        assert not after.training
        for one, other in zip(before.explain(features), after.explain(features), strict=True):
            assert torch.equal(one, other)


def test_models_that_do_not_belong_together_are_refused(tmp_path):
    path = tmp_path / "filling.safetensors"
    for configs in (
        (),
        (SMALL,) * 9,
        (SMALL, replace(SMALL, channels=1)),
        (SMALL, replace(SMALL, decoding="feasible")),
    ):
        with pytest.raises(ArgumentError, match="models must"):
            save_filling(path, models(*configs))
    assert not path.exists()


def test_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another folder"):
        save_filling(tmp_path / "file" / "filling.safetensors", models(SMALL))


def write(path, *, configs=None, change=None, metadata=True):
    """A file of one model's weights with something changed."""
    [model] = models(SMALL)
    state = {f"0.{name}": value for name, value in model.state_dict().items()}
    if change:
        change(state)
    text = json.dumps([asdict(SMALL)] if configs is None else configs)
    safetensors.torch.save_file(state, path, {"filling": text} if metadata else None)


def with_nan(state):
    state["0.cls"][3] = np.nan


def without_a_layer(state):
    del state["0.cls"]


def with_another_layer(state):
    state["1.cls"] = torch.zeros(3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"metadata": False}, "is not a file of the filling network's weights"),
        ({"configs": "text"}, "is not a file of the filling network's weights"),
        ({"configs": []}, "is not a file of the filling network's weights"),
        ({"configs": {"channels": 2}}, "is not a file of the filling network's weights"),
        ({"configs": [{**asdict(SMALL), "colour": "red"}]}, "is not a file of the filling network's weights"),
        ({"configs": [{**asdict(SMALL), "heads": 5}]}, "is not a file of the filling network's weights"),
        ({"configs": [{**asdict(SMALL), "hidden": 99}]}, "do not fit the sizes"),
        ({"configs": [asdict(SMALL)] * 2}, "do not fit the sizes"),
        ({"change": without_a_layer}, "do not fit the sizes"),
        ({"change": with_another_layer}, "do not fit the sizes"),
        ({"change": with_nan}, "not finite"),
    ],
)
def test_other_files_are_refused_with_what_to_do(tmp_path, given, message):
    path = tmp_path / "filling.safetensors"
    write(path, **given)
    with pytest.raises(FileError, match=message) as raised:
        read_filling(path)
    assert raised.value.path == path
    assert "train one with" in str(raised.value)


@pytest.mark.parametrize("content", [None, b"", b"no weights", b"\xff" * 64])
def test_broken_and_absent_files_are_refused(tmp_path, content):
    path = tmp_path / "filling.safetensors"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match="is not a file of the filling network's weights"):
        read_filling(path)


def test_truncated_file_is_refused(tmp_path):
    path = tmp_path / "filling.safetensors"
    write(path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(FileError, match="is not a file of the filling network's weights"):
        read_filling(path)
