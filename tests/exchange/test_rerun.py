"""A recording for the viewer, opened by the viewer's own program."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile
from typer.testing import CliRunner

from corsmal import __main__ as cli
from corsmal.commands.exporting import _heard
from corsmal.dataset import open_dataset
from corsmal.errors import ArgumentError
from corsmal.exchange import write_rerun
from corsmal.filling import FillingPrediction, FillingPredictor, LogMelParameters, log_mel
from corsmal.filling.config import PooledConfig, RecurrentConfig
from corsmal.filling.fused import FusedConfig, FusedModel, save_fused
from corsmal.stages.detections import load_detections
from corsmal.store import Store
from tests.released import write_released

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


def exported(root, out, weights, monkeypatch):
    """What the viewer's program prints of what the command wrote, and what the command said."""
    monkeypatch.setenv("CORSMAL_FILLING_WEIGHTS", str(weights))
    result = CliRunner().invoke(cli.app, ["export", "rerun", str(root), "000000", str(out)])
    assert result.exit_code == 0, result.output
    return viewer("rrd", "print", "-vv", out), " ".join(result.output.split())


def test_the_authors_network_hears_with_its_own_front_end(tiny_dataset_root, recording, tmp_path, monkeypatch):
    weights = write_released(tmp_path)["filling"]
    text, _ = exported(tiny_dataset_root, tmp_path / "a.rrd", weights, monkeypatch)
    assert "/sound/type/rice" in text
    assert "/sound/level/half" in text
    rows = log_mel(recording.audio().samples, parameters=LogMelParameters.of("released"))
    row_s = LogMelParameters().row_s
    expected = FillingPredictor(weights).predict_windows(rows, window=round(1 / row_s), hop=round(0.25 / row_s))
    heard = _heard(recording)
    assert [window.rows for window in heard] == [window.rows for window in expected]
    for found, wanted in zip(heard, expected, strict=True):
        np.testing.assert_allclose(found.type_logits, wanted.type_logits, rtol=1e-5)


def test_a_network_without_an_answer_to_the_sound_costs_only_that(tiny_dataset_root, tmp_path, monkeypatch):
    fused = tmp_path / "fused.safetensors"
    save_fused(fused, FusedModel(FusedConfig((RecurrentConfig(hidden=2),), (PooledConfig(hidden=2),))))
    text, _ = exported(tiny_dataset_root, tmp_path / "a.rrd", fused, monkeypatch)
    assert "/world/hull" in text
    assert "/sound" not in text
    root = shutil.copytree(tiny_dataset_root, tmp_path / "silent")
    soundfile.write(root / "audio" / "000000.wav", np.zeros((44_100, 8), np.int16), 44_100)
    weights = write_released(tmp_path)["filling"]
    text, said = exported(root, tmp_path / "b.rrd", weights, monkeypatch)
    assert "/world/hull" in text
    assert "/sound" not in text
    assert "sound: the sound is silent in a microphone at 0.00 s" in said


def test_nothing_to_show_is_refused(recording, tmp_path):
    with pytest.raises(ArgumentError, match="every"):
        write_rerun(recording, {}, tmp_path / "a.rrd")
