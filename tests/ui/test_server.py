import asyncio
import sys
import time
from pathlib import Path

import pytest
from streamlit.web.server.app_discovery import discover_asgi_app

from corsmal.ui import server, shared

APP = Path(__file__).resolve().parents[2] / "app.py"


@pytest.fixture(autouse=True)
def fresh(tmp_path, monkeypatch):
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("CORSMAL_DATA", raising=False)
    monkeypatch.setattr(sys, "argv", ["app.py"])
    monkeypatch.setattr(server, "PAGES_AFTER_S", 1e6)
    monkeypatch.setattr(server, "FITS_AFTER_S", 1e6)
    monkeypatch.setattr(server, "NETWORKS_AFTER_S", 1e6)
    before = sys.getswitchinterval()
    yield
    sys.setswitchinterval(before)


def test_streamlit_finds_the_application():
    found = discover_asgi_app(APP)
    assert found.is_asgi_app
    assert found.app_name == "app"


def test_the_start_gives_the_routes_and_writes_nothing(tmp_path):
    paths = [route.path for route in server.start()]
    assert "/thumbnails/{dataset}/{recording}.jpg" in paths
    assert not (tmp_path / "cache").exists()


def test_after_the_start_another_process_compiles_what_a_fit_needs(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "compiled"))
    monkeypatch.setattr(server, "FITS_AFTER_S", 0.0)
    server.start()
    end_s = time.monotonic() + 120
    while not list(tmp_path.glob("compiled/**/kernels.first_fitting_radius*.nbc")):
        assert time.monotonic() < end_s, "nothing was compiled"
        time.sleep(0.1)


def test_a_visitor_is_answered_soon_while_a_thread_computes():
    async def serve():
        async with server.lifespan(None):
            assert sys.getswitchinterval() == pytest.approx(server.SWITCH_S)

    before = sys.getswitchinterval()
    server.start()
    assert sys.getswitchinterval() == before > server.SWITCH_S  # what is loaded for the start is loaded at full speed
    asyncio.run(serve())


def test_at_the_end_jobs_are_told_to_stop_and_keep_what_they_have(monkeypatch):
    kept = []

    def work(job):
        while not job.cancelled():
            time.sleep(0.01)
        kept.append(job)

    async def serve():
        async with server.lifespan(None):
            await asyncio.sleep(0.1)
            assert kept == []

    shared.jobs.cache_clear()
    job = shared.jobs().start("key", "label", work)
    asyncio.run(serve())
    assert kept == [job]
    monkeypatch.delitem(sys.modules, "corsmal.ui.shared")
    asyncio.run(serve_nothing())


async def serve_nothing():
    async with server.lifespan(None):
        pass
    assert "corsmal.ui.shared" not in sys.modules
