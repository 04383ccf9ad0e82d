"""Masks by hand in a real browser: each tool with mouse, keys and fingers, and what is there after a reload."""

import re
import time
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from corsmal.by_hand import MaskHistory
from corsmal.dataset import open_dataset
from corsmal.store import Store
from tests.browser.conftest import STEP_TIMEOUT_MS
from tests.tiny import CONTAINERS, base_in_frame, silhouette, tiny_cameras, write_tiny_dataset

pytestmark = pytest.mark.browser

NAME, FRAME, VIEW = "000000", 1, "view3"
STILL = 4
"""So many looks in a row must find the picture in one place."""


@pytest.fixture(scope="module")
def place(serve: Any, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("mask_editor")
    root = write_tiny_dataset(folder / "train", recordings=1, frames=4)
    environment = {"CORSMAL_CACHE": str(folder / "cache"), "CORSMAL_DATA": ""}
    address = serve("app.py", "--data", str(root), env=environment)
    guests = serve("app.py", "--data", str(root), "--read-only", env=environment)
    view = open_dataset(root)[NAME].views[VIEW]
    return {"address": address, "guests": guests, "masks": MaskHistory(NAME, view, store=Store(folder / "cache"))}


@pytest.fixture
def page(browser_page: Page, place: dict[str, Any]) -> Page:
    masks = place["masks"]
    masks.remove(FRAME, after=masks.frame(FRAME).version)  # what another test drew
    return opened(browser_page, place["address"])


def opened(page: Page, address: str) -> Page:
    page.set_viewport_size({"width": 1400, "height": 1000})
    page.goto(f"{address}/best-frame?recording={NAME}&frame={FRAME}&edit={VIEW}")
    expect(canvas(page)).to_be_visible()
    expect(page.locator(".mask-editor-other:visible canvas").first).to_be_visible()
    expect(page.get_by_test_id("stApp")).to_have_attribute("data-test-script-state", "notRunning")
    canvas(page).scroll_into_view_if_needed()
    page.keyboard.press("0")  # the whole picture
    places: list[Any] = [None]
    while len(places) < STILL or len({str(place) for place in places[-STILL:]}) > 1:  # pictures that come move it
        page.wait_for_timeout(150)
        places.append((canvas(page).bounding_box(), canvas(page).get_attribute("data-shown")))
    return page


def canvas(page: Page) -> Locator:
    return page.locator(".mask-editor-canvas")


def at(page: Page, x: float, y: float) -> tuple[float, float]:
    """Where a pixel of the picture is on the screen, as it is enlarged and moved now."""
    box, shown = canvas(page).bounding_box(), canvas(page).get_attribute("data-shown")
    assert box is not None
    zoom, left, top = map(float, (shown or "").split())
    return box["x"] + left + zoom * x, box["y"] + top + zoom * y


def drag(page: Page, *places: tuple[float, float], button: Any = "left") -> None:
    page.mouse.move(*at(page, *places[0]))
    page.mouse.down(button=button)
    for place in places[1:] or places:
        page.mouse.move(*at(page, *place), steps=4)
    page.mouse.up(button=button)


def mask_of(place: dict[str, Any], version: int) -> np.ndarray:
    """The mask once a change after a version is kept."""
    history = place["masks"].frame(FRAME)
    assert history.version > version
    assert history.mask is not None
    return np.asarray(history.mask.mask)


def done(page: Page, place: dict[str, Any], act: Any) -> np.ndarray:
    """Do something, wait until the server has kept it and the browser shows it, and read the mask."""
    version = place["masks"].frame(FRAME).version
    root = page.locator(".mask-editor")
    before = root.get_attribute("data-acknowledged")
    act()
    deadline_s = time.monotonic() + STEP_TIMEOUT_MS / 1000
    while place["masks"].frame(FRAME).version == version and time.monotonic() < deadline_s:
        page.wait_for_timeout(50)
    expect(root).not_to_have_attribute("data-acknowledged", before or "none")
    page.wait_for_timeout(100)
    return mask_of(place, version)


def cup() -> np.ndarray:
    return silhouette(tiny_cameras()[VIEW], CONTAINERS[0].profile, base_in_frame(CONTAINERS[0], FRAME))


def middle() -> tuple[float, float]:
    rows, columns = np.nonzero(cup())
    return float(columns.mean()), float(rows.mean())


def test_the_brush_draws_where_the_mouse_goes(page: Page, place: dict[str, Any]) -> None:
    drawn = done(page, place, lambda: drag(page, (100, 50), (140, 50)))
    assert drawn[50, 102:138].all()
    assert drawn[cup()].mean() > 0.95
    expect(page.locator(".mask-editor-said")).to_contain_text("by hand")
    expect(page.locator(".mask-editor-said")).to_contain_text("2 parts")
    assert int(page.locator(".mask-editor").get_attribute("data-lag-ms") or -1) >= 0


def test_the_eraser_and_its_key(page: Page, place: dict[str, Any]) -> None:
    x, y = middle()
    page.keyboard.press("e")
    page.keyboard.press("+")
    drawn = done(page, place, lambda: drag(page, (x, y)))
    assert not drawn[int(y), int(x)]
    assert 100 < cup().sum() - drawn.sum() < 700


def test_a_polygon_is_closed_by_enter_and_its_points_move(page: Page, place: dict[str, Any]) -> None:
    page.keyboard.press("p")
    for corner in ((200, 60), (300, 60), (300, 160), (200, 160)):
        drag(page, corner)
    first = done(page, place, lambda: page.keyboard.press("Enter"))
    assert abs(first.sum() - 100 * 100) < 500
    moved = done(page, place, lambda: drag(page, (300, 60), (340, 60)))
    assert moved[70, 320]
    assert not first[70, 320]
    added = done(page, place, lambda: drag(page, (250, 160), (250, 200)))  # a new point in a side
    assert added[180, 250]
    less = done(page, place, lambda: page.keyboard.press("Delete"))
    assert not less[180, 250]


def test_a_hole_is_filled(page: Page, place: dict[str, Any]) -> None:
    x, y = middle()
    page.keyboard.press("e")
    hole = done(page, place, lambda: drag(page, (x, y)))
    page.keyboard.press("f")
    filled = done(page, place, lambda: drag(page, (x, y)))
    assert not hole[int(y), int(x)]
    assert filled[int(y), int(x)]


def test_a_box_and_a_stroke_propose_a_mask(page: Page, place: dict[str, Any]) -> None:
    rows, columns = np.nonzero(cup())
    left, right, top, bottom = columns.min() - 3, columns.max() + 3, rows.min() - 3, rows.max() + 3
    page.keyboard.press("g")
    done(page, place, lambda: drag(page, (left, top), (right, bottom)))
    x, y = middle()
    drawn = done(page, place, lambda: drag(page, (x - 10, y), (x + 10, y + 10)))
    assert (drawn & cup()).sum() / (drawn | cup()).sum() > 0.7  # what is found of it is tested elsewhere


def test_undo_and_redo_by_button_and_key_also_after_a_reload(page: Page, place: dict[str, Any]) -> None:
    first = done(page, place, lambda: drag(page, (100, 50), (140, 50)))
    second = done(page, place, lambda: drag(page, (100, 90), (140, 90)))
    np.testing.assert_array_equal(done(page, place, lambda: page.keyboard.press("z")), first)
    np.testing.assert_array_equal(done(page, place, lambda: page.keyboard.press("Control+Shift+z")), second)
    opened(page, place["address"])
    undo = page.get_by_role("button", name="Undo", exact=True)
    np.testing.assert_array_equal(done(page, place, undo.click), first)
    np.testing.assert_array_equal(mask_of(place, 0), first)


def test_the_whole_outline_is_drawn_apart(page: Page, place: dict[str, Any]) -> None:
    page.keyboard.press("a")
    visible = done(page, place, lambda: drag(page, (100, 50), (140, 50)))
    assert not visible[50, 110]
    whole = place["masks"].frame(FRAME).mask.amodal_mask
    assert whole[50, 110]


def test_the_picture_is_enlarged_and_moved_without_drawing(page: Page, place: dict[str, Any]) -> None:
    version = place["masks"].frame(FRAME).version
    before = canvas(page).screenshot()
    page.mouse.move(*at(page, *middle()))
    page.mouse.wheel(0, -400)
    page.wait_for_timeout(300)
    enlarged = canvas(page).screenshot()
    drag(page, (300, 200), (360, 230), button="middle")
    page.wait_for_timeout(300)
    moved = canvas(page).screenshot()
    assert len({before, enlarged, moved}) == 3
    assert place["masks"].frame(FRAME).version == version


def test_another_view_is_opened_by_its_picture(page: Page) -> None:
    page.get_by_role("button", name="Edit view1").click()
    expect(page.locator(".mask-editor-said")).to_contain_text("view1, left of the robot: detected")
    expect(page).to_have_url(re.compile("edit=view1"))
    expect(page.get_by_role("button", name="Edit view3")).to_be_visible()


def test_the_numbers_follow_each_stroke(page: Page, place: dict[str, Any]) -> None:
    rows = page.locator(".mask-editor-numbers tr")
    before = rows.locator("td:nth-child(2)").all_inner_texts()
    assert rows.locator("td:nth-child(3)").all_inner_texts() == before
    lines, columns = np.nonzero(cup())
    for x in (columns.min(), columns.max()):
        done(page, place, lambda x=x: drag(page, (x, lines.min()), (x, lines.max())))
    assert rows.locator("td:nth-child(2)").all_inner_texts() == before
    assert rows.locator("td:nth-child(3)").all_inner_texts() != before


def test_guests_can_look_and_not_draw(browser_page: Page, place: dict[str, Any]) -> None:
    version = place["masks"].frame(FRAME).version
    page = opened(browser_page, place["guests"])
    expect(page.get_by_role("button", name="Brush", exact=True)).to_be_disabled()
    drag(page, (100, 50), (140, 50))
    page.wait_for_timeout(500)
    assert place["masks"].frame(FRAME).version == version


def test_a_finger_draws_and_two_enlarge(chromium: Browser, place: dict[str, Any]) -> None:
    context = chromium.new_context(viewport={"width": 1200, "height": 1000}, has_touch=True)
    page = opened(context.new_page(), place["address"])
    session = context.new_cdp_session(page)

    def touch(kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def stroke() -> None:
        touch("touchStart", at(page, 100, 50))
        for x in range(105, 141, 5):
            touch("touchMove", at(page, x, 50))
        touch("touchEnd")

    drawn = done(page, place, stroke)
    assert drawn[50, 104:136].all()
    version = place["masks"].frame(FRAME).version
    before = canvas(page).screenshot()
    touch("touchStart", at(page, 300, 180), at(page, 340, 180))
    for step in range(1, 9):
        touch("touchMove", at(page, 300 - 8 * step, 180), at(page, 340 + 8 * step, 180))
    touch("touchEnd")
    page.wait_for_timeout(500)
    assert canvas(page).screenshot() != before
    assert place["masks"].frame(FRAME).version == version
    context.close()


def test_two_people_are_told_of_each_other(page: Page, chromium: Browser, place: dict[str, Any]) -> None:
    context = chromium.new_context(viewport={"width": 1400, "height": 1000})
    other = opened(context.new_page(), place["address"])
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Your name").press("Tab")
    first = done(page, place, lambda: drag(page, (100, 50), (140, 50)))
    drag(other, (100, 90), (140, 90))
    expect(other.locator(".mask-editor-said")).to_contain_text("Ada changed this mask")
    np.testing.assert_array_equal(mask_of(place, 0), first)
    beside = [step for step in place["masks"].frame(FRAME).steps if step.is_beside]
    assert beside[-1].mask is not None
    assert beside[-1].mask.mask[90, 120]
    context.close()
