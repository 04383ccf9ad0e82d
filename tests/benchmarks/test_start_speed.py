"""From the command to a healthy server and to every number of the first page, without a cache, beside a bare app."""

import os
import shutil
import socket
import statistics
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from playwright.sync_api import Page, sync_playwright
from pytest_benchmark.fixture import BenchmarkFixture

from tests.benchmarks.conftest import MEASURED, Goal, Measured
from tests.browser.conftest import CHROMIUM_FLAGS

ROOT = Path(__file__).resolve().parents[2]
STARTS = 5
TIMEOUT_S = 300
BARE_APP = 'import streamlit as st\n\nst.title("Bare")\nst.metric("Capacity", "520 mL")\n'
GOALS = {"until the server is healthy": 1.3, "until every number is there": 1.8, "until the page is there again": 2}
"""What is measured, and how many times as long as the bare app it may take."""
NUMBERS = {"bare app": 1, "app": 8}
"""How many numbers stand on the first page: of the app, those of the *Overview*."""
EVERY_NUMBER = """count => {
    const values = document.querySelectorAll("[data-testid=stMetricValue], .tile-value");
    const texts = [...values].map(value => value.textContent);
    return texts.length >= count && texts.every(text => !text.includes("…"));
}"""


def bare_clone(folder: Path) -> Path:
    folder.mkdir()
    (folder / "app.py").write_text(BARE_APP, encoding="utf-8")
    return folder


def fresh_clone(folder: Path) -> Path:
    """The repository's files as they are after a clone: nothing compiled, nothing cached."""
    leave_out = shutil.ignore_patterns("__pycache__", ".*", "cache", "tests")
    shutil.copytree(ROOT, folder, ignore=leave_out)
    shutil.copytree(ROOT / ".streamlit", folder / ".streamlit")
    return folder


@contextmanager
def served(folder: Path, *args: str, cache: Path) -> Iterator[str]:
    """The address of an app that is started from its folder; yielded when the server is healthy."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "streamlit", "run", "app.py", "--server.port", str(port)]
    command += ["--server.headless", "true", "--browser.gatherUsageStats", "false", "--server.fileWatcherType", "none"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("CORSMAL", "PYTHONPATH"))}
    environment["CORSMAL_CACHE"] = str(cache)
    silent = subprocess.DEVNULL
    server = subprocess.Popen([*command, "--", *args], cwd=folder, env=environment, stdout=silent, stderr=silent)
    try:
        address = f"http://127.0.0.1:{port}"
        wait_for(lambda: urllib.request.urlopen(f"{address}/_stcore/health", timeout=5))
        yield address
    finally:
        server.terminate()
        server.wait(timeout=TIMEOUT_S)


def started(clone: Path, page: Page, *, numbers: int) -> tuple[float, float, float]:
    """Seconds from the command until the server is healthy, and until all numbers of its first page are there.

    The third are those of loading the page again.
    """

    def load() -> None:
        page.goto(address)
        page.wait_for_function(EVERY_NUMBER, arg=numbers, timeout=1000 * TIMEOUT_S)

    began_s = time.perf_counter()
    with served(clone, cache=clone / "empty cache") as address:
        healthy_s = time.perf_counter() - began_s
        load()
        first_s = time.perf_counter() - began_s
        load()
        return healthy_s, first_s, time.perf_counter() - began_s - first_s


def wait_for(attempt: Callable[[], object]) -> None:
    end_s = time.monotonic() + TIMEOUT_S
    while time.monotonic() < end_s:
        with suppress(OSError):
            attempt()
            return
        time.sleep(0.02)
    pytest.fail("the server did not start")


@pytest.mark.long
def test_starts(benchmark: BenchmarkFixture, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    executable = shutil.which("chromium")
    if executable is None:
        pytest.skip("no program named chromium on PATH; on Debian: apt-get install chromium")
    clones = {"bare app": bare_clone, "app": fresh_clone} if benchmark.enabled else {"app": fresh_clone}
    times: dict[str, list[tuple[float, float, float]]] = {name: [] for name in clones}

    def take_turns() -> None:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=executable, args=CHROMIUM_FLAGS)
            for number in range(STARTS if benchmark.enabled else 1):
                for name, clone in clones.items():
                    context = browser.new_context(viewport={"width": 1440, "height": 900})
                    folder = clone(tmp_path / f"{name} {number}")
                    times[name].append(started(folder, context.new_page(), numbers=NUMBERS[name]))
                    context.close()
            browser.close()

    benchmark.pedantic(take_turns, rounds=1)
    measured = request.config.stash.setdefault(MEASURED, [])
    for index, (group, most) in enumerate(GOALS.items()):
        for name, found in times.items():
            seconds = [each[index] for each in found]
            measured.append(Measured(f"{name} {group}", group, None, statistics.median(seconds), Goal(ratio=most)))
            sys.stderr.write(f"\n{name} {group}: {' '.join(f'{value:.2f}' for value in seconds)} s\n")
