import sys
from pathlib import Path

import pytest
from streamlit.web.server.app_discovery import discover_asgi_app

from corsmal.ui import server

APP = Path(__file__).resolve().parents[2] / "app.py"


@pytest.fixture(autouse=True)
def fresh(tmp_path, monkeypatch):
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("CORSMAL_DATA", raising=False)
    monkeypatch.setattr(sys, "argv", ["app.py"])
    monkeypatch.setattr(server, "PAGES_AFTER_S", 1e6)
    monkeypatch.setattr(server, "NETWORKS_AFTER_S", 1e6)


def test_streamlit_finds_the_application():
    found = discover_asgi_app(APP)
    assert found.is_asgi_app
    assert found.app_name == "app"


def test_the_start_gives_the_routes_and_writes_nothing(tmp_path):
    paths = [route.path for route in server.start()]
    assert "/thumbnails/{dataset}/{recording}.jpg" in paths
    assert not (tmp_path / "cache").exists()
