"""The time line in a real browser: what every redraw shows, and what moves with it."""

import re
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.tiny import write_audio, write_tiny_dataset

pytestmark = pytest.mark.browser

FRAMES = 20
PLAYED_MS = 120_000
"""Until all is played, on a machine that does something else, too."""
NAME = "000000"
RECORD = """() => {
  const seen = [];
  const look = (ms) => {
    const images = [...document.querySelectorAll(".time-line-picture img")];
    const shown = images.map((image) => Number(image.alt.match(/frame (\\d+)/)[1]));
    const whole = images.every((image) => image.complete && image.naturalWidth > 0);
    const lines = [...document.querySelectorAll(".linked-plot-cursor:not([hidden])")];
    const others = lines.map((line) => line.dataset.frame);
    const now = { shown, whole, bar: document.querySelector(".time-line-track").ariaValueNow, others };
    if (JSON.stringify(now) !== JSON.stringify(seen.at(-1)?.now)) seen.push({ now, ms });
    window.recorded = seen;
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}"""


HOLD = """(key) => {
  const press = (type, repeat) => document.body.dispatchEvent(new KeyboardEvent(type, { key, repeat, bubbles: true }));
  press("keydown", false);
  const timer = setInterval(() => press("keydown", true), 33); // as a keyboard repeats
  window.letGo = () => { clearInterval(timer); press("keyup", false); };
}"""
RECORDED = """() => new Promise((resolve) => {
  requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => resolve(window.recorded))));
})"""


