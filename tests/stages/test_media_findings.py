"""What a check says about one recording's files, each wrong in one way."""

import json
import pickle
import shutil

import av
import numpy as np
import pytest
import soundfile

from corsmal.dataset import open_dataset
from corsmal.estimation.view_offsets import ViewOffset
from corsmal.stages import media_findings
from corsmal.stages.detections import load_detections
from corsmal.stages.estimates import Predictors, load_estimate
from corsmal.stages.examination import ExamineTask
from corsmal.store import Store
from tests.tiny import SIZE, write_tiny_dataset, write_video


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return write_tiny_dataset(tmp_path_factory.mktemp("set"), recordings=1, frames=8)


@pytest.fixture
def root(made, tmp_path):
    return shutil.copytree(made, tmp_path / "set")


def scale_translations(root):
    for view in ("view1", "view2", "view3"):
        path = root / view / "calib" / "000000.pickle"
        content = pickle.loads(path.read_bytes(), encoding="latin1")
        content[1]["rgb"]["tvec"] = content[1]["rgb"]["tvec"] * 1000
        path.write_bytes(pickle.dumps(content, protocol=2))


def change_line_ends(root):
    path = root / "view1" / "calib" / "000000.pickle"
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))


def count_from_1(root):
    path = root / "view2" / "detections" / "000000.json"
    entries = json.loads(path.read_text())
    path.write_text(json.dumps([{**entry, "image_id": entry["image_id"] + 1} for entry in entries]))


def count_classes_from_0(root):
    path = root / "view2" / "detections" / "000000.json"
    path.write_text(json.dumps([{**entry, "category_id": 41} for entry in json.loads(path.read_text())]))


def break_off_detections(root):
    (root / "view2" / "detections" / "000000.json").write_text("[{")


def record_at_16_khz(root):
    soundfile.write(root / "audio" / "000000.wav", np.zeros((1600, 8)), 16_000)


def never_close_the_sound(root):
    path = root / "audio" / "000000.wav"
    content = bytearray(path.read_bytes())
    at = content.index(b"data")
    content[4:8] = content[at + 4 : at + 8] = bytes(4)
    path.write_bytes(content)


def drop_every_second_frame(root):
    size = (SIZE[1], SIZE[0], 3)
    write_video(root / "view1" / "rgb" / "000000.mp4", [np.zeros(size, np.uint8)] * 4, pts=[0, 2, 4, 6], bframes=0)


def film_upright(root):
    write_video(root / "view1" / "rgb" / "000000.mp4", [np.zeros((SIZE[0], SIZE[1], 3), np.uint8)] * 8)


def cut_off_the_video(root):
    """Half of a file whose index stands in front: all its frames seem to be there."""
    path = root / "view1" / "rgb" / "000000.mp4"
    with (
        av.open(str(path)) as source,
        av.open(str(root / "whole.mp4"), "w", options={"movflags": "faststart"}) as whole,
    ):
        stream = whole.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.size:
                packet.stream = stream
                whole.mux(packet)
    content = (root / "whole.mp4").read_bytes()
    path.write_bytes(content[: (content.index(b"mdat") + len(content)) // 2])
    (root / "whole.mp4").unlink()


@pytest.mark.parametrize(
    ("damage", "expected", "said"),
    [
        (cut_off_the_video, ("error", "video"), "of its 8 frames are not in the file"),
        (scale_translations, ("warning", "calibration"), "was taken for mm"),
        (change_line_ends, ("note", "calibration"), "line ends were changed"),
        (count_from_1, ("warning", "detections"), "frames are counted from 1 (up to 8)"),
        (count_classes_from_0, ("error", "detections"), "it holds class 41 (skateboard)"),
        (break_off_detections, ("error", "detections"), "is not JSON"),
        (record_at_16_khz, ("warning", "sound"), "recorded at 16 kHz"),
        (never_close_the_sound, ("warning", "sound"), "its header was not finished"),
        (drop_every_second_frame, ("warning", "video"), "view1 has 4 frames at 15 fps, view2 has 8 frames at 30 fps"),
        (film_upright, ("warning", "video"), "the calibration is for 1280x720"),
    ],
)
def test_it_is_found_with_its_severity(root, tmp_path, damage, expected, said):
    damage(root)
    row = ExamineTask(tmp_path / "cache")(open_dataset(root)["000000"])
    assert expected in {(found.severity, found.kind) for found in row["findings"] if said in str(found)}


def test_views_at_two_rates_are_fitted_by_the_frames_that_belong_together(root, tmp_path):
    whole = load_estimate(open_dataset(root)["000000"], Predictors(), store=Store(tmp_path / "whole"))
    drop_every_second_frame(root)
    path = root / "view1" / "detections" / "000000.json"
    kept = [entry for entry in json.loads(path.read_text()) if entry["image_id"] % 2 == 0]
    path.write_text(json.dumps([{**entry, "image_id": entry["image_id"] // 2} for entry in kept]))
    recording, store = open_dataset(root)["000000"], Store(tmp_path / "half")
    found = load_detections(recording, store=store)
    assert found.views["view1"].frames == (0, 2, 4, 6)
    assert found.views["view2"].frames == tuple(range(8))
    row = load_estimate(recording, Predictors(), store=store)
    assert row["best_frame"] in (0, 2, 4, 6)
    assert row["capacity_ml"] == pytest.approx(whole["capacity_ml"], rel=0.1)
    assert row["flags"] == "views-by-time"
    assert "frames are matched by time" in row["notes"]


def test_an_offset_that_the_motion_shows_is_found_with_what_to_do(root, monkeypatch):
    recording = open_dataset(root)["000000"]
    assert media_findings.offset_findings(recording, {}) == []
    found = (ViewOffset("view1", "view3", -0.2),)
    monkeypatch.setattr(media_findings, "find_offsets", lambda *_: found)
    [finding] = media_findings.offset_findings(recording, {})
    assert (finding.severity, finding.kind) == ("warning", "video")
    assert "view1 seems to have been filmed 0.20 s earlier than it is matched with view3" in finding.what
    assert finding.advice == "try --offset view1=-0.2, or the Frames page"
