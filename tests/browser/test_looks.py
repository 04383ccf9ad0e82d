"""What can be read on each page: contrast in both themes, and nothing cut off on a projector."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

pytestmark = pytest.mark.browser

PAGES = ("", "dataset", "best-frame", "hull", "sound", "weight", "results")
CONTRAST_LEAST, LARGE_LEAST, LARGE_PX = 4.5, 3.0, 24
"""WCAG 2.1, 1.4.3; what is disabled is exempt."""
FULL_MS = 180_000

LOW_CONTRAST = """([least, largeLeast, largePx]) => {
  const parse = (text) => {
    const numbers = text.match(/[\\d.]+%?/g)?.map((each) => parseFloat(each)) ?? [0, 0, 0, 0];
    const scale = text.startsWith("color(") ? 255 : 1;
    return [...numbers.slice(0, 3).map((each) => each * scale), numbers[3] ?? 1];
  };
  const over = (top, below) => [0, 1, 2].map((each) => top[each] * top[3] + below[each] * (1 - top[3]));
  const luminance = (colour) => {
    const linear = colour.slice(0, 3).map((each) => each / 255)
      .map((each) => (each <= 0.04045 ? each / 12.92 : ((each + 0.055) / 1.055) ** 2.4));
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  };
  const ancestors = (node) => (node ? [node, ...ancestors(node.parentElement)] : []);
  const found = [];
  for (const node of document.querySelectorAll("[data-testid=stMain] *, [data-testid=stSidebar] *")) {
    const text = [...node.childNodes].filter((each) => each.nodeType === 3).map((each) => each.data.trim()).join("");
    const box = node.getBoundingClientRect();
    if (!text || !box.width || !box.height || node.closest("svg, [data-testid=stDataFrame], :disabled")) continue;
    const line = ancestors(node), style = getComputedStyle(node);
    if (!node.checkVisibility() || node.closest("details:not([open])")) continue;
    if (style.visibility === "hidden" || node.closest("[aria-disabled=true]")) continue;
    let below = [255, 255, 255];
    for (const each of [...line].reverse()) below = over(parse(getComputedStyle(each).backgroundColor), below);
    const opacity = line.reduce((product, each) => product * parseFloat(getComputedStyle(each).opacity), 1);
    if (opacity < 0.05) continue;  // such as what is folded up
    const colour = parse(style.color);
    const seen = over([...colour.slice(0, 3), colour[3] * opacity], below);
    const [low, high] = [luminance(seen), luminance(below)].sort((a, b) => a - b);
    const ratio = (high + 0.05) / (low + 0.05);
    const isLarge = parseFloat(style.fontSize) >= largePx;
    if (ratio < (isLarge ? largeLeast : least)) found.push(`${ratio.toFixed(2)} ${text.slice(0, 40)} (${style.color})`);
  }
  return found;
}"""
"""Texts of a page that stand out too little, with their contrast."""

HAS_THEME = """theme => {
  const background = getComputedStyle(document.querySelector("[data-testid=stApp]")).backgroundColor;
  const [red] = background.match(/[\\d.]+/g).map(parseFloat);
  return (red > 128) === (theme === "light");
}"""
"""Whether a theme is in use."""

CUT_OFF = """() => {
  const scrolls = (node) => /auto|scroll/.test(getComputedStyle(node).overflowX);
  const found = [];
  for (const node of document.querySelectorAll("[data-testid=stMain] *, [data-testid=stSidebar] *")) {
    const text = [...node.childNodes].filter((each) => each.nodeType === 3).map((each) => each.data.trim()).join("");
    const box = node.getBoundingClientRect();
    if (!box.width || !box.height || node.closest("[data-testid=stDataFrame], svg, code, audio, video")) continue;
    const hides = getComputedStyle(node).overflowX !== "visible";
    if (text && hides && !scrolls(node) && node.scrollWidth > node.clientWidth + 1 && node.clientWidth)
      found.push(`cut off: ${text.slice(0, 60)}`);
    if (node.matches("button, input, a, [role=slider]") && (box.left < -1 || box.right > innerWidth + 1))
      found.push(`outside: ${(node.innerText || node.ariaLabel || node.tagName).slice(0, 60)}`);
  }
  const main = document.querySelector("[data-testid=stMain]");
  if (main.scrollWidth > main.clientWidth + 1) found.push("the page scrolls sideways");
  return found;
}"""
"""Texts of a page that do not show whole, and controls outside the window."""


@pytest.fixture(scope="module")
def address(serve: Any, tmp_path_factory: pytest.TempPathFactory) -> str:
    cache = tmp_path_factory.mktemp("looks")
    return serve("app.py", env={"CORSMAL_CACHE": str(cache), "CORSMAL_DATA": ""})


@pytest.fixture
def projected(chromium: Browser) -> Iterator[Page]:
    """A page as wide as a projector."""
    context = chromium.new_context(viewport={"width": 1024, "height": 768}, color_scheme="light")
    context.set_default_timeout(FULL_MS)
    yield context.new_page()
    context.close()


def full(page: Page, url: str) -> None:
    """Open a page and wait until it is complete."""
    page.goto(url)
    expect(page.get_by_test_id("stMain").get_by_role("heading").first).to_be_visible(timeout=FULL_MS)
    expect(page.get_by_test_id("stSkeleton")).to_have_count(0, timeout=FULL_MS)
    page.wait_for_function("() => !document.querySelector('[data-stale=true]')")
    expect(page.get_by_test_id("stApp")).to_have_attribute(
        "data-test-script-state", re.compile("notRunning"), timeout=FULL_MS
    )


def test_every_text_stands_out_from_its_background_and_none_is_cut_off(projected: Page, address: str) -> None:
    problems = {}
    for path in PAGES:
        projected.emulate_media(color_scheme="light")
        full(projected, f"{address}/{path}")
        found = {"cut off": projected.evaluate(CUT_OFF)}
        for theme in ("light", "dark"):
            projected.emulate_media(color_scheme=theme)
            projected.wait_for_function(HAS_THEME, arg=theme)
            found[theme] = projected.evaluate(LOW_CONTRAST, [CONTRAST_LEAST, LARGE_LEAST, LARGE_PX])
        problems |= {f"{path or 'overview'}, {what}": texts for what, texts in found.items() if texts}
    assert problems == {}


def test_title_stands_near_the_upper_edge(browser_page: Page, address: str) -> None:
    browser_page.set_viewport_size({"width": 1440, "height": 900})
    full(browser_page, f"{address}/hull")
    box = browser_page.get_by_role("heading", name="Shape", exact=True).bounding_box()
    assert box is not None
    assert box["y"] < 48


def test_hull_sliders_and_measures_are_on_the_screen_together(browser_page: Page, address: str) -> None:
    browser_page.set_viewport_size({"width": 1440, "height": 900})
    full(browser_page, f"{address}/hull")
    seen = [
        browser_page.get_by_test_id("stMetric").first,
        browser_page.get_by_role("group", name="Hull, circumferences and cameras in 3D"),
        browser_page.get_by_role("slider", name="d_max"),
    ]
    for part in seen:
        box = part.bounding_box(timeout=FULL_MS)
        assert box is not None
        assert box["y"] >= 0
        assert box["y"] + box["height"] <= 900


def test_bracket_keys_step_through_the_recordings(browser_page: Page, address: str) -> None:
    full(browser_page, f"{address}/dataset?recording=000000")
    browser_page.keyboard.press("]")
    expect(browser_page.get_by_role("heading", name="Recording 000003")).to_be_visible(timeout=FULL_MS)
    browser_page.keyboard.press("[")
    expect(browser_page.get_by_role("heading", name="Recording 000000")).to_be_visible(timeout=FULL_MS)
    browser_page.get_by_role("textbox", name="Dataset folder").press("]")
    expect(browser_page.get_by_role("heading", name="Recording 000000")).to_be_visible()


JOB = """
import time
import streamlit as st
from corsmal.ui import look

