"""The wheel in a fresh environment outside the checkout: first without extras, then with the app, in a browser.

Run with the checkout's own environment: ``.venv/bin/python .ci/installed.py``. PyTorch, 5 GB, is not installed a second
time: its folders are linked from that environment, and pip finds them there.
"""

import importlib.metadata
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parents[1]
LINKED = re.compile(r"(torch(vision|audio)?|triton|nvidia[-_].*|cuda[-_].*)$")
CHROMIUM = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

LIBRARY = """
from corsmal.dataset import open_dataset
from corsmal.demo.opening import open_demo
from corsmal.estimation import estimate
from corsmal.stages.detections import load_detections
from corsmal.store import Store
recording = open_dataset(open_demo(store=Store()))["000000"]
found = estimate(recording, detections=load_detections(recording, store=Store()).views)
print(found.status, f"{found.capacity_ml:.0f} mL", Store().root)
"""


def main() -> None:
    """Build, install, use; whatever fails ends the program."""
    with tempfile.TemporaryDirectory(prefix="corsmal-installed-") as name:
        place = Path(name)
        environment = {key: value for key, value in os.environ.items() if not key.startswith("CORSMAL_")}
        environment |= {"XDG_CACHE_HOME": str(place / "caches"), "COLUMNS": "100"}

        def run(*command: str | Path, status: int = 0) -> str:
            began_s = time.monotonic()
            result = subprocess.run(
                list(map(str, command)), cwd=place, env=environment, capture_output=True, text=True, check=False
            )
            print(f"{time.monotonic() - began_s:6.1f} s  {' '.join(map(str, command))[:90]!r}", flush=True)
            if result.returncode != status:
                sys.exit(f"exit status {result.returncode}, not {status}:\n{result.stdout}\n{result.stderr}")
            return result.stdout if status == 0 else result.stderr

        run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", place, ROOT)
        [wheel] = place.glob("corsmal-*.whl")
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
        run(sys.executable, "-m", "venv", "env")
        link_torch(next((place / "env").glob("lib/python*/site-packages")))
        own = place / "env" / "bin"

        run(own / "pip", "install", "-q", wheel)
        print(f"without extras, PyTorch not counted: {size_mb(place / 'env'):.0f} MB")
        print(run(own / "python", "-c", LIBRARY).strip())
        demo = place / "caches" / "corsmal" / "demo-six"
        print(run(own / "corsmal", "doctor", demo).splitlines()[-1])
        assert "pip install 'corsmal[app]'" in run(own / "corsmal", "app", status=1)
        assert "pip install 'corsmal[train]'" in run(own / "corsmal", "train", "mass", demo, "RUN", status=1)

        run(own / "pip", "install", "-q", f"{wheel}[app]")
        print(f"with the app, PyTorch not counted: {size_mb(place / 'env'):.0f} MB")
        browse(own / "corsmal", place=place, environment=environment)


def link_torch(packages: Path) -> None:
    """Link this environment's PyTorch, with the libraries that it loads, into another environment."""
    for distribution in importlib.metadata.distributions():
        if LINKED.match(distribution.metadata["Name"].lower()):
            for top in {file.parts[0] for file in distribution.files or () if file.parts[0] != ".."}:
                source, target = Path(str(distribution.locate_file(top))), packages / top
                if source.exists() and not target.exists():
                    target.symlink_to(source)


def size_mb(folder: Path) -> float:
    """What the files in a folder take, without what is linked."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


def browse(command: Path, *, place: Path, environment: dict[str, str]) -> None:
    """Start the app by its command and look at the demo's Overview."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    began_s = time.monotonic()
    arguments = [str(command), "app", "--no-browser", "--port", str(port)]
    with subprocess.Popen(arguments, cwd=place, env=environment) as server, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=CHROMIUM)
        try:
            page = browser.new_page()
            while True:
                try:
                    page.goto(f"http://127.0.0.1:{port}/")
                    break
                except Exception:
                    if time.monotonic() - began_s > 60 or server.poll() is not None:
                        raise
                    time.sleep(0.5)
            expect(page.get_by_role("heading", name="Overview")).to_be_visible(timeout=60_000)
            expect(page.get_by_text("Capacity").first).to_be_visible(timeout=60_000)
            print(f"{time.monotonic() - began_s:6.1f} s  from the command to the demo's Overview in the browser")
        finally:
            browser.close()
            server.terminate()


if __name__ == "__main__":
    main()
