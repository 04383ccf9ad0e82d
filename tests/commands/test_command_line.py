import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import soundfile
from typer.testing import CliRunner

import corsmal.__main__ as cli
from corsmal import commands
from corsmal.dataset import open_dataset
from corsmal.engines import local
from corsmal.engines.tasks import open_detector
from corsmal.errors import ArgumentError, CorsmalError, FileError
from corsmal.estimation import estimate
from corsmal.evaluation import cell_table, error_table, read_estimates, typeset_table_2
from corsmal.filling import FillingPredictor, FillingTraining, FusedPredictor, FusedTraining
from corsmal.parameters import METHOD_VIEWS
from corsmal.stages.detections import POINTERS, load_detections
from corsmal.stages.settings import DetectorSettings
from corsmal.store import Store
from tests.fakes import FakeDetector
from tests.networks import write_networks
from tests.tiny import FRAMES, write_tiny_dataset

CALIBRATION = "view2/calib/000000.pickle"
RUNNER = CliRunner()
WITHOUT_FILES = "000002"


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "60")
    return tmp_path / "cache"


@pytest.fixture
def detector(monkeypatch):
    """What the commands detect with, in this process: a fake one, and what was asked for."""
    made = FakeDetector()
    made.asked = []

    def open_fake(settings, **_options):
        made.asked.append((settings.weights and settings.weights.name, settings.method))
        return made

    monkeypatch.setattr(DetectorSettings, "open", open_fake)
    monkeypatch.setattr(local, "default_workers", lambda: 1)
    open_detector.cache_clear()
    return made


def run_main(monkeypatch, capsys, *arguments):
    """What a person sees who types the command: the exit status and the lines."""
    monkeypatch.setattr(sys, "argv", ["corsmal", *map(str, arguments)])
    with pytest.raises(SystemExit) as stopped:
        cli.main()
    output = capsys.readouterr()
    return stopped.value.code, (output.out + output.err).strip().splitlines()


