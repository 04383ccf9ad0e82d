"""Every writer on a disk that fills up: one sentence, the older file as it was, and nothing half or hidden beside it.

Where the tests may mount one, the disk is a small one; elsewhere no file may grow beyond a few kilobytes.
"""

import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from corsmal.__main__ import main
from corsmal.by_hand.log import Log
from corsmal.dataset import open_dataset
from corsmal.demo.opening import demo_folder, open_demo
from corsmal.detection import Detections, ViewDetections, coco_weights, write_coco_results
from corsmal.errors import CorsmalError, FileError
from corsmal.evaluation import read_estimates, submission_table, write_estimates, write_submission
from corsmal.figures.pin_collections import add_pins, load_collection
from corsmal.figures.pins import Pin
from corsmal.mass import MassConfig, MassModel, save_mass
from corsmal.store import Store
from corsmal.synthetic.writing.dataset import write_demo
from corsmal.ui.media import playable_video
from tests.test_store import KEY, KINDS, some_view
from tests.tiny import write_json, write_tiny_dataset, write_video

LEFT_BYTES = 8192
FULL = r"(cannot be written|could not be kept|cannot be kept|is full).*(No space left on device|File too large)"
DISK_MB = 2


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a disk of 2 MB, or one where files stay small."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK_MB}m", "tmpfs", str(folder)]
    is_allowed = sys.platform == "linux" and os.geteuid() == 0 and shutil.which("mount") is not None
    is_mounted = is_allowed and not subprocess.run(mount, check=False, capture_output=True).returncode
    yield folder
    if is_mounted:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.fixture
