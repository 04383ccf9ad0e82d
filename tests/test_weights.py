import pytest
import safetensors.torch
import torch
from torch import nn
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal.checkpoints import read_checkpoint
from corsmal.dataset import TrainedOn
from corsmal.detection import SmallDetector
from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation import read_estimates
from corsmal.filling import FillingPredictor
from corsmal.mass import MassPredictor
from corsmal.ui.filling import sound as filling_page
from corsmal.weights import (
    BUNDLED,
    WeightsFile,
    bundled_path,
    check_network_file,
    choose_device,
    file_sha256,
    find_weights,
    read_network,
    read_training,
    save_network,
)
from tests.networks import write_networks

KINDS = ("detector", "filling", "mass")


@pytest.fixture(autouse=True)
def environment(monkeypatch, tmp_path):
    for kind in KINDS:
        monkeypatch.delenv(f"CORSMAL_{kind.upper()}_WEIGHTS", raising=False)
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize("kind", KINDS)
def test_weights_are_those_that_are_named_else_the_environments_else_the_bundled(kind, tmp_path, monkeypatch):
    own, other = tmp_path / "own.safetensors", tmp_path / "other.safetensors"
    bundled = BUNDLED / f"{kind}.safetensors"
    assert find_weights(kind) == WeightsFile(kind, bundled, "bundled")
    assert find_weights(kind, own) == WeightsFile(kind, own, "named")
    monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", str(other))
    assert find_weights(kind) == WeightsFile(kind, other, "environment")
    assert find_weights(kind, str(own)) == WeightsFile(kind, own, "named")
    assert find_weights(kind, "demo") == WeightsFile(kind, bundled, "named")
    assert [find_weights(kind, named).is_bundled for named in (None, own, "demo")] == [False, False, True]
    monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", "")
    assert find_weights(kind).origin == "bundled"


def test_paths_are_absolute_so_that_other_processes_find_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert find_weights("mass", "own.safetensors").path == tmp_path / "own.safetensors"
    assert find_weights("mass", "~/own.safetensors").path == tmp_path / "home" / "own.safetensors"


def test_bundled_files_are_there_and_predict():
    assert SmallDetector(bundled_path("detector"), device="cpu").digest.startswith("small Mask R-CNN")
    assert FillingPredictor(bundled_path("filling")).channels == 8
    assert MassPredictor(bundled_path("mass")).config.channels
    for kind in ("filling", "mass"):
        assert TrainedOn.from_json(read_training(bundled_path(kind), kind)).is_synthetic


def test_the_command_reads_the_environments_weights_as_the_pages_do(tmp_path, monkeypatch, tiny_dataset_root):
    networks = write_networks(tmp_path)

    def rows(*options):
        table = tmp_path / "estimates.csv"
        command = ["estimate", str(tiny_dataset_root), "000000", "--out", str(table), *options]
        result = CliRunner().invoke(cli.app, command)
        assert result.exit_code == 0, result.output
        row = read_estimates(table).iloc[0]
        return [float(row[name]) for name in row.index if name.startswith("type_p")], float(row["container_mass_g"])

    named = rows("--filling", str(networks["filling"]), "--mass", str(networks["mass"]))
    bundled = rows()
    for kind, path in networks.items():
        monkeypatch.setenv(f"CORSMAL_{kind.upper()}_WEIGHTS", str(path))
    environments = rows()
    assert filling_page.predictor().digest == f"filling network {file_sha256(networks['filling'])}"
    for own, first, second in zip(environments, named, bundled, strict=True):
        assert own == pytest.approx(first)
        assert own != pytest.approx(second)


def toy(_config=None):
    return nn.Sequential(nn.Linear(3, 2), nn.BatchNorm1d(2))


@pytest.fixture
def network():
    return toy().eval()


