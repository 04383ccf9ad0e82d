import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.calibration import read_camera
from corsmal.dataset.truth import read_truth
from corsmal.errors import ArgumentError, FileError
from corsmal.stages import true_masks
from corsmal.synthetic.writing import files
from corsmal.synthetic.writing import worker as workers
from corsmal.synthetic.writing.dataset import write_demo
from corsmal.synthetic.writing.plan import demo_plan
from corsmal.synthetic.writing.worker import Task, Worker, run_tasks, start_ahead

SMALL = {"containers": (9, 2), "recordings_per_container": 1, "size": (64, 36), "workers": 0}


@pytest.fixture(scope="module")
def demo_root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("demo") / "demo"
    assert write_demo(root, **SMALL) == ("000000", "000001")
    return root


@pytest.fixture
def copied_root(demo_root: Path, tmp_path: Path) -> Path:
    shutil.copytree(demo_root, tmp_path / "demo")
    return tmp_path / "demo"


def snapshot(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def test_the_library_reads_it_like_any_other_dataset(demo_root):
    dataset = open_dataset(demo_root)
    assert dataset.problems == ()
    assert dataset.ids == ("000000", "000001")
    recording = dataset["000001"]
    assert recording.missing == ()
    assert recording.annotation.container == "small white cup"
    assert recording.annotation.capacity_ml == 185
    with recording.views["view3"].video() as video:
        frames = len(video)
        assert video.size == (64, 36)
        assert video.fps == 30
        assert video.codec == "h264"
    audio = recording.audio()
    assert audio.samples.shape[0] == 8
    assert audio.sample_rate_hz == 44_100
    assert audio.duration_s == pytest.approx(frames / 30, abs=1e-3)


def test_the_calibration_is_the_scenes(demo_root):
    scene = demo_plan(containers=(9, 2), recordings_per_container=1)[1].scene()
    camera = read_camera(demo_root / "view2" / "calib" / "000001.pickle")
    np.testing.assert_allclose(camera.projection, scene.cameras["view2"].projection)
    assert camera.size == (1280, 720)


def test_the_truth_tells_masks_pose_and_profile(demo_root):
    recording = open_dataset(demo_root)["000001"]
    truth, visible = read_truth(recording), true_masks(recording, "view3")
    amodal = true_masks(recording, "view3", kind="amodal")
    assert truth.profile_mm[0][-1] == 72
    assert visible.frames == tuple(range(len(truth.fill)))
    assert visible.size == (36, 64)
    detection = amodal[visible.frames[-1]]
    assert detection.labels.tolist() == [47]
    assert detection.scores.tolist() == [1.0]
    seen = [visible[frame].masks.any(axis=0) for frame in visible if len(visible[frame])]
    assert len(seen) > 50
    assert all(not (visible[frame].mask(0) & ~amodal[frame].mask(0)).any() for frame in visible if len(visible[frame]))


def test_the_box_has_no_profile(demo_root):
    assert read_truth(open_dataset(demo_root)["000000"]).profile_mm is None


def test_a_complete_demo_is_left_alone(copied_root):
    before, told = snapshot(copied_root), []
    assert write_demo(copied_root, **SMALL, progress=told.append) == ("000000", "000001")
    assert snapshot(copied_root) == before
    assert told[-1].fraction == 1
    assert told[-1].done == told[-1].total == 2


def test_what_was_cut_off_is_finished_with_the_same_result(copied_root, demo_root):
    (copied_root / "view3" / "rgb" / "000001.mp4").unlink()
    (copied_root / "truth" / "000001.json").unlink()
    half = copied_root / ".making" / "view3" / "rgb" / ".000001.0123.mp4"
    half.parent.mkdir(parents=True)
    half.write_bytes(b"half a video")
    write_demo(copied_root, **SMALL)
    after = snapshot(copied_root)
    assert set(after) == set(snapshot(demo_root))
    assert after["truth/000001.json"] == snapshot(demo_root)["truth/000001.json"]
    assert after["view3/rgb/000001.mp4"] == snapshot(demo_root)["view3/rgb/000001.mp4"]


def test_a_cancelled_call_keeps_whole_recordings_and_lists_only_those(tmp_path):
    told = []
    complete = write_demo(tmp_path, **SMALL, progress=told.append, cancelled=lambda: told[-1].done == 1)
    assert complete == ("000000",)
    assert open_dataset(tmp_path).ids == ("000000",)
    rows = json.loads((tmp_path / "ccm_demo_annotation.json").read_text(encoding="utf-8"))["annotations"]
    assert [row["id"] for row in rows] == [0]


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "demo").write_text("a file where the folder should be", encoding="utf-8")
    with pytest.raises(FileError, match=r"cannot be written .*choose another folder"):
        write_demo(tmp_path / "demo", **SMALL)


def test_a_full_disk_is_reported_in_one_sentence_and_leaves_nothing_half(tmp_path, monkeypatch):
    def full(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.soundfile, "write", full)
    with pytest.raises(FileError, match=r"000000\.wav: cannot be written \(No space left on device\); free the disk"):
        files.write_part(tmp_path, "000000", demo_plan()[0].scene(), "sound", size=(64, 36))
    assert not list((tmp_path / "audio").iterdir())


def test_a_folder_of_other_recordings_is_refused(tmp_path):
    (tmp_path / "view1" / "rgb").mkdir(parents=True)
    with pytest.raises(FileError, match="holds recordings that are not the demo's"):
        write_demo(tmp_path, **SMALL)


def test_a_demo_of_other_settings_is_refused(demo_root):
    with pytest.raises(FileError, match="made with other settings"):
        write_demo(demo_root, **SMALL | {"seed": 1})


@pytest.mark.parametrize("arguments", [{"workers": -1}, {"size": (63, 36)}, {"size": (8, 4)}])
def test_arguments_that_cannot_be_are_refused(arguments, tmp_path):
    with pytest.raises(ArgumentError, match="must"):
        write_demo(tmp_path, **SMALL | arguments)


def test_tasks_are_done_by_the_processes_that_were_started_ahead(tmp_path, monkeypatch):
    started = []

    class Counted(Worker):
        def __init__(self, number, folder):
            super().__init__(number, folder)
            started.append(number)

    monkeypatch.setattr(workers, "Worker", Counted)
    monkeypatch.setattr(workers, "usual_processes", lambda: 1)
    start_ahead(tmp_path / "ahead")
    planned, done = demo_plan(containers=(9, 2), recordings_per_container=1)[1], []
    task = Task(planned, ("sound",), str(tmp_path / "made"), (64, 36))
    run_tasks([task], processes=1, note=done.append, cancelled=lambda: False)
    assert started == [0]
    assert done == [task]
    run_tasks([task], processes=1, note=done.append, cancelled=lambda: False)
    assert started == [0, 0]


def test_a_worker_process_makes_the_same_and_reports_what_fails(tmp_path, demo_root):
    planned = demo_plan(containers=(9, 2), recordings_per_container=1)[1]
    (tmp_path / "file").write_text("", encoding="utf-8")
    worker = Worker(0, tmp_path / "kernels")
    try:
        worker.run(Task(planned, ("sound",), str(tmp_path / "made"), (64, 36)))
        with pytest.raises(FileError, match="cannot be written"):
            worker.run(Task(planned, ("sound",), str(tmp_path / "file"), (64, 36)))
    finally:
        worker.close()
    assert (tmp_path / "made/audio/000001.wav").read_bytes() == (demo_root / "audio/000001.wav").read_bytes()
