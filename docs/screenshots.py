"""The pictures of docs/pages.md, taken from the running app: ``.venv/bin/python docs/screenshots.py``.

Light theme, 1440 × 900, the demo's recording 000009. Needs Chromium, as the browser tests do.
"""

import io
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, expect, sync_playwright

PICTURES = Path(__file__).parent / "pictures"
SIZE = {"width": 1440, "height": 900}
RECORDING = "000009"
PAGES = {
    "overview": ("", "What was known when"),
    "recordings": ("dataset", "Recordings"),
    "frames": ("best-frame", "Frames"),
    "shape": ("hull", "Shape"),
    "filling": ("sound", "Filling"),
    "mass": ("weight", "Mass"),
    "evaluation": ("results", "Evaluation"),
}
"""Each page's address and a heading that stands on it when it is drawn."""
CHROMIUM = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
START_MAX_S, DRAWN_MAX_S, SETTLED_S = 60.0, 120.0, 6.0


def main() -> None:
    """Take all of them."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "corsmal", "app", "--no-browser", "--port", str(port)]
    environment = os.environ | {"CORSMAL_CACHE": str(Path(tempfile.gettempdir(), "corsmal"))}  # shown on every page
    with subprocess.Popen(command, env=environment) as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=CHROMIUM)
        try:
            address = f"http://127.0.0.1:{port}"
            wait_for(address)
            page = browser.new_page(viewport=SIZE, color_scheme="light")
            for name, (path, heading) in PAGES.items():
                page.goto(f"{address}/{path}?recording={RECORDING}")
                expect(page.get_by_role("heading", name=heading).first).to_be_visible(timeout=60_000)
                settle(page)
                save(page, name)
                if name == "shape":
                    open_download(page)
                    save(page, "download")
        finally:
            browser.close()
            server.terminate()


def wait_for(address: str) -> None:
    """Wait until the server answers."""
    until_s = time.monotonic() + START_MAX_S
    while time.monotonic() < until_s:
        with suppress(OSError), urllib.request.urlopen(f"{address}/_stcore/health", timeout=5):
            return
        time.sleep(0.2)
    sys.exit("the app did not start")


def settle(page: Page) -> None:
    """Wait until nothing runs and the plots are drawn."""
    expect(page.get_by_test_id("stStatusWidget")).to_have_count(0, timeout=60_000)
    page.wait_for_timeout(1000 * SETTLED_S)


def open_download(page: Page) -> None:
    """Open the menu of a figure's download."""
    page.get_by_role("button", name="Download figure").first.click()
    expect(page.get_by_role("dialog")).to_be_visible(timeout=60_000)
    page.wait_for_timeout(500)


def save(page: Page, name: str) -> None:
    """A picture of 256 colours, a third of the size."""
    shown = Image.open(io.BytesIO(page.screenshot(timeout=1000 * DRAWN_MAX_S)))
    shown.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
