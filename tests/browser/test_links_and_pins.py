"""Two visitors of a group's server: links that show each what the other saw, and pins that do not mix."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from corsmal.dataset import open_dataset

pytestmark = pytest.mark.browser

HULL = "Hull, circumferences and cameras in 3D"
EYE = "node => { const { x, y, z } = node._fullLayout.scene._scene.getCamera().eye; return [x, y, z]; }"
HOSTILE = '<img src=x onerror="document.title=1"> =1+1 $a$ *b*'


@pytest.fixture
def root(tiny_dataset_root: Path, tmp_path: Path) -> Path:
    """A data folder with two datasets whose recordings have the same numbers."""
    for name in ("one", "two"):
        shutil.copytree(tiny_dataset_root, tmp_path / "data" / name)
    next((tmp_path / "data" / "two").glob("*annotation*")).unlink()
    return tmp_path / "data"


@pytest.fixture
def address(serve: Any, root: Path, tmp_path: Path) -> str:
    """The README's server for a group, without the web server in front of it."""
    environment = {"CORSMAL_CACHE": str(tmp_path / "cache"), "CORSMAL_DATA": ""}
    arguments = ("--data-root", str(root), "--data", str(root / "one"))
    address: str = serve("app.py", *arguments, env=environment, base_path="group/corsmal")
    return address


@pytest.fixture
def visitors(chromium: Browser) -> Iterator[tuple[Page, Page]]:
    """Two browsers; the test fails if a script on a page raised."""
    problems: list[str] = []
    pages = []
    for _ in range(2):
        context = chromium.new_context(
            viewport={"width": 1400, "height": 1100}, permissions=["clipboard-read", "clipboard-write"]
        )
        pages.append(context.new_page())
        pages[-1].on("pageerror", lambda error: problems.append(str(error)))
    yield pages[0], pages[1]
    for page in pages:
        page.context.close()
    assert problems == []


def hull(page: Page) -> Locator:
    figure = page.get_by_role("group", name=HULL).locator(".linked-plot-figure")
    expect(figure.locator(".main-svg").first).to_be_visible(timeout=120_000)
    return figure


def open_tray(page: Page, count: int) -> Locator:
    """The pins in the tray of a page, once there are so many."""
    page.get_by_role("button", name=f"Pins ({count})").click()
    pins = page.locator(".pin-list-pin")
    expect(pins).to_have_count(count)
    return pins


def titles(pins: Locator) -> list[str]:
    return [re.sub(r"^(Hull of )?000000, | \+.*|, frame.*", "", text) for text in pins.locator("a").all_inner_texts()]


def copied_link(page: Page) -> str:
    page.get_by_role("button", name="Copy link").click()
    expect(page.get_by_role("button", name="Link copied")).to_be_visible()
    return str(page.evaluate("navigator.clipboard.readText()"))


def open_folder(page: Page, name: str) -> None:
    folder = page.get_by_role("textbox", name="Dataset folder")
    folder.fill(name)
    folder.press("Enter")


def order_by_dragging_and_keys(page: Page, pins: Locator) -> None:
    """The last pin to the top with the mouse, then the one in the middle to the end with a key."""
    handles = page.locator(".pin-list-handle")
    start, end = handles.nth(2).bounding_box(), handles.nth(0).bounding_box()
    assert start is not None
    assert end is not None
    page.mouse.move(start["x"] + 5, start["y"] + 5)
    page.mouse.down()
    page.mouse.move(end["x"] + 5, end["y"] - 4, steps=6)
    page.mouse.up()
    assert titles(pins) == ["view1", "view3", "view3"]
    handles.nth(1).press("ArrowDown")
    expect(handles.nth(2)).to_be_focused()


def see_the_same_by_a_link(address: str, fingerprint: str, first: Page, second: Page) -> None:
    """An old address of the first visitor becomes a link that the second opens, who was looking at another dataset."""
    first.goto(f"{address}/shape?recording=000000&frame=2&L=60")
    start = hull(first).evaluate(EYE)
    assert re.search(rf"/group/corsmal/hull\?dataset=one-{fingerprint}&recording=000000&frame=2&L=60$", first.url)
    hull(first).locator(".updatemenu-button", has_text="Side").click()
    first.wait_for_url(re.compile("[?&]camera="))
    link = copied_link(first)

    second.goto(f"{address}/dataset")
    open_folder(second, "../cache")
    refusal = second.get_by_test_id("stMain").get_by_text("opens only the datasets in its own data folder")
    expect(refusal).to_be_visible()
    open_folder(second, "two")
    second.wait_for_url(re.compile("[?&]dataset=two-"))
    second.goto(link)
    assert hull(second).evaluate(EYE) == pytest.approx(hull(first).evaluate(EYE), abs=0.002)
    expect(second.get_by_role("slider", name="L, circumferences")).to_have_value("60")
    assert second.url == link
    first.go_back()
    turned_back = f"([node, x]) => Math.abs(({EYE})(node)[0] - x) < 0.01"
    first.wait_for_function(turned_back, arg=[hull(first).element_handle(), start[0]])


def test_two_visitors_share_links_and_keep_their_pins(address: str, root: Path, visitors: tuple[Page, Page]) -> None:
    first, second = visitors
    see_the_same_by_a_link(address, open_dataset(root / "one").fingerprint, first, second)

    first.get_by_role("button", name="Pin the hull").click()
    expect(first.get_by_text(re.compile("^Pinned: Hull")).first).to_be_visible()
    first.get_by_test_id("stSidebar").get_by_role("link", name="Frames").click()
    first.get_by_role("button", name="Pin the pictures").click()
    pins = open_tray(first, 3)
    assert titles(pins) == ["view3", "view3", "view1"]
    order_by_dragging_and_keys(first, pins)
    pins.nth(0).get_by_role("textbox").fill(HOSTILE)
    pins.nth(0).get_by_role("textbox").press("Tab")
    pins.nth(1).get_by_role("button", name=re.compile("^Remove")).click()
    expect(pins).to_have_count(2)
    first.locator(".pin-list-undo").get_by_role("button", name="Undo").click()
    expect(pins).to_have_count(3)
    first.get_by_role("textbox", name="Name this collection").fill("meeting")
    first.get_by_role("textbox", name="Name this collection").press("Enter")
    first.wait_for_url(re.compile("[?&]pins=meeting"))

    expect(second.get_by_role("button", name="Pins (0)")).to_be_visible()
    second.get_by_role("button", name="Pin the hull").click()
    second.wait_for_url(re.compile("[?&]pins=pins-"))
    open_tray(second, 1)

    with first.expect_navigation():
        pins.nth(2).get_by_role("link").click()  # to the page where it was pinned, a new session
    pins = open_tray(first, 3)
    assert pins.locator("a").all_inner_texts()[2].startswith("Hull of 000000")
    expect(pins.nth(0).get_by_role("textbox")).to_have_value(HOSTILE)
    assert first.title() != "1"
    hull(first)
