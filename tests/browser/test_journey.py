"""What a new user does, from the first start to the report, on the ready-made demo with the bundled networks."""

import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from corsmal.demo.packing import IDS

pytestmark = pytest.mark.browser

HULL = "Hull, circumferences and cameras in 3D"
CAMERA = "node => node._fullLayout.scene._scene.getCamera()"
HEADING_PX, ROW_PX = 36, 35
"""Of Streamlit's tables."""
DEMO_MS = 180_000
"""Until a page is full, on a machine that does something else, too."""


@pytest.fixture
def page(browser_page: Page, serve: Any, tmp_path: Path) -> Page:
    browser_page.set_viewport_size({"width": 1400, "height": 1100})
    address = serve("app.py", env={"CORSMAL_CACHE": str(tmp_path / "cache"), "CORSMAL_DATA": ""})
    browser_page.goto(address)
    return browser_page


def turn_to(page: Page, name: str) -> None:
    page.get_by_test_id("stSidebar").get_by_role("link", name=name).click()
    expect(page.get_by_role("heading", name=name, exact=True)).to_be_visible()


def plot(page: Page, label: str | re.Pattern[str]) -> Locator:
    figure = page.get_by_role("group", name=label).locator(".linked-plot-figure")
    expect(figure.locator(".main-svg").first).to_be_visible(timeout=DEMO_MS)
    return figure


def press(page: Page, name: str) -> None:
    page.get_by_test_id("stMain").get_by_role("button", name=name, exact=True).first.click()


def press_cell(table: Locator, *, column_share: float) -> None:
    """Press a cell of the first row of a table, which is drawn on a canvas, and anew while its page runs."""
    is_at_rest = re.compile("notRunning")
    expect(table.page.get_by_test_id("stApp")).to_have_attribute("data-test-script-state", is_at_rest, timeout=DEMO_MS)
    expect(table).to_be_visible()
    box = table.bounding_box()
    assert box is not None
    table.click(position={"x": column_share * box["width"], "y": HEADING_PX + ROW_PX / 2})


def pin(page: Page, label: str, title: str) -> None:
    """Pin what a page shows, and wait until it is said to be pinned."""
    press(page, f"Pin {label}")
    expect(page.get_by_text(re.compile(f"^Pinned: {title}")).first).to_be_visible()


def from_a_number_to_its_recording(page: Page) -> None:
    """From a number of Table 2 to the recordings behind it, and to the page where one of them is looked at."""
    main = page.get_by_test_id("stMain")
    main.get_by_text("Containers", exact=True).click(timeout=DEMO_MS)
    tables = main.get_by_test_id("stDataFrame")
    expect(main.get_by_text("Beside each number")).to_be_visible(timeout=DEMO_MS)
    press_cell(tables.first, column_share=0.6)
    expect(main.get_by_role("heading", name=re.compile(": 1 recording$"))).to_be_visible()
    press_cell(tables.nth(1), column_share=0.4)
    expect(page.get_by_role("heading", name=re.compile("^(Shape|Mass|Filling)$"))).to_be_visible()


def from_the_worst_recording_to_its_page(page: Page) -> None:
    """From the summary's worst recording to the panel beside it, and from there to the page of its fit."""
    main = page.get_by_test_id("stMain")
    plot(page, re.compile("^All metrics by container"))
    worst = main.get_by_test_id("stDataFrame").first
    press_cell(worst, column_share=0.3)
    heading = main.get_by_role("heading", name=re.compile(r"^Recording \d+$"))
    expect(heading).to_be_visible()
    expect(heading).to_be_in_viewport()
    panel, table = heading.bounding_box(), worst.bounding_box()
    assert panel is not None
    assert table is not None
    assert panel["x"] >= table["x"] + table["width"]  # beside, not below
    press(page, "Shape")
    expect(page.get_by_role("heading", name="Shape", exact=True)).to_be_visible()


def the_report_opens_without_a_network(report: Path, chromium: Browser) -> None:
    offline = chromium.new_context(offline=True)
    opened = offline.new_page()
    problems: list[str] = []
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
    opened.goto(report.as_uri(), timeout=DEMO_MS)
    expect(opened.locator("html[data-drawn=all]")).to_have_count(1)
    expect(opened.locator("audio")).to_have_count(1)
    assert opened.locator("img").evaluate_all("images => images.every((image) => image.naturalWidth > 0)")
    assert opened.evaluate("window.Plotly === undefined")  # every figure is a picture in the file
    expect(opened.get_by_text("red cup").first).to_be_visible()
    expect(opened.get_by_text("Synthetic data.")).to_be_visible()
    opened.get_by_role("button", name="Turn in 3D").click()
    expect(opened.locator(".live canvas").first).to_be_visible()
    assert report.stat().st_size < 8_000_000
    assert problems == []
    offline.close()


