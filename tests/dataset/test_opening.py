import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from corsmal.dataset import Recording, open_dataset
from corsmal.errors import FileError, NotFoundError
from tests.tiny import (
    CALIBRATED_SIZE,
    CONTAINERS,
    SIZE,
    capacity_ml,
    tiny_cameras,
    write_audio,
    write_calibration,
    write_json,
)


def _touch(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    return root


def test_tiny_dataset_says_what_each_recording_lacks(tiny_dataset_root: Path) -> None:
    dataset = open_dataset(tiny_dataset_root)
    assert [recording.id for recording in dataset] == ["000000", "000001", "000002"]
    assert len(dataset) == 3
    assert dataset.problems == ()
    assert [recording.missing for recording in dataset] == [(), ("view2 video", "audio"), ()]
    assert list(dataset["000001"].views) == ["view1", "view3"]
    assert dataset["000000"].views["view1"].detections_path is not None
    assert dataset["000002"].views["view1"].detections_path is None


@pytest.mark.parametrize("name", ["000001", 1, "1", np.int64(1).item()])
def test_recording_is_found_by_id_or_number(tiny_dataset_root: Path, name: str | int) -> None:
    dataset = open_dataset(tiny_dataset_root)
    assert dataset[name].id == "000001"
    assert name in dataset


@pytest.mark.parametrize("name", ["000009", 9, -1, "../000001", "", None, 1.5])
def test_unknown_recording_is_an_error_that_says_what_there_is(tiny_dataset_root: Path, name: object) -> None:
    dataset = open_dataset(tiny_dataset_root)
    with pytest.raises(NotFoundError, match="holds 3 recordings, 000000 to 000002"):
        dataset[name]
    assert name not in dataset


def test_table_has_one_typed_row_per_recording(tiny_dataset_root: Path) -> None:
    table = open_dataset(tiny_dataset_root).table
    assert list(table.index) == ["000000", "000001", "000002"]
    assert list(table["container"]) == ["red cup", "green glass", "small white cup"]
    assert list(table["kind"]) == ["cup", "glass", "cup"]
    assert list(table["filling"]) == ["none", "rice", "water"]
    assert list(table["level"]) == ["empty", "half", "full"]
    assert list(table["missing"]) == ["", "view2 video, audio", ""]
    assert table["capacity_ml"].tolist() == [round(capacity_ml(shown.profile), 3) for shown in CONTAINERS]
    assert table["depth_mm"].isna().all()
    assert table["capacity_ml"].dtype == pd.Float64Dtype()
    assert table["filling_type"].dtype == pd.Int64Dtype()


def test_cameras_are_scaled_to_the_videos_size(tiny_dataset_root: Path) -> None:
    views = open_dataset(tiny_dataset_root)["000000"].views
    point = np.array([[0.02, 0.01, 0.05]])
    for name, expected in tiny_cameras(CALIBRATED_SIZE).items():
        camera = views[name].camera()
        assert camera.size == SIZE
        # a pixel centre at x of the large image lies at (x + 1/2) / 2 - 1/2 of the one half as wide
        np.testing.assert_allclose(camera.project(point), (expected.project(point) + 0.5) / 2 - 0.5)


def test_a_camera_is_read_once_and_again_when_its_calibration_changes(tiny_dataset_root: Path, tmp_path: Path) -> None:
    shutil.copytree(tiny_dataset_root / "view1", tmp_path / "view1")
    view = open_dataset(tmp_path)["000000"].views["view1"]
    first = view.camera()
    assert view.camera() is first
    assert view.calibration_path is not None
    moved = tiny_cameras(CALIBRATED_SIZE)["view2"]
    write_calibration(view.calibration_path, moved)
    np.testing.assert_allclose(view.camera().translation, moved.translation)
    view.calibration_path.unlink()
    with pytest.raises(FileError, match=r"000000\.pickle"):
        view.camera()


def test_missing_calibration_is_named(tmp_path: Path) -> None:
    recording = open_dataset(_touch(tmp_path, "view1/rgb/000000.mp4"))["000000"]
    assert "view1 calibration" in recording.missing
    with pytest.raises(FileError, match=r"view1/calib/000000\.pickle: the calibration of view1 is missing"):
        recording.views["view1"].camera()


def test_missing_sound_is_named(tmp_path: Path) -> None:
    recording = open_dataset(_touch(tmp_path, "view1/rgb/000000.mp4"))["000000"]
    with pytest.raises(NotFoundError, match=r"000000 has no sound: audio/000000\.wav"):
        recording.audio()


def test_absence_of_view4_is_no_lack_but_its_presence_is_shown(tmp_path: Path) -> None:
    recording = open_dataset(_touch(tmp_path, "view4/rgb/000000.mp4"))["000000"]
    assert list(recording.views) == ["view4"]
    assert not any("view4" in part for part in recording.missing)
    assert recording.missing == ("view1 video", "view2 video", "view3 video", "audio", "annotation")


def test_problems_name_the_parts_that_the_whole_set_lacks(tmp_path: Path) -> None:
    problems = "\n".join(open_dataset(_touch(tmp_path, "view1/rgb/000000.mp4")).problems)
    for part in ("no annotation was found", "no view2 videos", "no view3 videos", "no view1 calibration", "no audio"):
        assert part in problems
    assert "view4" not in problems
    assert "view2 calibration" not in problems


def test_recordings_are_the_union_of_files_and_annotation(tmp_path: Path) -> None:
    _touch(tmp_path, "view1/rgb/000002.mp4", "audio/000003.wav")
    write_json(tmp_path / "ccm_train_annotation.json", {"annotations": [{"id": 1, "container id": 9}]})
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("000001", "000002", "000003")
    assert dataset["000001"].views == {}
    assert dataset["000001"].annotation is not None
    assert dataset["000002"].annotation is None


def test_fingerprint_is_of_ids_and_annotation_and_stays_when_files_are_moved_or_missing(
    tiny_dataset_root: Path, tmp_path: Path
) -> None:
    [annotation] = tiny_dataset_root.glob("*.json")
    first, there = open_dataset(tiny_dataset_root).fingerprint, tmp_path / "elsewhere"
    (there / "audio").mkdir(parents=True)
    shutil.copyfile(annotation, there / annotation.name)
    assert open_dataset(there).fingerprint == first
    assert len(first) == 8
    (there / annotation.name).write_text(annotation.read_text().replace('"container id": 4', '"container id": 5'))
    changed = open_dataset(there).fingerprint
    (there / annotation.name).unlink()
    for number in range(3):
        (there / "audio" / f"{number:06d}.wav").touch()
    assert len({first, changed, open_dataset(there).fingerprint}) == 3


def test_files_that_are_no_recordings_are_ignored(tmp_path: Path) -> None:
    _touch(
        tmp_path,
        "view1/rgb/000000.mp4",
        "view1/rgb/.000001.mp4",
        "view1/rgb/._000000.mp4",
        "view1/rgb/a b.mp4",
        "view1/rgb/000002.avi",
        "view1/rgb/.mp4",
        "view1/rgb/000003.mp4/inside",
        "view5/rgb/000004.mp4",
    )
    dataset = open_dataset(tmp_path)
    assert dataset.ids == ("000000", "000002")
    unused = {finding.file: finding.what for finding in dataset.findings if finding.kind == "unused"}
    assert "no name that can be a recording's id" in unused["view1/rgb/a b.mp4"]
    assert set(unused) == {"view1/rgb", "view1/rgb/a b.mp4", "view1/rgb/000003.mp4", "view5"}


def test_linked_files_are_followed(tmp_path: Path) -> None:
    _touch(tmp_path, "elsewhere/clip.mp4")
    (tmp_path / "set/view1/rgb").mkdir(parents=True)
    (tmp_path / "set/view1/rgb/000000.mp4").symlink_to(tmp_path / "elsewhere/clip.mp4")
    (tmp_path / "set/view1/rgb/000001.mp4").symlink_to(tmp_path / "nowhere.mp4")
    assert open_dataset(tmp_path / "set").ids == ("000000",)


PUBLISHED_377 = {
    "id": 377,
    "container id": 1,
    "scenario": 2,
    "background": 1,
    "illumination": 0,
    "container capacity": 520.0,
    "container mass": 10.0,
    "filling type": 1,
    "filling level": 2,
    "filling mass": 195.0,
}


@pytest.mark.parametrize(
    ("rows", "others", "is_cut"),
    [
        ([PUBLISHED_377], 0, True),  # a part of the published set
        (None, 684, True),  # all of it, without its annotation
        (None, 1, False),
        (None, 685, False),
        ([PUBLISHED_377 | {"container capacity": 300.0}], 0, False),
        ([{"id": 377, "container id": 1}], 684, False),
    ],
)
def test_only_the_published_sets_recording_377_is_cut(
    tmp_path: Path, rows: list[dict[str, float]] | None, others: int, *, is_cut: bool
) -> None:
    _touch(tmp_path, *(f"audio/{number:06d}.wav" for number in range(others)))
    write_audio(tmp_path / "audio" / "000377.wav", seconds=13.5)
    if rows is not None:
        write_json(tmp_path / "ccm_train_annotation.json", {"annotations": rows})
    dataset = open_dataset(tmp_path)
    assert dataset["000377"].audio().samples.shape == (8, 577_710 if is_cut else 595_350)
    [said] = [finding.what for finding in dataset.findings if finding.recording == "000377"]
    assert ("is cut at 13.1 s" if is_cut else "is used whole") in said


@pytest.mark.parametrize("typed", ["nowhere", "~no-such-user/data", "with\0null", "x" * 5000])
def test_absent_folder_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, typed: str) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match="name the folder of a dataset"):
        open_dataset(typed)


