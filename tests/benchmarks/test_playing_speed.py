"""From opening an uninspected recording to its best frame, in a real browser whose time line plays all the while.

The bare cost is the forward passes of the frames that were inspected, see ``test_detection_speed``.
"""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, sync_playwright
from pytest_benchmark.fixture import BenchmarkFixture

from corsmal.dataset import open_dataset
from corsmal.demo.opening import PACK
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from tests.benchmarks.test_detection_speed import Passes
from tests.benchmarks.test_start_speed import ROOT, TIMEOUT_S, served
from tests.browser.conftest import CHROMIUM_FLAGS

FIRST, *MEASURED = "000000", "000003", "000005", "000009"
"""The first is searched before, which starts the processes."""
PLAYS = """() => setInterval(() => document.querySelector(".time-line-button[aria-label=Play]")?.click(), 100)"""
IS_SEARCHING = "() => document.querySelector('[data-testid=stMain] [data-testid=stProgress]') !== null"
HAS_ENDED = """() => /Best/.test(document.querySelector(".time-line-controls")?.textContent)
  && !document.querySelector("[data-testid=stMain] [data-testid=stProgress]")"""

pytestmark = pytest.mark.benchmark(group="best frame while the time line plays")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The ready-made demo's recordings without its results, beside a store."""
    folder = tmp_path_factory.mktemp("uninspected")
    shutil.copytree(PACK / "recordings", folder / "demo")
    return folder


@pytest.fixture(scope="module")
def page(folder: Path) -> Iterator[Page]:
    """The *Frames* page in a browser, playing."""
    executable = shutil.which("chromium")
    if executable is None:
        pytest.skip("no program named chromium on PATH; on Debian: apt-get install chromium")
    app = served(ROOT, "--data", str(folder / "demo"), cache=folder / "cache")
    with app as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=CHROMIUM_FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(1000 * TIMEOUT_S)
        page.goto(f"{address}/frames?recording={FIRST}")
        page.wait_for_function(HAS_ENDED)
        page.evaluate(PLAYS)
        yield page
        browser.close()


def skip_unmeasured(benchmark: BenchmarkFixture) -> None:
    """The browser takes a minute, and its journey is tested elsewhere."""
    if not benchmark.enabled:
        benchmark(int)  # else the plugin warns that its fixture was not used
        pytest.skip("nothing is measured")


def opened_until_found(page: Page) -> None:
    """Step to one recording after the other, which nobody inspected, and wait until each search has ended."""
    for _ in MEASURED:
        page.get_by_role("button", name="Next", exact=True).click()
        page.wait_for_function(IS_SEARCHING)
        page.wait_for_function(HAS_ENDED)


@pytest.mark.goal(ratio=1.5)
@pytest.mark.long
def test_open_to_best_frame_while_the_time_line_plays(
    benchmark: BenchmarkFixture, request: pytest.FixtureRequest
) -> None:
    skip_unmeasured(benchmark)
    benchmark.pedantic(opened_until_found, args=(request.getfixturevalue("page"),), rounds=1)


@pytest.mark.long
def test_bare_forward_passes(benchmark: BenchmarkFixture, request: pytest.FixtureRequest, folder: Path) -> None:
    skip_unmeasured(benchmark)
    request.getfixturevalue("page").goto("about:blank")  # it has searched all of them, and plays no longer
    dataset, store = open_dataset(folder / "demo"), Store(folder / "cache")
    inspected = {
        name: {view: found.frames for view, found in load_detections(dataset[name], store=store).views.items()}
        for name in MEASURED
    }
    passes = Passes(folder / "demo", inspected)
    benchmark.pedantic(passes, rounds=1)
    passes.close()
