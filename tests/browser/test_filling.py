"""The Filling page in a real browser: the handles of the crop, and the sound."""

import re
from typing import Any

import pytest
import torch
from playwright.sync_api import Locator, Page, expect

from corsmal.filling import FillingConfig, FillingModel, save_filling
from tests.tiny import write_audio, write_tiny_dataset

pytestmark = pytest.mark.browser

TOTAL_S = 3.0
SHARE = "node => node._fullData[0].x[0]"
"""The first bar: the probability of no filling."""

FIRST_VISIT_MS = 120_000
"""The first visitor waits until PyTorch is loaded."""


@pytest.fixture(scope="module")
def address(serve: Any, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("filling")
    root = write_tiny_dataset(folder / "train", recordings=1, frames=6)
    write_audio(root / "audio" / "000000.wav", seconds=TOTAL_S)
    weights = folder / "filling.safetensors"
    torch.manual_seed(2)
    save_filling(weights, [FillingModel(FillingConfig(heads=2, blocks=1, hidden=16, head_hidden=8)).eval()])
    environment = {"CORSMAL_CACHE": str(folder / "cache"), "CORSMAL_FILLING_WEIGHTS": str(weights)}
    return serve("app.py", "--data", str(root), env=environment)


@pytest.fixture
def page(browser_page: Page, address: str) -> Page:
    browser_page.set_viewport_size({"width": 1400, "height": 1100})
    browser_page.goto(f"{address}/sound")
    expect(timeline(browser_page).locator(".main-svg").first).to_be_visible(timeout=FIRST_VISIT_MS)
    return browser_page


def timeline(page: Page) -> Locator:
    return page.get_by_role("group", name="Sound of recording 000000").locator(".linked-plot-figure")


def bars(page: Page) -> Locator:
    return page.get_by_role("group", name="logits of the type").locator(".linked-plot-figure")


def test_dragging_a_handle_changes_the_answer_and_the_address_follows(page: Page) -> None:
    handle = page.get_by_role("slider", name="Start of the crop")
    expect(handle).to_have_attribute("aria-valuenow", "0")
    before = bars(page).evaluate(SHARE)
    box = handle.bounding_box()
    width = timeline(page).evaluate("node => node._fullLayout.xaxis.d2p(1) - node._fullLayout.xaxis.d2p(0)")
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + width, y, steps=8)
    page.wait_for_function(f"([node, before]) => ({SHARE})(node) !== before", arg=[bars(page).element_handle(), before])
    # the button is still down
    assert "crop" not in page.url
    page.mouse.up()
    expect(handle).to_have_attribute("aria-valuenow", "1")
    page.wait_for_url(re.compile(r"[?&]crop=1\.00-3\.00\b"))
    expect(page.get_by_test_id("stAudio")).to_be_visible()
    page.go_back()
    expect(handle).to_have_attribute("aria-valuenow", "0")


def test_handles_are_moved_by_keys_and_the_bar_moves_both(page: Page) -> None:
    start, end = (page.get_by_role("slider", name=f"{name} of the crop") for name in ("Start", "End"))
    start.press("PageUp")
    expect(start).to_have_attribute("aria-valuenow", "0.5")
    end.press("PageDown")
    page.wait_for_url(re.compile(r"[?&]crop=0\.50-2\.50\b"))
    bar = page.get_by_title("Drag to move the whole stretch").bounding_box()
    assert bar is not None
    x, y = bar["x"] + bar["width"] / 2, bar["y"] + bar["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + bar["width"], y, steps=4)
    page.mouse.up()
    page.wait_for_url(re.compile(r"[?&]crop=1\.00-3\.00\b"))
    expect(start).to_have_attribute("aria-valuenow", "1")
    expect(end).to_have_attribute("aria-valuenow", "3")
