import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.dataset.calibration import read_camera
from corsmal.errors import ArgumentError, CorsmalError, FileError, NotFoundError
from corsmal.stages.true_masks import true_masks
from corsmal.synthetic.writing import recording as recording_files
from corsmal.synthetic.writing.dataset import write_demo
from corsmal.synthetic.writing.plan import plan_recordings

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


def truth_of(root: Path, recording_id: str) -> dict:
    return json.loads((root / "truth" / f"{recording_id}.json").read_text(encoding="utf-8"))


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
    scene = plan_recordings(containers=(9, 2), recordings_per_container=1)[1].scene()
    camera = read_camera(demo_root / "view2" / "calib" / "000001.pickle")
    np.testing.assert_allclose(camera.projection, scene.cameras["view2"].projection)
    assert camera.size == (1280, 720)


def test_the_truth_tells_masks_pose_and_profile(demo_root):
    recording = open_dataset(demo_root)["000001"]
    truth, visible = truth_of(demo_root, "000001"), true_masks(recording, "view3")
    amodal = true_masks(recording, "view3", kind="amodal")
    assert truth["profile"]["outer_heights_mm"][-1] == 72
    assert np.array(truth["rotation"]).shape == (truth["frames"], 3, 3)
    assert visible.frames == tuple(range(len(truth["fill"])))
    assert visible.size == (36, 64)
    detection = amodal[visible.frames[-1]]
    assert detection.labels.tolist() == [47]
    assert detection.scores.tolist() == [1.0]
    seen = [visible[frame].masks.any(axis=0) for frame in visible if len(visible[frame])]
    assert len(seen) > 50
    assert all(not (visible[frame].mask(0) & ~amodal[frame].mask(0)).any() for frame in visible if len(visible[frame]))


def test_the_box_has_no_profile(demo_root):
    assert truth_of(demo_root, "000000")["profile"] is None


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

    monkeypatch.setattr(recording_files.soundfile, "write", full)
    with pytest.raises(FileError, match=r"000000\.wav: cannot be written \(No space left on device\); free the disk"):
        recording_files.write_part(tmp_path, "000000", plan_recordings()[0].scene(), "sound", size=(64, 36))
    assert not list((tmp_path / "audio").iterdir())


@pytest.mark.parametrize("fault", ["video", "compiler"])
def test_a_disk_that_fills_up_leaves_whole_parts_and_nothing_else(tmp_path, monkeypatch, fault):
    def half(path, *_arguments, **_options):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.with_name(f".{path.name}").write_bytes(b"half a video")
        raise OSError(28, "No space left on device")

    def full(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recording_files, *{"video": ("_write_view", half), "compiler": ("render_frame", full)}[fault])
    with pytest.raises(CorsmalError, match=r"cannot be written \(No space left on device\); free the disk or choose"):
        write_demo(tmp_path, **SMALL)
    assert sorted(path for path in snapshot(tmp_path) if not path.startswith(".making/kernels")) == ["truth/demo.json"]
    assert not list((tmp_path / ".making").glob("begun-*"))


def test_a_folder_of_other_recordings_is_refused(tmp_path):
    (tmp_path / "view1" / "rgb").mkdir(parents=True)
    with pytest.raises(FileError, match="holds recordings that are not the demo's"):
        write_demo(tmp_path, **SMALL)


def test_a_demo_of_other_settings_is_refused(demo_root):
    with pytest.raises(FileError, match="made with other settings"):
        write_demo(demo_root, **SMALL | {"seed": 1})


@pytest.mark.parametrize("arguments", [{"workers": -1}, {"frame_step": 0}, {"size": (63, 36)}, {"size": (8, 4)}])
def test_arguments_that_cannot_be_are_refused(arguments, tmp_path):
    with pytest.raises(ArgumentError, match="must"):
        write_demo(tmp_path, **SMALL | arguments)