def fill(disk: Path) -> Iterator[Callable[..., None]]:
    """Fills the disk but for some kilobytes, or as many bytes as are named."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    def fill_up(left_bytes: int = LEFT_BYTES) -> None:
        if os.path.ismount(disk):
            free = os.statvfs(disk)
            (disk / "others").write_bytes(bytes(free.f_bavail * free.f_bsize - left_bytes))
        else:
            resource.setrlimit(resource.RLIMIT_FSIZE, (left_bytes, before[1]))

    yield fill_up
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def files(folder: Path) -> dict[str, bytes]:
    found = (path for path in folder.rglob("*") if path.is_file() and path.name != "others")
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


def big_table(rows: int = 400) -> pd.DataFrame:
    """An estimates table that no disk of these tests holds."""
    notes = np.random.default_rng(0).bytes(64 * rows).hex()
    return pd.DataFrame(
        {"recording_id": f"{number:06d}", "notes": notes[128 * number : 128 * (number + 1)]} for number in range(rows)
    )


WRITERS: dict[str, Callable[[Path, int], object]] = {
    "e.csv": lambda path, size: write_estimates(big_table(size), path),
    "e.json": lambda path, size: write_estimates(big_table(size), path),
    "e.parquet": lambda path, size: write_estimates(big_table(size), path),
    "s.csv": lambda path, size: write_submission(submission_table(big_table(size)), path),
    "d.json": lambda path, size: write_coco_results(some_view() if size < 100 else large_view(), path),
}


def large_view() -> ViewDetections:
    rng = np.random.default_rng(0)
    masks = rng.random((40, 60, 80)) < 0.5
    boxes = np.tile([[0.0, 0.0, 80.0, 60.0]], (40, 1))
    return ViewDetections(
        {0: Detections(boxes, np.full(40, 0.9), np.full(40, 47), masks)}, size=(60, 80), source="a test"
    )


@pytest.mark.parametrize("name", WRITERS)
def test_tables_and_detections(disk, fill, name):
    WRITERS[name](disk / name, 4)
    before = files(disk)
    fill()
    with pytest.raises(CorsmalError, match=FULL) as caught:
        WRITERS[name](disk / name, 400)
    assert "\n" not in str(caught.value)
    assert files(disk) == before


def test_networks(disk, fill):
    fill()
    with pytest.raises(CorsmalError, match=r"cannot be written"):
        save_mass(disk / "mass.safetensors", MassModel(MassConfig.paper()))
    assert files(disk) == {}


LARGE = {
    ".json": lambda store, key: store.save_json("fits", key, {"a": list(range(9000))}),
    ".npz": lambda store, key: store.save_arrays("hulls", key, a=np.random.default_rng(0).random(9000)),
    ".parquet": lambda store, _key: KINDS[".parquet"][0](store, large_view()),
}


@pytest.mark.parametrize("suffix", LARGE)
def test_the_store(disk, fill, suffix):
    store = Store(disk / "cache")
    KINDS[suffix][0](store)
    before = files(disk)
    fill()
    assert LARGE[suffix](store, KEY) is False
    [problem] = store.problems
    assert "cannot be written" in problem
    assert "\n" not in problem
    assert files(disk) == before
    assert KINDS[suffix][1](store) is not None


def test_pins(disk, fill):
    store = Store(disk / "cache")
    add_pins("mine", [Pin("one", content=b"x", medium="image/png")], dataset="d", store=store)
    before = files(disk)
    fill()
    with pytest.raises(CorsmalError, match=FULL):
        add_pins("mine", [Pin("two", content=bytes(50_000), medium="image/png")], dataset="d", store=store)
    assert files(disk) == before
    assert [pin.title for pin in load_collection("mine", dataset="d", store=store).pins] == ["one"]


def test_opening_the_demo(disk, fill):
    fill()
    store = Store(disk / "cache")
    with pytest.raises(CorsmalError, match=FULL):
        open_demo(store=store)
    assert not [name for name in files(disk) if Path(name).name.startswith(".")]
    assert not (demo_folder(store) / "truth" / "pack.json").exists()


@pytest.mark.parametrize("workers", [0, 2])
def test_making_the_demo(disk, fill, workers):
    fill()
    with pytest.raises(CorsmalError, match=r"(cannot be written|is full)") as caught:
        write_demo(disk / "demo", containers=(1,), recordings_per_container=1, size=(640, 360), workers=workers)
    assert "\n" not in str(caught.value)
    assert "unexpectedly" not in str(caught.value)
    left = [name for name in files(disk) if ".making/kernels" not in name]
    assert not [name for name in left if Path(name).name.startswith(".") or "begun-" in name]


def test_masks_by_hand(disk, fill):
    log = Log(disk / "log", lambda line: line["number"])
    line = {"number": 1, "words": "w" * 1000}
    assert log.append(lambda _: line) == 1
    fill(6 * 1024)

    def append_many() -> None:
        for number in range(2, 20):
            assert log.append(lambda _, number=number: line | {"number": number}) == number

    with pytest.raises(FileError, match=FULL):
        append_many()
    kept = log.items()
    assert kept == tuple(range(1, len(kept) + 1))
    (disk / "others").unlink(missing_ok=True)
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
    assert log.append(lambda _: line | {"number": 30}) == 30
    assert Log(disk / "log", lambda line: line["number"]).items() == (*kept, 30)


def test_the_copy_of_a_video_for_browsers(disk, fill, tmp_path):
    root = write_tiny_dataset(tmp_path / "train", recordings=1, frames=4)
    pictures = list(np.random.default_rng(0).integers(0, 255, (12, 360, 640, 3), dtype=np.uint8))
    write_video(root / "view1" / "rgb" / "000000.mp4", pictures, codec="mpeg4")
    fill()
    with pytest.raises(CorsmalError, match="cannot be written"):
        playable_video(open_dataset(root)["000000"].views["view1"], store=Store(disk / "cache"))
    assert files(disk) == {}


def test_downloads(disk, fill, monkeypatch, tmp_path):
    source = tmp_path / "weights.pth"
    source.write_bytes(bytes(100_000))
    monkeypatch.setattr(coco_weights, "COCO_WEIGHTS_URL", f"file://{source}")
    monkeypatch.setenv("CORSMAL_WEIGHTS", str(disk))
    fill()
    with pytest.raises(CorsmalError, match=r"(No space left on device|File too large)"):
        coco_weights.coco_weights()
    assert files(disk) == {}


@pytest.fixture
def run_command(monkeypatch, capsys, tmp_path):
    """Gives a command's exit status and the lines that it says, with a cache on a disk that has room."""
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("BROWSER_PATH", "/nonexistent")

    def run(*arguments: object) -> tuple[object, list[str]]:
        monkeypatch.setattr(sys, "argv", ["corsmal", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            main()
        return stopped.value.code, capsys.readouterr().err.splitlines()

    return run


@pytest.mark.parametrize("name", ["e.csv", "e.json", "e.parquet"])
def test_the_out_of_an_estimate(tiny_dataset_root, disk, fill, run_command, name):
    out = disk / name
    fill(0)
    code, said = run_command("estimate", tiny_dataset_root, "000000", "--workers", 1, "--out", out)
    assert code == 1
    assert [line for line in said if line.startswith(f"Error: {out}: cannot be written (")]
    assert not any("Traceback" in line for line in said)
    assert files(disk) == {}


def test_a_cache_that_is_full_costs_nothing_but_the_cache(tiny_dataset_root, disk, fill, run_command, monkeypatch):
    if not os.path.ismount(disk):
        pytest.skip("no disk may be mounted, so nothing can be written elsewhere either")
    monkeypatch.setenv("CORSMAL_CACHE", str(disk / "cache"))
    fill(0)
    out = disk.with_name("e.csv")
    code, said = run_command("estimate", tiny_dataset_root, "000000", "--workers", 1, "--out", out)
    assert code == 0
    assert any("Results will not be stored" in line for line in said)
    assert len(read_estimates(out)) == 1
    assert files(disk) == {}


def test_a_report(tiny_dataset_root, disk, fill, run_command, tmp_path):
    run_command("estimate", tiny_dataset_root, "--workers", 1, "--run", "r", "--out", tmp_path / "e.csv")
    fill()
    code, said = run_command("report", tiny_dataset_root, "r", "--out", disk / "report.html")
    assert code == 1
    assert [line for line in said if line.startswith(f"Error: {disk / 'report.html'}: cannot be written (")]
    assert files(disk) == {}


def test_a_training(disk, fill, run_command, tmp_path):
    root, arrays = tmp_path / "set", tmp_path / "arrays"
    (root / "view1" / "rgb").mkdir(parents=True)
    arrays.mkdir()
    rows = [
        {"id": index, "container id": 1 + index % 3, "filling type": index % 4, "filling level": min(index % 4, 2)}
        for index in range(12)
    ]
    write_json(root / "ccm_train_annotation.json", {"annotations": rows})
    rng = np.random.default_rng(0)
    for row in rows:
        np.save(arrays / f"{row['id']:06d}.npy", rng.normal(size=(3, 128)).astype(np.float32))
    fill()
    code, said = run_command("train", "filling", root, disk / "run", "--features", arrays, "--epochs", 1)
    assert code == 1
    assert len([line for line in said if line.startswith("Error: ")]) == 1
    assert not any("Traceback" in line for line in said)
    names = [Path(name).name for name in files(disk)]
    assert not [name for name in names if name.startswith(".") or name.endswith((".ckpt", ".safetensors"))]
