import hashlib

import pytest

from corsmal.detection import weights
from corsmal.errors import FileError

CONTENT = b"some weights" * 200_000


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A folder that stands for torchvision's server, holding one file named after its content."""
    folder = tmp_path / "server"
    folder.mkdir()
    file = folder / f"network-{hashlib.sha256(CONTENT).hexdigest()[:8]}.pth"
    file.write_bytes(CONTENT)
    monkeypatch.setattr(weights, "COCO_WEIGHTS_URL", file.as_uri())
    return file


def test_weights_are_downloaded_once_with_progress(tmp_path, server):
    done = []
    path = weights.coco_weights(tmp_path / "here", progress=done.append)
    assert path.read_bytes() == CONTENT
    assert path.name == server.name
    assert done == sorted(done)
    assert done[-1] == 1
    server.unlink()
    assert weights.coco_weights(tmp_path / "here") == path
    assert list(path.parent.iterdir()) == [path]


def test_a_download_that_arrives_damaged_is_not_kept(tmp_path, server):
    server.write_bytes(CONTENT[:-1])
    with pytest.raises(FileError, match="arrived damaged"):
        weights.coco_weights(tmp_path / "here")
    assert list((tmp_path / "here").iterdir()) == []


def test_offline_the_error_says_which_file_to_put_where(tmp_path, server):
    server.unlink()
    with pytest.raises(FileError) as caught:
        weights.coco_weights(tmp_path / "here")
    assert caught.value.path == tmp_path / "here" / server.name
    assert f"download {server.as_uri()} and put it there" in caught.value.problem


def test_a_folder_that_cannot_be_made_is_an_error(server):
    with pytest.raises(FileError, match="cannot be fetched"):
        weights.coco_weights(server / "below-a-file")


def test_a_progress_call_that_raises_leaves_nothing_behind(tmp_path, server):
    def stop(_):
        raise InterruptedError

    with pytest.raises(FileError):
        weights.coco_weights(tmp_path / "here", progress=stop)
    assert list((tmp_path / "here").iterdir()) == []
    assert server.exists()