def test_processes_make_the_same_and_tell_how_long_the_rest_takes(tmp_path, demo_root):
    told = []
    assert write_demo(tmp_path, **SMALL | {"workers": 2}, progress=told.append) == ("000000", "000001")
    assert snapshot(tmp_path) == snapshot(demo_root)
    fractions = [progress.fraction for progress in told]
    assert fractions == sorted(fractions)
    assert (told[-1].done, fractions[0], fractions[-1]) == (2, 0, 1)
    assert [progress.left_s for progress in told[:2]] == [None, None]
    assert all(progress.left_s > 0 for progress in told[2:-1])
    assert told[-1].left_s == 0


def test_only_the_recordings_that_are_named_are_made(tmp_path, demo_root):
    assert write_demo(tmp_path, **SMALL, ids=["000001"]) == ("000001",)
    made, expected = snapshot(tmp_path), snapshot(demo_root)
    assert made["view1/rgb/000001.mp4"] == expected["view1/rgb/000001.mp4"]
    assert not any("000000" in name for name in made)
    with pytest.raises(NotFoundError, match="the demo has no recording '000007': it has 2, 000000 to 000001"):
        write_demo(tmp_path, **SMALL, ids=["000007"])
    assert write_demo(tmp_path, **SMALL) == ("000000", "000001")
    assert snapshot(tmp_path) == expected


def test_a_compact_recording_takes_less_room_and_sounds_the_same(tmp_path, demo_root):
    write_demo(tmp_path, **SMALL, ids=["000001"], compact=True)
    plain, compact = open_dataset(demo_root)["000001"], open_dataset(tmp_path)["000001"]
    assert compact.missing == ()
    assert compact.audio_path.suffix == ".flac"
    assert compact.audio_path.stat().st_size < plain.audio_path.stat().st_size / 2
    np.testing.assert_allclose(compact.audio().samples, plain.audio().samples, atol=1.01 / 2**15)  # rounded otherwise
    path = compact.views["view3"].video_path
    assert path.stat().st_size < plain.views["view3"].video_path.stat().st_size
    with compact.views["view3"].video() as video, plain.views["view3"].video() as expected:
        assert len(video) == len(expected)
        assert np.abs(video[50].astype(float) - expected[50]).mean() < 5
    assert snapshot(tmp_path / "truth" / "visible") == {
        name: content for name, content in snapshot(demo_root / "truth" / "visible").items() if "000001" in name
    }
    with pytest.raises(FileError, match="made with other settings"):
        write_demo(tmp_path, **SMALL)


def test_a_piece_that_cannot_be_made_ends_the_call(tmp_path):
    (tmp_path / ".making").mkdir()
    (tmp_path / ".making" / "view3").write_text("a file where a folder should be", encoding="utf-8")
    with pytest.raises(CorsmalError, match=r"000000\.pickle: cannot be written .*; free the disk"):
        write_demo(tmp_path, **SMALL)


def test_data_to_train_on_has_fewer_frames_and_all_of_the_sound(tmp_path):
    write_demo(tmp_path, **SMALL | {"containers": (9,)}, training=True, frame_step=30)
    [planned] = plan_recordings(containers=(9,), recordings_per_container=1, training=True)
    scene, recording = planned.scene(), open_dataset(tmp_path)["000000"]
    frames = len(range(0, scene.frames, 30))
    with recording.views["view3"].video() as video:
        assert (len(video), video.fps) == (frames, 1)
    truth = truth_of(tmp_path, "000000")
    np.testing.assert_allclose(truth["base_m"], scene.motion.base_m[::30], atol=1e-6)
    assert true_masks(recording, "view1").frames == tuple(range(frames))
    assert recording.audio().duration_s == pytest.approx(scene.duration_s, abs=1e-3)
    with pytest.raises(FileError, match="made with other settings"):
        write_demo(tmp_path, **SMALL | {"containers": (9,)}, training=True)