def test_from_the_first_start_to_the_report(page: Page, chromium: Browser, tmp_path: Path) -> None:
    expect(page.get_by_text("synthetic").first).to_be_visible()
    expect(page.get_by_role("heading", name="Overview", exact=True)).to_be_visible()
    plot(page, "Hull and circumferences in 3D")
    plot(page, f"What was known when, recording {IDS[0]}")
    expect(page.locator(".tile-value").first).not_to_have_text("…")

    turn_to(page, "Recordings")
    expect(page.get_by_role("heading", name=f"Recording {IDS[0]}")).to_be_visible()

    turn_to(page, "Frames")
    plot(page, f"Scores of the frames of recording {IDS[0]}")
    pin(page, "the pictures", f"{IDS[0]}, view3")

    turn_to(page, "Shape")
    hull = plot(page, HULL)
    camera = hull.evaluate(CAMERA)
    of_frame = page.get_by_test_id("stCaptionContainer").filter(has_text="this frame")
    before = of_frame.all_inner_texts()
    page.get_by_role("slider", name="L, circumferences").press("PageUp")
    page.wait_for_url(re.compile(r"[?&]L=\d+"))
    expect(of_frame).not_to_have_text(before)
    assert hull.evaluate(CAMERA)["eye"] == pytest.approx(camera["eye"], abs=1e-9)
    pin(page, "the hull", f"Hull of {IDS[0]}")

    turn_to(page, "Filling")
    plot(page, f"Sound of recording {IDS[0]}")
    page.get_by_role("slider", name="Start of the crop").press("PageUp")
    page.wait_for_url(re.compile(r"[?&]crop=0\.50-"))
    page.get_by_test_id("stAudio").first.evaluate("player => { player.muted = true; return player.play(); }")
    pin(page, "the sound", f"Sound of {IDS[0]}")

    turn_to(page, "Mass")
    plot(page, re.compile("^The mask of view3"))
    expect(page.get_by_test_id("stMetricValue").first).to_have_text(re.compile("g$"))

    turn_to(page, "Evaluation")
    from_a_number_to_its_recording(page)

    turn_to(page, "Evaluation")
    main = page.get_by_test_id("stMain")
    main.get_by_text("Recordings", exact=True).click(timeout=DEMO_MS)
    expect(main.get_by_text("6 of 6 recordings")).to_be_visible()
    main.get_by_text("Report", exact=True).click()
    press(page, "Make report")
    with page.expect_download(timeout=DEMO_MS) as download:
        page.get_by_role("button", name="Download report (HTML)").click(timeout=DEMO_MS)
    report = tmp_path / "report.html"
    download.value.save_as(report)
    the_report_opens_without_a_network(report, chromium)


def test_from_the_first_start_by_playing_to_the_worst_recording_and_back(page: Page) -> None:
    expect(page.get_by_role("heading", name="Overview", exact=True)).to_be_visible()
    line = page.get_by_role("group", name=re.compile("^Time line of recording"))
    playhead = line.get_by_role("slider", name="Frame", exact=True)
    expect(line.get_by_role("img", name=re.compile("^view"))).to_have_count(3, timeout=DEMO_MS)
    expect(page.locator(".tile-value").first).not_to_have_text("…", timeout=DEMO_MS)
    start = playhead.get_attribute("aria-valuenow") or ""
    line.get_by_role("button", name="Play", exact=True).click()
    expect(playhead).not_to_have_attribute("aria-valuenow", start)
    line.get_by_role("button", name="Pause", exact=True).click()
    frame = playhead.get_attribute("aria-valuenow") or ""
    page.wait_for_url(re.compile(rf"[?&]frame={frame}\b"))

    turn_to(page, "Shape")
    expect(playhead).to_have_attribute("aria-valuenow", frame)
    expect(line.get_by_role("img", name=f"view3, frame {frame}")).to_be_visible()

    turn_to(page, "Evaluation")
    from_the_worst_recording_to_its_page(page)
    page.wait_for_url(re.compile(r"[?&]recording="))
    worst = re.findall(r"[?&]recording=(\d+)", page.url)[0]
    turn_to(page, "Overview")
    expect(page.get_by_role("group", name=f"Time line of recording {worst}")).to_be_visible(timeout=DEMO_MS)
    expect(line.get_by_role("img", name=re.compile("^view"))).to_have_count(3)