def test_a_network_survives_the_file_with_its_config_and_what_it_was_trained_on(tmp_path, network):
    path = tmp_path / "weights.safetensors"
    training = {"recordings": {"000001": "fingerprint"}, "synthetic": False}
    save_network(path, network, kind="mass", config={"widths": [3, [2]]}, training=training)
    configs = []
    read = read_network(path, "mass", lambda config: configs.append(config) or toy().train())
    assert configs == [{"widths": (3, (2,))}]
    assert not read.training
    for name, value in network.state_dict().items():
        assert torch.equal(read.state_dict()[name], value)
    assert read_training(path, "mass") == training
    save_network(path, network, kind="mass", config={})
    assert read_training(path, "mass") == {}


def test_files_of_before_there_was_a_record_of_the_training_are_read(tmp_path, network):
    path = tmp_path / "old.safetensors"
    safetensors.torch.save_file(network.state_dict(), path, {"kind": "mass", "config": "{}"})
    assert read_training(path, "mass") == {}
    assert torch.equal(read_network(path, "mass", toy)[0].weight, network[0].weight)


def test_half_precision_is_for_parameters_and_not_for_statistics(tmp_path, network):
    network[1].running_mean.fill_(1 / 3)
    save_network(tmp_path / "a", network, kind="mass", config={}, half=True)
    read = read_network(tmp_path / "a", "mass", toy)
    assert all(value.dtype in (torch.float32, torch.int64) for value in read.state_dict().values())
    assert torch.equal(read[1].running_mean, network[1].running_mean)
    assert torch.equal(read[0].weight, network[0].weight.half().float())


def test_another_kind_is_an_error(tmp_path, network):
    save_network(tmp_path / "a", network, kind="mass", config={})
    for read in (
        lambda: read_network(tmp_path / "a", "filling", toy),
        lambda: read_training(tmp_path / "a", "filling"),
    ):
        with pytest.raises(FileError, match="is not a file of the filling network's weights; train one"):
            read()


def test_a_file_is_checked_without_loading_the_network(tmp_path, network):
    save_network(tmp_path / "good", network, kind="mass", config={})
    check_network_file(tmp_path / "good", "mass")
    network[0].weight.data[0, 0] = torch.nan
    save_network(tmp_path / "nan", network, kind="mass", config={})
    (tmp_path / "cut").write_bytes((tmp_path / "good").read_bytes()[:-8])
    for name, kind, problem in (
        ("nan", "mass", "weights that are not finite"),
        ("good", "filling", "is not a file of the filling network"),
        ("cut", "mass", "is not a file of the mass network"),
        ("absent", "mass", "is not a file of the mass network|cannot be read|is missing"),
    ):
        with pytest.raises(FileError, match=problem):
            check_network_file(tmp_path / name, kind)


@pytest.mark.parametrize("training", ["[]", "no JSON", "3"])
def test_a_record_of_the_training_that_is_none_is_an_error(tmp_path, network, training):
    metadata = {"kind": "mass", "config": "{}", "training": training}
    safetensors.torch.save_file(network.state_dict(), tmp_path / "a", metadata)
    with pytest.raises(FileError, match="is not a file of the mass network's weights"):
        read_training(tmp_path / "a", "mass")


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path, network):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FileError, match="choose another folder"):
        save_network(tmp_path / "file" / "a", network, kind="mass", config={})


def test_a_device_that_does_not_exist_is_an_error():
    assert choose_device().type == choose_device("cpu").type == "cpu"
    assert choose_device(prefer_gpu=True).type == ("cuda" if torch.cuda.is_available() else "cpu")
    with pytest.raises(ArgumentError, match="device 'abacus' cannot be used"):
        choose_device("abacus")


def test_a_checkpoint_is_read_without_code(tmp_path):
    path = tmp_path / "last.ckpt"
    assert read_checkpoint(path) is None
    torch.save({"state_dict": {"a": torch.ones(2)}, "epoch": 3, "global_step": 7, "callbacks": {}}, path)
    assert read_checkpoint(path)["epoch"] == 3
    for content in ({"state_dict": {}}, [1], {"state_dict": {}, "epoch": 1, "global_step": 1, "callbacks": print}):
        torch.save(content, path)
        with pytest.raises(FileError, match="delete it to begin again"):
            read_checkpoint(path)