@pytest.fixture(scope="module")
def address(serve: Any, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("time_line")
    root = write_tiny_dataset(folder / "train", recordings=1, frames=FRAMES)
    write_audio(root / "audio" / f"{NAME}.wav", seconds=FRAMES / 30)
    return serve("app.py", "--data", str(root), env={"CORSMAL_CACHE": str(folder / "cache"), "CORSMAL_DATA": ""})


@pytest.fixture
def page(browser_page: Page, address: str) -> Page:
    browser_page.set_viewport_size({"width": 1400, "height": 1000})
    browser_page.goto(f"{address}/best-frame?frame=2")
    expect(browser_page.locator(".time-line-picture img")).to_have_count(3)
    expect(browser_page.locator(".linked-plot-cursor")).to_have_attribute("data-frame", "2")
    return browser_page


def track(page: Page) -> Locator:
    return page.get_by_role("slider", name="Frame", exact=True)


def at(page: Page, frame: int) -> None:
    expect(track(page)).to_have_attribute("aria-valuenow", str(frame), timeout=PLAYED_MS)
    expect(page.get_by_role("img", name=re.compile(rf"^view\d, frame {frame}$"))).to_have_count(3)


def press(page: Page, name: str) -> None:
    page.get_by_role("group", name="Time line").get_by_role("button", name=name, exact=True).click()


def recorded(page: Page) -> list[dict[str, Any]]:
    """Every redraw since ``RECORD``, checked: one frame in all views, on the track and as the cursor of the plot."""
    seen: list[dict[str, Any]] = page.evaluate(RECORDED)
    for redraw in (entry["now"] for entry in seen):
        frame = redraw["shown"][0]
        assert redraw["shown"] == [frame] * 3
        assert redraw["whole"]
        assert redraw["bar"] == str(frame)
        assert redraw["others"] == [str(frame)]
    return seen


def test_a_held_key_shows_one_frame_in_every_redraw(page: Page) -> None:
    page.evaluate(RECORD)
    page.evaluate(HOLD, "ArrowRight")
    at(page, FRAMES - 1)
    assert "frame=2" in page.url
    page.evaluate("window.letGo()")
    page.wait_for_url(re.compile(rf"[?&]frame={FRAMES - 1}\b"))
    seen = recorded(page)
    frames = [entry["now"]["shown"][0] for entry in seen]
    assert frames == list(range(2, FRAMES))
    rate = (len(seen) - 2) / (seen[-1]["ms"] - seen[1]["ms"]) * 1000
    print(f"a held key: {rate:.1f} redraws of three views a second")  # noqa: T201 - reported, not asserted


def test_playing_shows_one_frame_in_every_redraw_and_rests_at_the_end(page: Page) -> None:
    page.evaluate(RECORD)
    page.get_by_role("combobox", name="Speed").select_option("0.5")
    press(page, "Play")
    at(page, FRAMES - 1)
    page.wait_for_url(re.compile(rf"[?&]frame={FRAMES - 1}\b"))
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    frames = [entry["now"]["shown"][0] for entry in recorded(page)]
    assert frames == sorted(frames)
    assert len(frames) > 3


def test_beside_a_search_few_frames_are_shown_and_no_others_fetched(page: Page) -> None:
    page.evaluate("() => { window.corsmalPlayhead.data.most_per_s = 10; }")
    page.evaluate(RECORD)
    fetched: list[int] = []
    page.on("request", lambda request: fetched.extend(map(int, re.findall(r"/view\d/(\d+)\.jpg", request.url))))
    press(page, "Play")
    at(page, FRAMES - 1)
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    shown = [2, 14, FRAMES - 1]  # of 30 a second every twelfth: this browser draws without a graphics card
    frames = [entry["now"]["shown"][0] for entry in recorded(page)]
    assert frames == sorted(frames)
    assert set(frames) <= set(shown)
    assert set(fetched) <= {*shown, FRAMES - 3, FRAMES - 2}  # when it rests, the two before it


def test_the_sound_plays_and_pauses_with_the_frames(page: Page) -> None:
    page.get_by_role("combobox", name="Speed").select_option("0.25")
    sound = page.locator(".time-line audio")
    press(page, "Play")
    page.wait_for_function("sound => !sound.paused && sound.currentTime > 0.1", arg=sound.element_handle())
    assert sound.evaluate("sound => sound.playbackRate") == 0.25
    press(page, "Pause")
    assert sound.evaluate("sound => sound.paused")
    stopped = int(track(page).get_attribute("aria-valuenow") or 0)
    assert sound.evaluate("sound => sound.currentTime") > stopped / 30 - 0.3  # pictures may lag behind, not the sound
    page.wait_for_url(re.compile(rf"[?&]frame={stopped}\b"))
    press(page, "Sound on")
    assert sound.evaluate("sound => sound.muted")


def test_dragging_clicking_and_typing_move_the_playhead(page: Page) -> None:
    box = track(page).bounding_box()
    assert box is not None
    x, y = (lambda frame: box["x"] + box["width"] * (frame + 0.5) / FRAMES), box["y"] + box["height"] / 2
    page.evaluate(RECORD)
    page.mouse.move(x(2), y)
    page.mouse.down()
    page.mouse.move(x(15), y, steps=6)
    at(page, 15)
    assert "frame=2" in page.url.split("&")[-1]
    page.mouse.up()
    page.wait_for_url(re.compile(r"[?&]frame=15\b"))
    recorded(page)
    page.get_by_role("spinbutton", name=f"Frame (0 to {FRAMES - 1})").fill("7")
    page.keyboard.press("Enter")
    at(page, 7)
    page.wait_for_url(re.compile(r"[?&]frame=7\b"))
    page.go_back()
    at(page, 15)


def test_keys_and_buttons_step_except_in_an_input(page: Page) -> None:
    for key, frame in (("ArrowRight", 3), ("PageDown", 13), ("PageUp", 3), ("End", FRAMES - 1), ("Home", 0)):
        page.keyboard.press(key)
        at(page, frame)
    press(page, "Next frame")
    at(page, 1)
    press(page, "Previous frame")
    at(page, 0)
    press(page, "Next inspected frame")
    at(page, 1)
    page.get_by_role("textbox", name="Dataset folder").press("ArrowRight")
    page.get_by_role("spinbutton", name=re.compile("^Frame")).press("ArrowLeft")
    at(page, 1)


def test_a_click_on_a_score_goes_to_its_frame(page: Page) -> None:
    figure = page.get_by_role("group", name="Scores of the frames").locator(".linked-plot-figure")
    figure.scroll_into_view_if_needed()
    place = """node => {
      const { xaxis, yaxis } = node._fullLayout, box = node.getBoundingClientRect();
      const trace = node._fullData.find(({ name }) => name === "score of the pair");
      const at = trace.x.indexOf(9);
      return [box.x + xaxis._offset + xaxis.d2p(9), box.y + yaxis._offset + yaxis.d2p(trace.y[at])];
    }"""
    hover = figure.locator(".hoverlayer .legend, .hoverlayer .hovertext").first
    for _ in range(10):
        x, y = figure.evaluate(place)
        page.mouse.move(x - 30, y)
        page.mouse.move(x, y, steps=4)
        page.wait_for_timeout(500)
        if hover.is_visible():
            break
    page.mouse.click(x, y)
    at(page, 9)
    page.wait_for_url(re.compile(r"[?&]frame=9\b"))
