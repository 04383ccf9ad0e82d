import pytest
import torch
from torch import nn

from corsmal.errors import FileError
from corsmal.weights import read_checkpoint, read_network, save_network


@pytest.fixture
def network():
    return nn.Sequential(nn.Linear(3, 2), nn.BatchNorm1d(2))


def test_a_network_survives_the_file(tmp_path, network):
    path = tmp_path / "weights.safetensors"
    save_network(path, network, kind="toy", config={"widths": [3, 2]})
    config, state = read_network(path, kind="toy", advice="train one")
    assert config == {"widths": [3, 2]}
    for name, value in network.state_dict().items():
        assert torch.equal(state[name], value)


def test_half_precision_is_for_parameters_and_not_for_statistics(tmp_path, network):
    network[1].running_mean.fill_(1 / 3)
    save_network(tmp_path / "a", network, kind="toy", config={}, half=True)
    _, state = read_network(tmp_path / "a", kind="toy", advice="train one")
    assert all(value.dtype in (torch.float32, torch.int64) for value in state.values())
    assert torch.equal(state["1.running_mean"], network[1].running_mean)
    assert torch.equal(state["0.weight"], network[0].weight.half().float())


def test_another_kind_is_an_error(tmp_path, network):
    save_network(tmp_path / "a", network, kind="toy", config={})
    with pytest.raises(FileError, match="is no file of the real network's weights; train one"):
        read_network(tmp_path / "a", kind="real", advice="train one")


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path, network):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another folder"):
        save_network(tmp_path / "file" / "a", network, kind="toy", config={})


def test_a_checkpoint_is_read_without_code(tmp_path):
    path = tmp_path / "last.ckpt"
    assert read_checkpoint(path) is None
    torch.save({"state_dict": {"a": torch.ones(2)}, "epoch": 3, "callbacks": {}}, path)
    assert read_checkpoint(path)["epoch"] == 3
    for content in ({"state_dict": {}}, [1], {"state_dict": {}, "epoch": 1, "callbacks": print}):
        torch.save(content, path)
        with pytest.raises(FileError, match="delete it to begin again"):
            read_checkpoint(path)
