"""A recording for the viewer, opened by the viewer's own program."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError
from corsmal.exchange import write_rerun
from corsmal.filling import FillingPrediction
from corsmal.stages.detections import load_detections
from corsmal.store import Store

pytest.importorskip("rerun", reason="needs the extra exchange")


def viewer(*arguments: str | Path) -> str:
    program = Path(sys.executable).with_name("rerun")
    command = [str(program if program.is_file() else shutil.which("rerun")), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout


@pytest.fixture(scope="module")
def recording(tiny_dataset_root):
    return open_dataset(tiny_dataset_root)["000000"]


@pytest.fixture(scope="module")
def written(recording, tmp_path_factory):
    folder = tmp_path_factory.mktemp("rerun")
    detections = load_detections(recording, store=Store(folder / "cache")).views
    logits = np.array([0.0, 0.0, 4.0, 0.0]), np.array([0.0, 4.0, 0.0])
    heard = (FillingPrediction(*logits, steps_s=0.02, rows=(0, 50)),)
    write_rerun(recording, detections, folder / "recording.rrd", heard=heard)
    return folder / "recording.rrd"


def test_the_viewer_s_program_finds_nothing_wrong(written):
    viewer("rrd", "verify", written)


def test_cameras_pictures_masks_hull_and_sound_are_in_it(written):
    text = viewer("rrd", "print", "-vv", written)
    for name in ("view1", "view2", "view3"):
        assert f"/world/{name}/picture/masks" in text
    for name in ("/world/hull", "/capacity_ml", "/score", "/sound/type/rice", "/sound/level/half"):
        assert name in text


def test_nothing_to_show_is_refused(recording, tmp_path):
    with pytest.raises(ArgumentError, match="every"):
        write_rerun(recording, {}, tmp_path / "a.rrd")
