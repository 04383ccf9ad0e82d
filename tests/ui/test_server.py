import importlib
import sys
from pathlib import Path

import pytest
from streamlit.web.server.app_discovery import discover_asgi_app

from corsmal.ui import demo, server
from corsmal.ui.folders import demo_folder

APP = Path(__file__).resolve().parents[2] / "app.py"


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """What the start of a server begins: the processes' folder and the demo's processes."""
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path))
    monkeypatch.delenv("CORSMAL_DATA", raising=False)
    monkeypatch.setattr(sys, "argv", ["app.py"])
    calls = []
    monkeypatch.setattr(server, "start_processes", lambda folder: calls.append(folder) or "processes")
    monkeypatch.setattr(demo, "begin", calls.append)
    monkeypatch.setattr(server, "LIBRARIES_AFTER_S", 1e6)
    return calls


def test_streamlit_finds_the_application():
    found = discover_asgi_app(APP)
    assert found.is_asgi_app
    assert found.app_name == "app"


def test_a_demo_that_is_not_there_is_begun_before_the_first_visitor(begun):
    paths = [route.path for route in server.start()]
    assert begun == [demo_folder(), "processes"]
    assert "/thumbnails/{dataset}/{recording}.jpg" in paths


def test_nothing_is_begun_where_the_demo_is_or_another_folder_is_named(begun, monkeypatch, tmp_path):
    monkeypatch.setenv("CORSMAL_DATA", str(tmp_path))
    server.start()
    monkeypatch.delenv("CORSMAL_DATA")
    (demo_folder()).mkdir(parents=True)
    (demo_folder() / importlib.import_module("corsmal.synthetic").ANNOTATION_FILE).write_text("{}")
    server.start()
    assert begun == []
