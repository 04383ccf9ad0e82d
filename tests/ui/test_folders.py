"""Which folders a server for visitors opens."""

import sys
from pathlib import Path

import pytest
from streamlit import config

from corsmal.ui.folders import (
    REFUSED,
    RefusedError,
    allowed_folder,
    check_may_change,
    data_root,
    default_folder,
    demo_folder,
    full_demo_folder,
)


@pytest.fixture(autouse=True)
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    for name in ("CORSMAL_DATA", "CORSMAL_DATA_ROOT", "CORSMAL_READ_ONLY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "argv", ["app.py"])


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A data root with a dataset in it, one beside it, and links between them."""
    for folder in ("data/ccm/train", "secret/train", "data2"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "data" / "within").symlink_to(tmp_path / "data" / "ccm")
    (tmp_path / "data" / "outside").symlink_to(tmp_path / "secret")
    (tmp_path / "data" / "circle").symlink_to(tmp_path / "data" / "circle")
    monkeypatch.setattr(sys, "argv", ["app.py", "--data-root", str(tmp_path / "data")])
    return tmp_path / "data"


@pytest.mark.parametrize("name", ["ccm/train", "./ccm/../ccm/train", "within/train"])
def test_folders_in_the_data_root_are_opened_by_their_names_there(root: Path, name: str) -> None:
    assert allowed_folder(name) == str(root / "ccm" / "train")
    assert allowed_folder(str(root / name)) == str(root / "ccm" / "train")


def test_nothing_is_learnt_of_other_folders(root: Path) -> None:
    there = [
        "/",
        "/etc",
        "..",
        "../secret",
        "../secret/train",
        "outside",
        "outside/train",
        "../data2",
        str(root.parent),
    ]
    absent = ["/etc/none", "../none", "outside/none", "~", "~root", "~nobody-of-this-name/x", "ccm/../../secret/none"]
    unreadable = ["circle/x", "a\0b", "../" * 40 + "etc", "x" * 5000 + "/../../../etc"]
    for text in (*there, *absent, *unreadable):
        if text.startswith("~"):  # a name in the root, of nothing that is there
            assert Path(allowed_folder(text)).is_relative_to(root)
        else:
            with pytest.raises(RefusedError, match=f"^{REFUSED}$"):
                allowed_folder(text)


def test_the_demos_and_what_the_server_was_started_with_are_open(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = str(root.parent / "secret")
    monkeypatch.setattr(sys, "argv", [*sys.argv, "--data", given])
    assert default_folder() == given
    for folder in (given, str(demo_folder()), str(full_demo_folder())):
        assert allowed_folder(folder) == folder
    with pytest.raises(RefusedError):
        allowed_folder(f"{given}/train")


def test_without_a_data_root_every_folder_may_be_named() -> None:
    assert data_root() is None
    assert allowed_folder("../x") == "../x"


@pytest.mark.parametrize("address", ["0.0.0.0", "::", "192.0.2.7", None])
def test_a_server_that_others_reach_opens_only_what_it_was_started_with(
    root: Path, monkeypatch: pytest.MonkeyPatch, address: str | None
) -> None:
    monkeypatch.setattr(config, "get_option", {"server.address": address}.get)
    monkeypatch.setattr(sys, "argv", ["app.py", "--data", str(root)])
    assert data_root() == root
    for text in (str(root), str(root / "ccm" / "train"), "within/train"):
        assert Path(allowed_folder(text)).resolve().is_relative_to(root)
    for text in ("..", "/etc", "/etc/none", str(root.parent / "secret"), "outside/train", "circle/x"):
        with pytest.raises(RefusedError, match=f"^{REFUSED}$"):
            allowed_folder(text)
    monkeypatch.setattr(sys, "argv", ["app.py"])
    assert allowed_folder(str(demo_folder())) == str(demo_folder())
    with pytest.raises(RefusedError):
        allowed_folder(str(root))


def test_options_come_from_the_command_line_or_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    check_may_change()
    monkeypatch.setenv("CORSMAL_READ_ONLY", "0")
    check_may_change()
    monkeypatch.setenv("CORSMAL_DATA_ROOT", "/srv")
    monkeypatch.setenv("CORSMAL_READ_ONLY", "1")
    assert data_root() == Path("/srv")
    with pytest.raises(RefusedError, match="read-only"):
        check_may_change()
    monkeypatch.delenv("CORSMAL_READ_ONLY")
    monkeypatch.setattr(sys, "argv", ["app.py", "--read-only"])
    with pytest.raises(RefusedError, match="read-only"):
        check_may_change()