def test_progress_is_a_line_now_and_then_where_a_bar_cannot_move(monkeypatch, capsys):
    clock = iter([0, 10, 31, 40, 45, 50])
    monkeypatch.setattr(commands, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    with commands.progress_bar("recordings") as progress:
        for done in (1, 2, 3, 4, 4):
            progress(done, 4)
    assert capsys.readouterr().err.splitlines() == ["recordings: 2 of 4", "recordings: 4 of 4"]


def test_help_lists_the_commands():
    result = RUNNER.invoke(cli.app, ["--help"])
    assert result.exit_code == 0
    for command in ("demo", "detect", "estimate", "submit", "train", "evaluate"):
        assert f" {command} " in result.output
    assert " detector " in RUNNER.invoke(cli.app, ["train", "--help"]).output


def test_help_loads_no_network_library():
    program = (
        "import sys, runpy\n"
        "sys.argv = ['corsmal', '--help']\n"
        "try:\n"
        "    runpy.run_module('corsmal', run_name='__main__')\n"
        "finally:\n"
        "    sys.stderr.write(' '.join({'torch', 'lightning', 'streamlit', 'pandas'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert "detect" in done.stdout
    assert done.stderr == ""


def test_detections_are_kept_in_the_store(tiny_dataset_root, detector, cache):
    command = ["detect", str(tiny_dataset_root), WITHOUT_FILES, "--demo-weights", "--every", "10"]
    result = RUNNER.invoke(cli.app, command)
    assert result.exit_code == 0, result.output
    assert set(detector.asked) == {("detector.safetensors", "demo")}
    found = load_detections(open_dataset(tiny_dataset_root)[WITHOUT_FILES], store=Store(cache))
    for view in METHOD_VIEWS:  # 0 and 10, then 5, 3, 2 and 1 beside the best, which is the first of equals
        assert found.views[view].frames == (0, 1, 2, 3, 5, 10)
    assert "1 of 1" in result.output
    seen = detector.seen
    assert RUNNER.invoke(cli.app, command).exit_code == 0
    assert detector.seen == seen


@pytest.mark.usefixtures("detector")
def test_what_the_cache_cannot_read_is_printed_at_the_end(tiny_dataset_root, cache, tmp_path, monkeypatch, capsys):
    run_main(monkeypatch, capsys, "detect", tiny_dataset_root, WITHOUT_FILES)
    out = tmp_path / "e.csv"
    estimate = ("estimate", tiny_dataset_root, WITHOUT_FILES, "--workers", "1", "--out", out)
    code, lines = run_main(monkeypatch, capsys, *estimate)
    assert code == 0
    assert not any(line.startswith("Cache: ") for line in lines)
    damaged = [path for kind in POINTERS for path in (cache / kind).glob("*/*.json")]
    for path in damaged:
        path.unlink()
        os.mkfifo(path)
    code, lines = run_main(monkeypatch, capsys, *estimate)
    assert code == 0
    said = [line for line in lines if line.startswith("Cache: ")]
    assert len(said) == commands.COMPLAINTS_MAX + 1
    assert all(line.startswith(f"Cache: {cache}") and "cannot be read (is no file)" in line for line in said[:-1])
    assert said[-1] == f"Cache: {len(damaged) - commands.COMPLAINTS_MAX} more such problems"
    [row] = read_estimates(out).to_dict("records")
    assert "the detections that were kept cannot be read; run the detector again" in row["notes"]
    assert row["flags"] == "detections-incomplete"


def test_without_ids_all_recordings_are_inspected_but_views_with_a_file(tiny_dataset_root, detector):
    result = RUNNER.invoke(cli.app, ["detect", str(tiny_dataset_root)])
    assert result.exit_code == 0, result.output
    assert set(detector.asked) == {(None, "coco")}
    assert detector.seen == FRAMES * len(METHOD_VIEWS)


def test_a_recording_that_fails_is_named_and_the_others_are_inspected(tiny_dataset_root, detector, tmp_path):
    root = tmp_path / "set [/x]"
    for view in METHOD_VIEWS:
        folder = root / view / "rgb"
        folder.mkdir(parents=True)
        (folder / "000001.mp4").write_bytes(b"no video")
        (folder / "000002.mp4").symlink_to(tiny_dataset_root / view / "rgb" / "000002.mp4")
    result = RUNNER.invoke(cli.app, ["detect", str(root)])
    assert result.exit_code == 1
    assert detector.seen == FRAMES * len(METHOD_VIEWS)
    lines = result.output.splitlines()
    [line] = [line for line in lines if line.startswith("000001:")]
    assert str(root / "view2" / "rgb" / "000001.mp4") in line
    assert "1 of 2 recordings failed." in lines


def test_an_unknown_recording_is_one_sentence(tiny_dataset_root, detector, monkeypatch, capsys):
    code, lines = run_main(monkeypatch, capsys, "detect", tiny_dataset_root, "999999")
    assert code == 1
    [line] = lines
    assert line.startswith("Error: ")
    assert "999999" in line
    assert detector.seen == 0


def test_training_data_are_asked_for_by_options(tmp_path, monkeypatch, capsys):
    wanted = {}
    monkeypatch.setattr("corsmal.synthetic.write_demo", lambda folder, **options: wanted.update(options, root=folder))
    options = ("--training", "--frame-step", "30", "--recordings", "70", "--width", "320", "--container", "9")
    assert run_main(monkeypatch, capsys, "demo", tmp_path, *options)[0] == 0
    assert wanted.pop("progress")
    assert wanted == {
        "root": tmp_path,
        "training": True,
        "frame_step": 30,
        "recordings_per_container": 70,
        "containers": [9],
        "size": (320, 180),
        "seed": 0,
        "workers": None,
    }


@pytest.mark.parametrize("name", ["demo", "[bold]demo[/bold]", "[/]"])
def test_a_demo_that_cannot_be_written_is_one_sentence(tmp_path, monkeypatch, capsys, name):
    (tmp_path / "file").write_bytes(b"")
    code, lines = run_main(monkeypatch, capsys, "demo", tmp_path / "file" / name)
    assert code == 1
    errors = [line for line in lines if line.startswith("Error: ")]
    assert len(errors) == 1
    assert str(tmp_path / "file" / name) in errors[0]
    assert "cannot be written" in errors[0]
    assert not any("Traceback" in line for line in lines)


@pytest.mark.usefixtures("detector")
@pytest.mark.parametrize("arguments", [["--every", "0"], ["--nonsense"], ["--weights"]])
def test_options_that_cannot_be_are_refused_with_what_is_possible(tiny_dataset_root, arguments):
    result = RUNNER.invoke(cli.app, ["detect", str(tiny_dataset_root), *arguments])
    assert result.exit_code == 2
    assert arguments[0] in result.output


def test_training_cannot_write_beneath_a_file(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_bytes(b"")
    code, lines = run_main(monkeypatch, capsys, "train", "detector", tmp_path / "file" / "run", "--steps", "1")
    assert code == 1
    [line] = [line for line in lines if line.startswith("Error: ")]
    assert str(Path(tmp_path, "file", "run")) in line


def test_weights_of_the_users_choice_are_opened(tmp_path, monkeypatch, capsys, tiny_dataset_root):
    path = tmp_path / "weights.safetensors"
    path.write_bytes(b"none")
    for options in (["--demo-weights"], []):
        code, lines = run_main(monkeypatch, capsys, "detect", tiny_dataset_root, "--weights", path, *options)
        assert code == 1
        [line] = lines
        assert line.startswith(f"Error: {path}: ")


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    """Files of untrained networks, as the options name them."""
    paths = write_networks(tmp_path_factory.mktemp("networks"))
    return ["--filling", paths["filling"], "--mass", paths["mass"]]


def test_estimates_are_a_table_that_is_judged_and_submitted(tiny_dataset_root, networks, tmp_path):
    table = tmp_path / "estimates.parquet"
    made = RUNNER.invoke(cli.app, ["estimate", str(tiny_dataset_root), "--out", str(table), *map(str, networks)])
    assert made.exit_code == 0, made.output
    rows = read_estimates(table).set_index("recording_id")
    assert rows.loc["000000", "status"] == "fitted"
    alone = estimate(open_dataset(tiny_dataset_root)["000000"])
    assert rows.loc["000000", "capacity_ml"] == alone.capacity_ml
    judged = RUNNER.invoke(
        cli.app, ["evaluate", "estimates", str(tiny_dataset_root), str(table), "--out", str(tmp_path / "table.csv")]
    )
    assert judged.exit_code == 0, judged.output
    assert "By container" in judged.output
    errors = error_table(read_estimates(table), open_dataset(tiny_dataset_root).table)
    cells = cell_table(errors, rng=np.random.default_rng(0))
    assert (tmp_path / "table.csv").read_text() == typeset_table_2(cells, table_format="csv")
    sent = RUNNER.invoke(cli.app, ["submit", str(tiny_dataset_root), str(table), str(tmp_path / "sent.csv")])
    assert sent.exit_code == 0, sent.output
    assert len(pd.read_csv(tmp_path / "sent.csv")) == len(rows)


def test_unknown_preset_and_format_are_refused(tiny_dataset_root, networks, tmp_path):
    command = ["estimate", str(tiny_dataset_root), *map(str, networks)]
    unknown = RUNNER.invoke(cli.app, [*command, "--preset", "best"])
    assert unknown.exit_code == 2
    assert "available presets: paper" in " ".join(unknown.output.replace("│", " ").split())
    with pytest.raises(CorsmalError, match=r"estimates\.txt"):
        RUNNER.invoke(cli.app, [*command, "--out", str(tmp_path / "estimates.txt")], catch_exceptions=False)


def test_released_estimates_have_their_own_pairs_and_selection(tiny_dataset_root, networks, tmp_path):
    out = tmp_path / "written.csv"
    command = ["estimate", str(tiny_dataset_root), "000000", "--preset", "released", "--out", str(out)]
    command += ["--workers", "1", *map(str, networks)]
    assert RUNNER.invoke(cli.app, command).exit_code == 0
    assert read_estimates(out)["pair"].tolist() == ["view1 + view2"]
    pairs = ["--pairs", "view2-view3,view1-view2", "--selection", "paper"]
    assert RUNNER.invoke(cli.app, [*command, *pairs]).exit_code == 0
    assert read_estimates(out)["pair"].tolist() == ["view2 + view3"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--pairs", "view1-view9"], "pairs must each be two of view1, view2, view3, got 'view1-view9'"),
        (["--pairs", "view1-view2,view2-view1"], "pairs must differ"),
        (["--selection", "best"], "available presets: paper, released"),
    ],
)
def test_unknown_pairs_and_selections_are_refused(tiny_dataset_root, options, said):
    result = RUNNER.invoke(cli.app, ["estimate", str(tiny_dataset_root), *options])
    assert result.exit_code == 2
    assert said in " ".join(result.output.replace("│", " ").split())


def test_released_training_leaves_out_silence_and_the_recording_that_was_not_stopped(tmp_path, monkeypatch):
    root = write_tiny_dataset(tmp_path / "data", recordings=12, frames=2)
    soundfile.write(root / "audio" / "000004.wav", np.zeros((44_100, 8), np.int16), 44_100)
    path = root / "ccm_tiny_annotation.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    for row in content["annotations"]:
        row["filling type"], row["filling level"] = ((0, 0), (1, 1), (2, 2), (3, 1))[row["id"] // 2 % 4]
    path.write_text(json.dumps(content), encoding="utf-8")
    command = ["train", "filling", str(root), str(tmp_path / "run"), "--preset", "released", "--epochs", "1"]
    dataset = open_dataset(root)
    dataset._recordings["000005"] = replace(dataset["000005"], sound_end_s=0.5)
    monkeypatch.setattr("corsmal.dataset.open_dataset", lambda _root: dataset)
    result = RUNNER.invoke(cli.app, command)
    assert result.exit_code == 0, result.output
    said = " ".join(result.output.split())
    assert "000004: the sound is silent in a microphone at 0.00 s" in said
    assert "000005: its recorder was not stopped: the authors' program does not train on it" in said
    seen = FillingPredictor(tmp_path / "run" / "filling.safetensors").trained_on.recordings
    assert {"000004", "000005"}.isdisjoint(seen)


def test_a_wall_is_learnt_and_estimated_with(tiny_dataset_root, networks, tmp_path):
    learnt = RUNNER.invoke(cli.app, ["train", "wall", str(tiny_dataset_root)])
    assert learnt.exit_code == 0, learnt.output
    assert "--preset tuned --wall" in " ".join(learnt.output.split())
    rows = {}
    for wall in ("0", "5"):
        out = tmp_path / f"{wall}.csv"
        command = ["estimate", str(tiny_dataset_root), "000000", "--preset", "tuned", "--wall", wall, "--out", str(out)]
        made = RUNNER.invoke(cli.app, [*command, *map(str, networks)])
        assert made.exit_code == 0, made.output
        rows[wall] = read_estimates(out).iloc[0]
    assert rows["0"]["capacity_ml"] > rows["5"]["capacity_ml"] + 50
    assert rows["0"]["height_mm"] == rows["5"]["height_mm"]


@pytest.fixture
def listened(tmp_path):
    """A folder with an annotation of twelve recordings of three containers, and one with arrays of them."""
    rng = np.random.default_rng(0)
    pairs = [(0, 0), (1, 1), (2, 2), (3, 1)]
    rows = [
        {"id": index, "container id": 1 + index % 3, "filling type": pair[0], "filling level": pair[1]}
        for index, pair in enumerate(pairs * 3)
    ]
    (tmp_path / "set" / "view1" / "rgb").mkdir(parents=True)
    (tmp_path / "set" / "ccm_train_annotation.json").write_text(json.dumps({"annotations": rows}), encoding="utf-8")
    (tmp_path / "features").mkdir()
    for row in rows:
        np.save(tmp_path / "features" / f"{row['id']:06d}.npy", rng.normal(size=(3, 128)).astype(np.float32))
    return [str(tmp_path / "set"), str(tmp_path / "run"), "--features", str(tmp_path / "features")]


def test_filling_is_cross_validated_and_its_tables_are_shown(listened, monkeypatch):
    quick = replace(FillingTraining.paper(), epochs=1)
    monkeypatch.setattr(FillingTraining, "of", classmethod(lambda *_: quick))
    result = RUNNER.invoke(cli.app, ["evaluate", "filling", *listened, "--folds", "containers"])
    assert result.exit_code == 0, result.output
    for title in ("Weighted F1 in %", "MPF1 in % by container", "filling type, cup"):
        assert title in result.output


def test_filling_is_trained_to_a_file_that_predicts(listened, monkeypatch):
    quick = replace(FillingTraining.tuned(), epochs=1)
    monkeypatch.setattr(FillingTraining, "of", classmethod(lambda *_: quick))
    result = RUNNER.invoke(cli.app, ["train", "filling", *listened])
    assert result.exit_code == 0, result.output
    path = Path(result.output.split("Weights: ")[1].strip())
    assert FillingPredictor(path).predict(np.zeros((1, 3, 128), np.float32)).ok


@pytest.fixture
def listened_and_watched(listened, tmp_path, monkeypatch):
    """The same with arrays of the three views as well; networks are small and train for one epoch."""
    (tmp_path / "watched").mkdir()
    for index in range(12):
        array = np.random.default_rng(index).normal(size=(3, 4, 512)).astype(np.float16)
        np.save(tmp_path / "watched" / f"{index:06d}.npy", array)
    whole = FusedTraining()
    small = {
        name: replace(group, networks=(replace(group.networks[0], hidden=4),), epochs=1)
        for name, group in whole.groups.items()
    }
    tiny = replace(whole, sound=(small["sound0"], small["sound1"]), sight=small["sight"])
    monkeypatch.setattr("corsmal.filling.FusedTraining", lambda: tiny)
    return [*listened, "--features", str(tmp_path / "watched"), "--preset", "fused"]


def test_fused_network_is_trained_to_a_file_that_predicts_from_either_sense(listened_and_watched):
    result = RUNNER.invoke(cli.app, ["train", "filling", *listened_and_watched])
    assert result.exit_code == 0, result.output
    predictor = FusedPredictor(Path(result.output.split("Weights: ")[1].strip()))
    heard, watched = np.zeros((1, 3, 128), np.float32), np.ones((3, 4, 512), np.float32)
    assert predictor.predict(heard).ok
    assert predictor.predict(None, sight=watched).ok
    assert predictor.predict(heard, sight=watched).ok
    assert len(predictor.trained_on.recordings) == 12


def test_fused_network_is_cross_validated_with_either_sense_missing(listened_and_watched):
    result = RUNNER.invoke(cli.app, ["evaluate", "filling", *listened_and_watched, "--folds", "containers"])
    assert result.exit_code == 0, result.output
    for part in ("sound only", "sight only", "both noisy", "not calibrated", "calibration_error"):
        assert part in result.output


def test_fused_network_needs_both_senses_and_one_folder_of_each(listened, listened_and_watched):
    root, run, *features = listened_and_watched
    with pytest.raises(ArgumentError, match="sound and of sight"):
        RUNNER.invoke(cli.app, ["train", "filling", *listened, "--preset", "fused"], catch_exceptions=False)
    with pytest.raises(FileError, match="holds features of sound, as does"):
        RUNNER.invoke(cli.app, ["train", "filling", root, run, *features[:2], *features], catch_exceptions=False)
    refused = RUNNER.invoke(cli.app, ["train", "filling", *listened_and_watched, "--retrain"])
    assert refused.exit_code == 2


def test_doctor_finds_nothing_wrong_with_what_is_whole(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=3)
    result = RUNNER.invoke(cli.app, ["doctor", str(root), "--workers", "1"])
    assert result.exit_code == 0, result.output
    for part in (
        "1 recordings",
        "every file can be read",
        "of the image width",
        "mass weights",
        "GPU: ",
        "no problems",
    ):
        assert part in result.output


@pytest.mark.skipif(any(Path(device).exists() for device in local.GPU_DEVICES), reason="PyTorch is asked for its GPU")
def test_doctor_of_the_headers_does_not_load_pytorch(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=3)
    program = (
        "import sys; from corsmal.__main__ import app\n"
        f"try: app(['doctor', {str(root)!r}, '--workers', '1'])\n"
        "finally: print('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-2:] == ["no problems", "False"], done.stderr


@pytest.mark.usefixtures("blocked_cache")
def test_doctor_names_what_is_broken_or_missing(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=3, frames=3)
    (root / "view1" / "calib" / "000000.pickle").write_bytes(b"broken")
    result = RUNNER.invoke(cli.app, ["doctor", str(root), "--workers", "1"])
    assert result.exit_code == 1, result.output
    problems = [line for line in result.output.splitlines() if line.startswith("!")]
    assert len(problems) == 4
    assert f"{len(problems)} problems" in result.output
    for part in ("view2 video is missing in 1 recording: 000001", "audio is missing", "000000.pickle", "file/cache"):
        assert any(part in line for line in problems), part


def test_doctor_lists_findings_as_json_with_severity_file_and_advice(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=1, frames=3)
    (root / "view1" / "rgb" / "000000 (1).mp4").touch()
    (root / "audio" / "-1.wav").touch()
    (root / "view2" / "calib" / "000000.pickle").write_bytes(b"broken")
    (root / "view3" / "rgb" / "000000.mp4").rename(root / "view3" / "rgb" / "0.MP4")
    result = RUNNER.invoke(cli.app, ["doctor", str(root), "--workers", "1", "--json", "--deep"])
    assert result.exit_code == 1, result.output
    entries = json.loads(result.stdout)
    found = {entry["file"]: entry for entry in entries}
    copy, sound, calibration = (found[name] for name in ("view1/rgb/000000 (1).mp4", "audio/-1.wav", CALIBRATION))
    assert (copy["severity"], copy["kind"], copy["recording"]) == ("warning", "unused", "000000")
    assert copy["advice"] == "rename it to 000000.mp4 if it is the one to use"
    assert (sound["severity"], sound["recording"]) == ("warning", "")
    assert (calibration["severity"], calibration["kind"], calibration["recording"]) == (
        "error",
        "calibration",
        "000000",
    )
    assert any("named otherwise than the recording's id, such as 0.MP4" in entry["what"] for entry in entries)


@pytest.mark.usefixtures("blocked_cache")
def test_a_store_that_cannot_be_written_is_one_sentence_before_the_work_begins(tiny_dataset_root, networks, tmp_path):
    with pytest.raises(CorsmalError, match="cannot be written"):
        RUNNER.invoke(cli.app, ["detect", str(tiny_dataset_root), "--demo-weights"], catch_exceptions=False)
    command = ["estimate", str(tiny_dataset_root), "000000", "--out", str(tmp_path / "table.csv"), *map(str, networks)]
    result = RUNNER.invoke(cli.app, command)
    assert result.exit_code == 0, result.output
    assert "Results will not be stored" in result.output
    assert len(read_estimates(tmp_path / "table.csv")) == 1


@pytest.fixture
def blocked_cache(tmp_path, monkeypatch):
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("CORSMAL_CACHE", str(tmp_path / "file" / "cache"))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--scheduler", "tcp://127.0.0.1:1"], "needs --engine dask"),
        (
            ["--engine", "dask", "--scheduler", "tcp://127.0.0.1:1", "--workers", "2"],
            "determines its own number",
        ),
        (["--engine", "cloud"], "cloud"),
        (["--workers", "0"], "--workers"),
    ],
)
def test_engines_that_cannot_be_are_refused(tiny_dataset_root, networks, options, said):
    result = RUNNER.invoke(cli.app, ["estimate", str(tiny_dataset_root), *map(str, networks), *options])
    assert result.exit_code == 2
    assert said in " ".join(result.output.replace("│", " ").split())


def test_a_gpu_is_used_by_one_process(tiny_dataset_root, detector, monkeypatch):
    monkeypatch.setattr(local, "has_gpu", lambda: True)
    monkeypatch.setattr(local, "default_workers", lambda: 8)
    assert RUNNER.invoke(cli.app, ["detect", str(tiny_dataset_root)]).exit_code == 0
    assert detector.seen  # here: in this process
    refused = RUNNER.invoke(cli.app, ["detect", str(tiny_dataset_root), "--workers", "2"])
    assert refused.exit_code == 2
    assert "only one process can use the GPU" in " ".join(refused.output.replace("│", " ").split())
