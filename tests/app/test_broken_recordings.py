"""Recordings with something missing or broken: a sentence names the file, and the rest of the page is there."""

import json
import pickle
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from tests.app.driver import Seen, Visitor
from tests.tiny import (
    CALIBRATED_SIZE,
    CUP,
    SIZE,
    coco_result,
    tiny_cameras,
    write_audio,
    write_calibration,
    write_video,
)

NAME = "000000"
FIRST_PAIR = {"pair": "view3-view1"}
"""The address of a page that would choose the other pair by itself."""
OTHER_PAIR = "Best frame of view3 + view2"


@pytest.fixture
def video(root: Path) -> Path:
    return root / "view1" / "rgb" / f"{NAME}.mp4"


@pytest.fixture
def calibration(root: Path) -> Path:
    return root / "view1" / "calib" / f"{NAME}.pickle"


@pytest.fixture
def detections(root: Path) -> Path:
    return root / "view1" / "detections" / f"{NAME}.json"


def look(root: Path, **address: str) -> dict[str, Seen]:
    """Every page, none of which crashes."""
    visitor = Visitor(root, **address)
    pages = {"recordings": visitor.look()} | {page: visitor.open(page).look() for page in ("frames", "shape")}
    for page, seen in pages.items():
        assert seen.crashes == [], page
        assert seen.title == page.capitalize()
    return pages


def change_entries(path: Path, change: Callable[[list[dict[str, Any]]], object]) -> None:
    entries = json.loads(path.read_text(encoding="utf-8"))
    change(entries)
    path.write_text(json.dumps(entries), encoding="utf-8")


def put_mask(path: Path, rows: slice, columns: slice) -> None:
    """Give the container of every frame this rectangle as its mask; its box stays."""

    def change(entries: list[dict[str, Any]]) -> None:
        mask = np.zeros(SIZE[::-1], dtype=bool)
        mask[rows, columns] = True
        for entry in entries:
            if entry["category_id"] == CUP:
                result = coco_result(entry["image_id"], mask, category=CUP, score=1.0)
                entry["segmentation"] = result["segmentation"]

    change_entries(path, change)


def test_recording_without_a_view_its_sound_and_its_calibration(root: Path, calibration: Path) -> None:
    (root / "view2" / "rgb" / f"{NAME}.mp4").unlink()
    (root / "audio" / f"{NAME}.wav").unlink()
    calibration.unlink()
    pages = look(root)
    assert pages["recordings"].warnings == ["Missing: view1 calibration, view2 video, audio."]
    assert (pages["recordings"].videos, pages["recordings"].sounds) == (2, 0)
    assert pages["frames"].pictures == 2
    assert f"{calibration}: the calibration of view1 is missing" in pages["shape"].sentences
    assert "reprojection_view3" in pages["shape"].plots


def test_pair_that_can_be_fitted_is_the_one_shown_until_another_is_chosen(root: Path, calibration: Path) -> None:
    calibration.unlink()
    visitor = Visitor(root).open("shape")
    assert visitor.errors == []
    assert "pair" not in visitor.address
    assert {"reprojection_view3", "reprojection_view2"} <= set(visitor.plots)
    visitor.choose("pair_control", ("view3", "view1"))
    assert f"{calibration}: the calibration of view1 is missing" in visitor.sentences
    assert visitor.address["pair"] == "view3-view1"


@pytest.mark.parametrize("size", [0, 100, 4000])
def test_video_that_is_cut_off(root: Path, video: Path, size: int) -> None:
    video.write_bytes(video.read_bytes()[:size])
    pages = look(root)
    for seen in pages.values():
        assert f"{video}: cannot be opened as an MP4 video" in seen.sentences
    assert pages["recordings"].videos == 2
    assert pages["frames"].pictures == 2
    assert OTHER_PAIR in pages["frames"].metrics
    assert "Capacity" in pages["shape"].metrics


def test_views_of_different_length(root: Path, video: Path) -> None:
    write_video(video, [np.full((*SIZE[::-1], 3), 128, dtype=np.uint8)] * 3)
    visitor = Visitor(root).open("frames")
    assert "image_id" in visitor.sentences
    visitor.go_to(5)
    assert visitor.crashes == []
    assert visitor.address["frame"] == "5"
    assert sorted(view["frames"] for view in visitor.time_line["views"]) == [3, 6, 6]
    visitor.open("shape")
    assert visitor.crashes == []
    assert "No detections of view3 + view1 in frame 5 yet" in visitor.sentences


@pytest.mark.parametrize("channels", [1, 2])
def test_sound_of_other_channels(root: Path, channels: int) -> None:
    path = write_audio(root / "audio" / f"{NAME}.wav", channels=channels)
    seen = look(root)["recordings"]
    assert seen.errors == [f"{path}: has {channels} channels where the dataset's recordings have 8"]
    assert seen.videos == 3


def test_sound_that_is_none(root: Path) -> None:
    path = root / "audio" / f"{NAME}.wav"
    path.write_bytes(b"RIFF")
    seen = look(root)["recordings"]
    assert seen.errors[0].startswith(f"{path}: cannot be read as sound")
    assert seen.videos == 3


class _Hostile:
    def __init__(self, written: Path) -> None:
        self.written = written

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str, str]]:
        return open, (str(self.written), "w")


