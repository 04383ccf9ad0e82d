import hashlib
from pathlib import Path

import pytest
import torch

from corsmal.detection import coco_weights
from corsmal.errors import FileError

CONTENT = b"some weights" * 200_000


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A folder that stands for torchvision's server, holding one file named after its content."""
    folder = tmp_path / "server"
    folder.mkdir()
    file = folder / f"network-{hashlib.sha256(CONTENT).hexdigest()[:8]}.pth"
    file.write_bytes(CONTENT)
    monkeypatch.setattr(coco_weights, "COCO_WEIGHTS_URL", file.as_uri())
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(tmp_path / "here"))
    return file


def test_weights_are_downloaded_once(tmp_path, server):
    path = coco_weights.coco_weights()
    assert path.read_bytes() == CONTENT
    assert path == tmp_path / "here" / server.name
    server.unlink()
    assert coco_weights.coco_weights() == path
    assert list(path.parent.iterdir()) == [path]


def test_a_download_that_arrives_damaged_is_not_kept(tmp_path, server):
    server.write_bytes(CONTENT[:-1])
    with pytest.raises(FileError, match="arrived damaged"):
        coco_weights.coco_weights()
    assert list((tmp_path / "here").iterdir()) == []


def test_offline_the_error_says_which_file_to_put_where(tmp_path, server):
    server.unlink()
    with pytest.raises(FileError) as caught:
        coco_weights.coco_weights()
    assert caught.value.path == tmp_path / "here" / server.name
    assert f"download {server.as_uri()} and put it there" in caught.value.problem


def test_a_folder_that_cannot_be_made_is_an_error(server, monkeypatch):
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(server / "below-a-file"))
    with pytest.raises(FileError, match="set CORSMAL_WEIGHTS to another folder"):
        coco_weights.coco_weights()


def test_the_file_is_looked_for_where_pytorch_keeps_its_own(tmp_path, monkeypatch):
    monkeypatch.delenv("CORSMAL_WEIGHTS", raising=False)
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    path = coco_weights.coco_weights_file()
    assert path.parent == Path(torch.hub.get_dir(), "checkpoints")
    monkeypatch.delenv("TORCH_HOME")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "of-user"))
    assert coco_weights.coco_weights_file().parent == Path(torch.hub.get_dir(), "checkpoints")