def test_file_or_empty_folder_is_an_error_that_says_what_is_expected(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"holds no recordings; expected files such as view1/rgb/000618\.mp4"):
        open_dataset(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="is a file"):
        open_dataset(tmp_path / "file")


def test_folder_above_a_dataset_is_told_apart(tmp_path: Path) -> None:
    _touch(tmp_path, "train/view1/rgb/000000.mp4")
    with pytest.raises(FileError, match="did you mean its folder 'train'"):
        open_dataset(tmp_path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every folder")
def test_unreadable_part_is_an_error(tmp_path: Path) -> None:
    _touch(tmp_path, "view1/rgb/000000.mp4")
    (tmp_path / "view1/rgb").chmod(0)
    try:
        with pytest.raises(FileError, match="cannot be read"):
            open_dataset(tmp_path)
    finally:
        (tmp_path / "view1/rgb").chmod(0o700)


def test_listing_a_dataset_loads_no_heavy_library() -> None:
    heavy = "{'av', 'cv2', 'torch'} & set(sys.modules)"
    program = f"import sys; from corsmal.dataset import open_dataset; sys.exit(bool({heavy}))"
    root = Path(__file__).resolve().parents[2]
    assert subprocess.run([sys.executable, "-c", program], cwd=root, check=False).returncode == 0


def test_recording_is_a_plain_record() -> None:
    assert Recording("000000").views == {}
    assert Recording("000000") == Recording("000000")


def test_real_training_set(real_dataset_root: Path) -> None:
    dataset = open_dataset(real_dataset_root)
    assert len(dataset) == 684
    assert dataset.problems == ()
    recording = dataset["000618"]
    assert list(recording.views) == ["view1", "view2", "view3", "view4"]
    assert recording.missing == ()
    assert recording.audio().samples.shape == (8, 116_940)
    assert recording.annotation is not None
    assert (recording.annotation.capacity_ml, recording.annotation.height_mm) == (520.0, 119.0)
    assert dataset.table["filling"].value_counts().to_dict() == {"pasta": 216, "rice": 216, "water": 144, "none": 108}
    # the published means that stand in where an estimate fails
    means = dataset.table[["capacity_ml", "width_top_mm", "width_bottom_mm", "height_mm", "container_mass_g"]].mean()
    np.testing.assert_allclose(means.to_numpy(dtype=float), [639.69, 91.54, 75.58, 130.28, 39.91], atol=0.006)


def test_recordings_are_synthetic_where_their_annotation_says_so(tiny_dataset_root: Path, tmp_path: Path) -> None:
    """Who copies a part of the demo may leave its truth behind."""
    root = shutil.copytree(tiny_dataset_root, tmp_path / "train")
    [path] = root.glob("*annotation.json")
    content = json.loads(path.read_text())
    for description, is_synthetic in (
        ("Synthetic recordings in the layout", True),
        ("Recordings", False),
        (None, False),
    ):
        path.write_text(json.dumps({**content, "info": {"description": description}}))
        assert {recording.is_synthetic for recording in open_dataset(root)} == {is_synthetic}
    path.write_text(json.dumps({**content, "info": "none"}))
    assert not open_dataset(root)["000000"].is_synthetic
