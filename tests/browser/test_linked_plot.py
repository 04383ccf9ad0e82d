from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

pytestmark = pytest.mark.browser

CAMERA = "node => node._fullLayout.scene._scene.getCamera().eye"
HIGHEST_IS = "([node, value]) => Math.max(...node._fullData[0].z.map((row) => Math.max(...row))) === value"
POINT_ON_PAGE = """(node, [x, y]) => {
  const { xaxis, yaxis } = node._fullLayout, box = node.getBoundingClientRect();
  return [box.x + xaxis._offset + xaxis.d2p(x), box.y + yaxis._offset + yaxis.d2p(y)];
}"""


@pytest.fixture(scope="module")
def address(serve: Any) -> str:
    return serve(Path(__file__).with_name("linked_plot_app.py"))


@pytest.fixture
def page(browser_page: Page, address: str) -> Page:
    browser_page.goto(address)
    for label in ("Surface", "Points"):
        expect(plot(browser_page, label).locator(".main-svg").first).to_be_visible()
    return browser_page


def plot(page: Page, label: str) -> Locator:
    return page.get_by_role("group", name=label).locator(".linked-plot-figure")


def text(page: Page, content: str) -> None:
    expect(page.get_by_text(content, exact=False)).to_be_visible()


def rotate(page: Page) -> dict[str, float]:
    """Turn the surface with the mouse; returns the camera once it has come to rest."""
    figure = plot(page, "Surface")
    before = figure.evaluate(CAMERA)
    box = figure.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 150)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2 + 100, box["y"] + 110, steps=8)
    page.mouse.up()
    seen = [before]
    while seen[-1] == before or seen[-1] != seen[-2]:
        page.wait_for_timeout(300)
        seen.append(figure.evaluate(CAMERA))
    return seen[-1]


def point_on_page(page: Page, x: float, y: float) -> tuple[float, float]:
    figure = plot(page, "Points")
    figure.scroll_into_view_if_needed()
    left, top = figure.evaluate(POINT_ON_PAGE, [x, y])
    return left, top


def click_point(page: Page, x: float, y: float) -> None:
    left, top = point_on_page(page, x, y)
    page.mouse.move(left, top)
    expect(plot(page, "Points").locator(".hoverlayer .hovertext")).to_be_visible()
    page.mouse.click(left, top)


def test_dragging_the_slider_changes_the_surface_and_keeps_the_camera(page: Page) -> None:
    camera = rotate(page)
    slider = page.get_by_role("slider", name="Height")
    box = slider.bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 3, middle)
    page.mouse.down()
    for step in range(1, 6):
        page.mouse.move(box["x"] + box["width"] * (1 / 3 + step / 10), middle)
    value = slider.input_value()
    text(page, f"height {value} first settled False")  # arrives while the mouse is still down
    page.mouse.move(box["x"] + box["width"] * 0.6, middle)
    page.mouse.up()
    text(page, f"height {slider.input_value()} first settled False settled True")
    figure = plot(page, "Surface")
    page.wait_for_function(HIGHEST_IS, arg=[figure.element_handle(), float(slider.input_value())])
    assert figure.evaluate(CAMERA) == pytest.approx(camera, abs=1e-9)
    text(page, "app runs 1")


def test_server_number_and_keyboard_move_the_slider(page: Page) -> None:
    slider = page.get_by_role("slider", name="Height")
    number = page.get_by_role("spinbutton", name="Height, number")
    page.get_by_role("button", name="Preset").click()
    expect(slider).to_have_value("100")
    expect(number).to_have_value("100")
    number.fill("999")
    number.press("Enter")
    text(page, "height 140 ")
    slider.press("ArrowLeft")
    text(page, "height 139 ")
    expect(number).to_have_value("139")


def test_every_click_is_an_event(page: Page) -> None:
    click_point(page, 6, 36)
    text(page, "index 42 clicks 1")
    click_point(page, 6, 36)
    text(page, "index 42 clicks 2")


def test_plotly_comes_from_the_app_and_colours_follow_the_theme(page: Page, address: str) -> None:
    urls = page.evaluate("performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [url for url in urls if not url.startswith((address, "data:", "blob:"))] == []
    assert len([url for url in urls if "/corsmal/plotly-" in url]) == 1
    figure = plot(page, "Points")
    light = figure.evaluate("node => node._fullLayout.paper_bgcolor")
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(
        "([node, light]) => node._fullLayout.paper_bgcolor !== light", arg=[figure.element_handle(), light]
    )


def test_a_figure_is_downloaded_as_it_is_seen(page: Page, tmp_path: Path) -> None:
    page.get_by_role("group", name="Points").get_by_role("button", name="Download figure").click()
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_text("Points")).to_be_visible()
    expect(dialog.get_by_role("button", name="Download SVG")).to_be_visible()
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Data (CSV)").click()
    assert download.value.suggested_filename == "Points.csv"
    download.value.save_as(tmp_path / "data.csv")
    assert (tmp_path / "data.csv").read_text().startswith("trace,x,y,label\ntrace 1,0,0,0\ntrace 1,1,1,7\n")
    dialog.get_by_role("button", name="Close").click()
    text(page, "app runs 1")
