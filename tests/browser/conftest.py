"""Starts Streamlit scripts on a free port and opens them in a headless Chromium."""

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
CHROMIUM_FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--no-first-run",
    "--disable-component-update",
    "--disable-sync",
]
START_TIMEOUT_S = 60
STEP_TIMEOUT_MS = 30_000

Serve = Callable[..., str]


@pytest.fixture(scope="session")
def serve(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Serve]:
    """``serve(script, *args, env=None, base_path="")`` runs a script as the user would and returns its address."""
    servers: list[subprocess.Popen[bytes]] = []

    def start(script: str | Path, *args: str, env: dict[str, str] | None = None, base_path: str = "") -> str:
        port = _free_port()
        log_path = tmp_path_factory.mktemp("streamlit") / "server.log"
        command = [sys.executable, "-m", "streamlit", "run", str(script)]
        command += ["--server.port", str(port), "--server.address", "127.0.0.1", "--server.headless", "true"]
        command += ["--server.fileWatcherType", "none", "--browser.gatherUsageStats", "false"]
        command += ["--server.baseUrlPath", base_path, "--", *args]
        environment = os.environ | {"PYTHONPATH": str(ROOT)} | (env or {})
        with log_path.open("wb") as log:
            server = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=log, stderr=subprocess.STDOUT)
        servers.append(server)
        address = f"http://127.0.0.1:{port}/{base_path}".rstrip("/")
        _wait_until_healthy(server, address, log_path)
        return address

    yield start
    for server in servers:
        server.terminate()
        server.wait(timeout=START_TIMEOUT_S)


@pytest.fixture(scope="module")  # not of the session: while it lives, no other test can run an event loop
def chromium() -> Iterator[Browser]:
    executable = shutil.which("chromium")
    if executable is None:
        pytest.skip("no program named chromium on PATH; on Debian: apt-get install chromium")
    expect.set_options(timeout=STEP_TIMEOUT_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=CHROMIUM_FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def browser_page(chromium: Browser) -> Iterator[Page]:
    """A fresh page of its own context; the test fails if a script on the page raised."""
    context = chromium.new_context(viewport={"width": 1200, "height": 1000})
    context.set_default_timeout(STEP_TIMEOUT_MS)
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    yield page
    context.close()
    assert problems == []


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _wait_until_healthy(server: subprocess.Popen[bytes], address: str, log_path: Path) -> None:
    deadline = time.monotonic() + START_TIMEOUT_S
    while server.poll() is None and time.monotonic() < deadline:
        with suppress(OSError), urllib.request.urlopen(f"{address}/_stcore/health", timeout=5):
            return
        time.sleep(0.1)
    pytest.fail(f"the app did not start:\n{log_path.read_text(errors='replace')}")
