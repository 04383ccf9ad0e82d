"""Files of the authors' networks that are broken, hide code or cost too much: one sentence each, and nothing is run."""

import os
import pickle
import zipfile
from collections import OrderedDict
from pathlib import Path

import pytest
import torch

from corsmal.errors import FileError
from corsmal.filling import read_filling
from corsmal.mass import read_mass
from corsmal.state_dicts import BYTES_MAX, is_state_dict, read_state_dict
from tests.released import SHAPES, random_state, write_released

READ = {"filling": read_filling, "mass": read_mass}
FILE = {"filling": "task1and2.pt", "mass": "task4.pt"}
SMALL = {"conv1.weight": (2, 3), "conv1.bias": (3,)}


def small_state():
    return OrderedDict({"conv1.weight": torch.rand(2, 3), "conv1.bias": torch.rand(3)})


def read_small(path):
    return read_state_dict(path, "mass", SMALL)


def refused(path, *, message, read=read_small):
    with pytest.raises(FileError, match=message) as raised:
        read(path)
    assert raised.value.path == path
    assert "\n" not in str(raised.value)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "weights.pt"


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    return write_released(tmp_path_factory.mktemp("both"))


def test_tensors_are_read_in_single_precision_whatever_theirs(path):
    state = small_state()
    torch.save({**state, "conv1.bias": state["conv1.bias"].half()}, path)
    found = read_small(path)
    assert list(found) == list(SMALL)
    assert torch.equal(found["conv1.weight"], state["conv1.weight"])
    assert torch.equal(found["conv1.bias"], state["conv1.bias"].half().float())
    assert is_state_dict(path)
    assert not is_state_dict(path.with_name("absent.pt"))


@pytest.mark.parametrize("kind", ["filling", "mass"])
def test_swapped_files_are_told_apart(both, kind):
    other = next(name for name in both if name != kind)
    message = f"is the {other} network's file, not the {kind} network's; name it with .*, and here {FILE[kind]}"
    refused(both[other], message=message, read=READ[kind])


@pytest.mark.parametrize("kind", ["filling", "mass"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.98])
def test_truncated_files_are_refused(both, tmp_path, kind, share):
    content = both[kind].read_bytes()
    part = tmp_path / "part.pt"
    part.write_bytes(content[: int(share * len(content))])
    refused(part, message=f"is incomplete or damaged; name the authors' {FILE[kind]}", read=READ[kind])


def test_a_file_that_lost_bytes_in_the_middle_is_refused(both, tmp_path):
    content = bytearray(both["mass"].read_bytes())
    content[len(content) // 2 : len(content) // 2 + 64] = bytes(64)
    (tmp_path / "part.pt").write_bytes(content)
    refused(tmp_path / "part.pt", message="is incomplete or damaged", read=read_mass)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"conv1.bias": None}, "lacks conv1.bias; name"),
        ({"conv9.bias": torch.zeros(3)}, "holds conv9.bias besides; name"),
        ({"conv1.bias": None, "a": torch.zeros(1), "b": torch.zeros(1)}, "lacks conv1.bias and holds a and 1 more"),
        ({"conv1.bias": torch.zeros(4)}, r"has conv1.bias of \(4,\) where \(3,\) is expected"),
        ({"conv1.bias": 3.0}, r"has conv1.bias of float where \(3,\) is expected"),
        ({"conv1.bias": torch.tensor([0, float("nan"), 0])}, "not finite, in conv1.bias"),
        ({"conv1.bias": torch.tensor([0, float("inf"), 0])}, "not finite, in conv1.bias"),
    ],
)
def test_other_tensors_are_named(path, change, message):
    state = {name: value for name, value in (small_state() | change).items() if value is not None}
    torch.save(state, path)
    refused(path, message=message)


@pytest.mark.parametrize("kind", ["filling", "mass"])
def test_each_tensor_of_a_network_is_needed(tmp_path, kind):
    path = tmp_path / "weights.pt"
    for name in list(SHAPES[kind])[::9]:
        state = random_state(kind)
        del state[name]
        torch.save(state, path)
        refused(path, message=f"lacks {name}; name", read=READ[kind])


class Hidden:
    """Makes a folder when it is unpickled."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self._folder),)


@pytest.mark.parametrize("wrapped", [lambda hidden: {"conv1.bias": hidden}, lambda hidden: hidden])
def test_hidden_code_is_not_run(path, tmp_path, wrapped):
    trace = tmp_path / "made by the file"
    torch.save(wrapped(Hidden(trace)), path)
    refused(path, message=r"names '(posix|nt)\.mkdir', may hold a program and was not opened; name the authors' task4")
    assert not trace.exists()


def test_a_whole_module_instead_of_its_state_is_refused(path):
    torch.save(torch.nn.Linear(2, 2), path)
    refused(path, message="may hold a program and was not opened")


@pytest.mark.parametrize("content", [3, [torch.zeros(2)], torch.zeros(2)])
def test_what_is_no_state_dict_lacks_everything(path, content):
    torch.save(content, path)
    refused(path, message="lacks conv1.weight and 1 more")


def rewritten(path, change):
    """The archive with the bytes of each entry changed."""
    with zipfile.ZipFile(path) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, change(name, content))


def test_a_bomb_is_not_unpacked(path):
    torch.save(small_state(), path)
    rewritten(path, lambda name, content: bytes(BYTES_MAX) if name.endswith("/data/0") else content)
    assert path.stat().st_size < 100_000
    refused(path, message="unpacks to more than 32 MB and was not opened")


def test_a_tensor_that_claims_to_be_larger_than_the_file_is_refused(path):
    torch.save({"conv1.weight": torch.zeros(200)}, path)
    claimed = {"K\xc8".encode("latin1"): b"J\x00\xca\x9a\x3b"}  # 200, one billion
    rewritten(path, lambda name, content: content.replace(*claimed.popitem()) if name.endswith("data.pkl") else content)
    refused(path, message="is incomplete or damaged")


def test_a_tensor_that_repeats_a_number_without_end_is_refused_by_its_shape(path):
    torch.save({"conv1.weight": torch.zeros(1).expand(10**12), "conv1.bias": torch.zeros(3)}, path)
    refused(path, message=r"has conv1.weight of \(1000000000000,\)")


@pytest.mark.parametrize("protocol", [0, 4])
def test_pickles_in_other_protocols_are_refused(path, protocol):
    torch.save(small_state(), path)
    listing = pickle.dumps({"conv1.bias": [0] * 30_000}, protocol)
    rewritten(path, lambda name, content: listing if name.endswith("data.pkl") else content)
    refused(path, message="is incomplete or damaged")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"PK\x03\x04" + bytes(500), b"no archive"])
def test_what_is_no_archive_is_refused(path, content):
    path.write_bytes(content)
    refused(path, message="is incomplete or damaged")