look.apply()
st.session_state.setdefault("done", 0)

@st.fragment(run_every=0.4)
def watch():
    time.sleep(0.2)
    st.session_state["done"] += 1
    st.progress(min(st.session_state["done"], 100), text=f"{st.session_state['done']} frames")
    st.button("Stop", key="stop job")

watch()
"""
MOVED = """() => {
  window.moved = [];
  document.addEventListener("transitionrun", (event) => {
    if (event.target.closest("[data-testid=stMain]")) window.moved.push(event.propertyName);
  });
}"""
IS_LATER = "done => Number(document.querySelector('[role=progressbar]').getAttribute('aria-valuenow')) >= done"


def test_progress_of_a_job_moves_in_steps_without_redraws_between(
    browser_page: Page, serve: Any, tmp_path: Path
) -> None:
    script = tmp_path / "job.py"
    script.write_text(JOB, encoding="utf-8")
    browser_page.goto(serve(script))
    expect(browser_page.get_by_text(re.compile(r"^\d+ frames$"))).to_be_visible()
    browser_page.evaluate(MOVED)
    before = int(browser_page.get_by_role("progressbar").get_attribute("aria-valuenow") or 0)
    browser_page.wait_for_function(IS_LATER, arg=before + 4)
    assert browser_page.evaluate("() => window.moved") == []
