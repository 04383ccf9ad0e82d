"""The app in a real browser, on the tiny dataset and on the real recording."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, quote, urlsplit

import pytest
from playwright.sync_api import Locator, Page, expect

from corsmal.ui.messages import WORD_JOINER

pytestmark = pytest.mark.browser

HULL = "Hull, circumferences and cameras in 3D"
CAMERA = "node => node._fullLayout.scene._scene.getCamera()"
RINGS = """node => node._fullData
  .filter((trace) => ["circumferences", "rejected by d_max", "lower and upper end"].includes(trace.name))
  .reduce((sum, trace) => sum + [...trace.x].filter(Number.isNaN).length, 0)"""
MORE_RINGS = f"([node, before]) => ({RINGS})(node) > before"


Start = Callable[[Path], str]


@pytest.fixture(scope="module")
def start(serve: Any, tmp_path_factory: pytest.TempPathFactory) -> Start:
    """Starts the app as a user starts it, and returns its address."""
    environment = {"CORSMAL_CACHE": str(tmp_path_factory.mktemp("cache")), "CORSMAL_DATA": ""}
    return lambda root: serve("app.py", "--data", str(root), env=environment)


@pytest.fixture(scope="module")
def address(start: Start, tiny_dataset_root: Path) -> str:
    return start(tiny_dataset_root)


@pytest.fixture(scope="module")
def real_address(start: Start, real_dataset_root: Path) -> str:
    return start(real_dataset_root)


@pytest.fixture
def page(browser_page: Page) -> Page:
    browser_page.set_viewport_size({"width": 1400, "height": 1100})
    return browser_page


def plot(page: Page, label: str) -> Locator:
    figure = page.get_by_role("group", name=label).locator(".linked-plot-figure")
    expect(figure.locator(".main-svg").first).to_be_visible(timeout=120_000)
    return figure


def query(page: Page) -> dict[str, str]:
    return {name: values[0] for name, values in parse_qs(urlsplit(page.url).query).items()}


def measures(page: Page) -> list[str]:
    return page.get_by_test_id("stCaptionContainer").filter(has_text="this frame").all_inner_texts()


def rotate(page: Page, figure: Locator) -> dict[str, Any]:
    """Turn the hull with the mouse; returns the camera once it has come to rest."""
    before = figure.evaluate(CAMERA)
    box = figure.bounding_box()
    assert box is not None
    middle, height = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(middle, height)
    page.mouse.down()
    page.mouse.move(middle + 120, height - 40, steps=8)
    page.mouse.up()
    seen = [before]
    while seen[-1] == before or seen[-1] != seen[-2]:
        page.wait_for_timeout(300)
        seen.append(figure.evaluate(CAMERA))
    return seen[-1]


@pytest.mark.parametrize("app", ["address", "real_address"])
def test_dragging_the_slider_refits_the_hull_and_leaves_the_camera(
    page: Page, app: str, request: pytest.FixtureRequest
) -> None:
    page.goto(f"{request.getfixturevalue(app)}/shape")
    figure = plot(page, HULL)
    slider = page.get_by_role("slider", name="L, circumferences")
    slider.scroll_into_view_if_needed()
    camera, rings, measured = rotate(page, figure), figure.evaluate(RINGS), measures(page)
    box = slider.bounding_box()
    assert box is not None
    start, middle = box["x"] + box["width"] * (145 - 10) / (500 - 10), box["y"] + box["height"] / 2
    page.mouse.move(start, middle)
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(start + step * box["width"] / 30, middle)
    page.wait_for_function(MORE_RINGS, arg=[figure.element_handle(), rings])  # the button is still down
    assert "L" not in query(page)
    page.mouse.up()
    chosen = slider.input_value()
    page.wait_for_url(re.compile(rf"[?&]L={chosen}\b"))
    assert int(chosen) > 200
    assert measures(page) != measured
    for name in ("eye", "center", "up"):
        assert figure.evaluate(CAMERA)[name] == pytest.approx(camera[name], abs=1e-9)


def test_buttons_turn_the_hull_and_the_view_stays_when_it_refits(page: Page, address: str) -> None:
    page.goto(f"{address}/hull")
    figure = plot(page, HULL)
    heights = []
    for name in ("Top", "Side", "Front"):
        before = figure.evaluate(CAMERA)["eye"]
        figure.locator(".updatemenu-button", has_text=name).click()
        page.wait_for_function(
            f"([node, before]) => ({CAMERA})(node).eye.x !== before.x", arg=[figure.element_handle(), before]
        )
        camera = figure.evaluate(CAMERA)
        heights.append(camera["eye"]["z"] - camera["center"]["z"])
    assert heights[0] > 1.5
    assert heights[1:] == pytest.approx([0, 0], abs=1e-6)
    rings = figure.evaluate(RINGS)
    page.get_by_role("slider", name="L, circumferences").press("PageUp")
    page.wait_for_function(MORE_RINGS, arg=[figure.element_handle(), rings])
    assert figure.evaluate(CAMERA)["eye"] == pytest.approx(camera["eye"], abs=1e-9)


def test_keys_step_through_the_frames(page: Page, address: str) -> None:
    page.goto(f"{address}/frames?frame=2")
    plot(page, "Scores of the frames")
    for key, frame in (("ArrowRight", 3), ("ArrowRight", 4), ("ArrowLeft", 3), ("Home", 0)):
        page.keyboard.press(key)
        expect(page.get_by_text(f"view3, frame {frame}", exact=True)).to_be_visible()
        page.wait_for_url(re.compile(rf"[?&]frame={frame}\b"))


def test_held_key_is_one_step_of_the_history(page: Page, address: str) -> None:
    page.goto(f"{address}/best-frame?recording=000000&frame=1")
    plot(page, "Scores of the frames")
    before = page.evaluate("history.length")
    for frame in (2, 3, 4, 5):
        page.keyboard.down("ArrowRight")  # again and again without an up, as a held key repeats
        expect(page.get_by_text(f"view3, frame {frame}", exact=True)).to_be_visible()
        assert query(page)["frame"] == "1"
    page.keyboard.up("ArrowRight")
    page.wait_for_url(re.compile(r"[?&]frame=5\b"))
    assert page.evaluate("history.length") == before + 1
    page.go_back()
    expect(page.get_by_text("view3, frame 1", exact=True)).to_be_visible()


def test_a_number_leads_to_the_page_that_explains_it_by_keys_too(page: Page, address: str) -> None:
    page.goto(address)
    capacity = page.get_by_role("group", name="Capacity", exact=True)
    expect(capacity.locator(".tile-value")).to_have_text(re.compile("mL$"), timeout=120_000)
    value = capacity.locator(".tile-value").inner_text()
    link = capacity.get_by_role("button", name="Capacity", exact=True)
    expect(link).to_have_attribute("title", "Open the Shape page with this recording, frame and preset.")
    link.focus()
    link.press("Enter")
    expect(page.get_by_role("heading", name="Shape", exact=True)).to_be_visible()
    expect(page.get_by_test_id("stMetricValue").first).to_have_text(value, timeout=120_000)  # its loops may be compiled
    page.go_back()
    page.get_by_role("button", name="Object mass", exact=True).click()
    expect(page.get_by_role("heading", name="Mass", exact=True)).to_be_visible()


def test_a_page_and_the_address_that_it_writes_are_one_step_of_the_history(page: Page, address: str) -> None:
    page.goto(f"{address}/dataset?recording=000001")
    page.wait_for_url(re.compile(r"/dataset\?dataset="))
    page.wait_for_function("window.corsmalHistory")
    for name in ("Filling", "Mass"):
        before = page.evaluate("history.length")
        page.get_by_role("link", name=name, exact=True).click()
        expect(page.get_by_role("heading", name=name, exact=True)).to_be_visible()
        page.wait_for_url(re.compile(r"\?.*recording=000001"))
        assert page.evaluate("history.length") == before + 1
    for name in ("Filling", "Recordings"):
        page.go_back()
        expect(page.get_by_role("heading", name=name, exact=True)).to_be_visible()
        assert query(page)["recording"] == "000001"


@pytest.mark.parametrize("text", ["[x](http://example.com)", "$a$ *b* _c_ `d`", "<b>e</b>", ":red[f]", "~g~"])
def test_what_stood_in_an_address_is_shown_as_it_is(page: Page, address: str, text: str) -> None:
    page.goto(f"{address}/best-frame?recording=000000&frame={quote(text)}")
    shown = text.replace("://", f":{WORD_JOINER}//")  # no link
    expect(page.get_by_test_id("stAlert").get_by_text(f"frame='{shown}'")).to_be_visible()


def test_thumbnails_are_served_for_recordings_alone(page: Page, address: str) -> None:
    with page.expect_response(re.compile("/thumbnails/")) as caught:
        page.goto(f"{address}/dataset")
    response = caught.value
    assert response.status == 200
    assert response.headers["content-type"] == "image/jpeg"
    assert response.body().startswith(b"\xff\xd8\xff")
    folder, name = response.url.rsplit("/", 1)
    for path in (f"{folder}/999999.jpg", f"{address}/thumbnails/0123/{name}"):
        assert page.request.get(path).status == 404, path
    for outside in ("..%2F..%2F..%2Fetc%2Fpasswd.jpg", "%2Fetc%2Fpasswd.jpg", "..%2F..%2Frequirements.txt%00.jpg"):
        answer = page.request.get(f"{folder}/{outside}")  # refused, or Streamlit's own start page
        assert answer.status in (400, 404) or "<title>Streamlit</title>" in answer.text(), outside


def test_hull_is_downloaded_as_a_mesh(page: Page, address: str) -> None:
    page.goto(f"{address}/hull?L=20&dmax=10")
    plot(page, HULL)
    with page.expect_download() as caught:
        page.get_by_role("button", name="Download hull (OBJ)").click()
    assert re.fullmatch(r"\d{6}_view3-view1_frame\d+\.obj", caught.value.suggested_filename)
    lines = caught.value.path().read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("v ") for line in lines) > 96
    assert sum(line.startswith("f ") for line in lines) > 96