def test_calibration_that_tries_to_run_code(root: Path, calibration: Path, tmp_path: Path) -> None:
    written = tmp_path / "written"
    calibration.write_bytes(pickle.dumps([{"rgb": _Hostile(written)}, _Hostile(written)]))
    pages = look(root)
    assert not written.exists()
    assert OTHER_PAIR in pages["frames"].metrics
    assert "Capacity" in pages["shape"].metrics
    asked = look(root, **FIRST_PAIR)
    assert f"{calibration}: holds something other than plain numbers" in asked["shape"].sentences
    assert "nothing in it was run" in asked["shape"].sentences
    assert "Best frame of view3 + view1" in asked["frames"].metrics


@pytest.mark.parametrize("part", ["intrinsic", "rotation", "translation"])
def test_calibration_with_a_nan(root: Path, calibration: Path, part: str) -> None:
    camera = tiny_cameras(CALIBRATED_SIZE)["view1"]
    parts = {name: np.array(getattr(camera, name)) for name in ("intrinsic", "rotation", "translation", "projection")}
    parts[part].flat[0] = np.nan
    write_calibration(calibration, SimpleNamespace(**parts))  # type: ignore[arg-type]
    assert "Capacity" in look(root)["shape"].metrics
    seen = look(root, **FIRST_PAIR)["shape"]
    assert f"{calibration}: is no usable calibration: {part} must be finite" in seen.sentences
    assert "reprojection_view3" in seen.plots


def test_cameras_that_look_along_nearly_parallel_rays(root: Path, calibration: Path) -> None:
    frontal = tiny_cameras(CALIBRATED_SIZE)["view3"]
    moved_m = np.add(frontal.translation, (1e-4, 0, 0))
    write_calibration(calibration, replace(frontal, translation=moved_m))
    assert "Capacity" in look(root)["shape"].metrics
    seen = look(root, **FIRST_PAIR)["shape"]
    assert re.search(
        r"fit of view3 \+ view1 in frame \d failed: (the views' rays .* parallel|only 0 of)", seen.sentences
    )


def test_detections_of_which_some_cannot_be_used(root: Path, detections: Path) -> None:
    def change(entries: list[dict[str, Any]]) -> None:
        entries[0]["segmentation"]["size"] = [10, 10]
        entries[2]["segmentation"]["counts"] = "~~~~"
        entries[4]["image_id"] = 99
        entries[6]["category_id"] = 1000

    change_entries(detections, change)
    pages = look(root)
    for page in ("frames", "shape"):
        assert len(pages[page].warnings) == 4
        assert all(warning.startswith(f"{detections}: 1 entry skipped") for warning in pages[page].warnings)
    assert "Best frame of view3 + view1" in pages["frames"].metrics
    assert "Capacity" in pages["shape"].metrics


@pytest.mark.parametrize("content", ["[{", "{}", '[{"image_id": 0}]', "[" * 100_000])
def test_detections_of_which_none_can_be_used(root: Path, detections: Path, content: str) -> None:
    detections.write_text(content, encoding="utf-8")
    pages = look(root)
    for page in ("frames", "shape"):
        assert len(pages[page].warnings) == 1
        assert pages[page].warnings[0].startswith(f"{detections}: ")
        assert "Find the best frame" not in pages[page].buttons
    assert OTHER_PAIR in pages["frames"].metrics
    assert "Capacity" in pages["shape"].metrics


def test_detections_of_nothing(root: Path, detections: Path) -> None:
    detections.write_text("[]", encoding="utf-8")
    pages = look(root)
    assert OTHER_PAIR in pages["frames"].metrics
    assert "view1: nothing was detected in frame" in pages["frames"].sentences


@pytest.mark.parametrize("rows", [slice(0, 0), slice(180, 181)])
def test_mask_without_area(root: Path, detections: Path, rows: slice) -> None:
    put_mask(detections, rows, slice(320, 321))
    pages = look(root)
    assert OTHER_PAIR in pages["frames"].metrics
    assert "Capacity" in pages["shape"].metrics
    asked = look(root, frame="5", **FIRST_PAIR)
    assert "Best frame of view3 + view1" in asked["frames"].metrics
    assert "The fit of view3 + view1 in frame 5 failed: " in asked["shape"].sentences
    is_empty = rows == slice(0, 0)
    assert ("reprojection_view1" not in asked["shape"].plots) == is_empty
    assert ("Nothing to project: view1 has no container in frame 5." in asked["shape"].sentences) == is_empty


def test_masks_that_fill_the_picture(root: Path) -> None:
    for view in ("view1", "view3"):
        put_mask(root / view / "detections" / f"{NAME}.json", slice(None), slice(None))
    assert "reprojection_view1" in look(root)["shape"].plots


@pytest.mark.parametrize("page", ["overview", "frames", "shape", "filling"])
def test_files_that_are_removed_while_they_are_shown_crash_no_page(root: Path, page: str) -> None:
    visitor = Visitor(root).open(page)
    dataset = visitor.test.session_state["dataset"]
    for name in ("view1/rgb/000000.mp4", "view3/calib/000000.pickle", "audio/000000.wav"):
        (root / name).unlink()
    with patch("corsmal.ui.shared.dataset", return_value=dataset):  # listed just before
        visitor.test.run()
    assert visitor.crashes == []
