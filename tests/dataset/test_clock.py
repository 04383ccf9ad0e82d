"""Views that differ in rate, length or start; the videos are plain and tiny, their time stamps are what counts."""

import numpy as np
import pytest

from corsmal.dataset import Recording, Video, View
from corsmal.dataset.clock import Matching
from corsmal.errors import ArgumentError
from corsmal.notes import flags_of
from tests.tiny import write_video

COUNT = 30


def recording(folder, matching=None, **pts):
    """Each view's presentation times in 1/30 s."""
    views = {}
    for name, times in pts.items():
        images = [np.full((16, 16, 3), 8 * number % 256, np.uint8) for number in range(len(times))]
        path = write_video(folder / name / "rgb" / "000001.mp4", images, pts=list(times), bframes=0)
        views[name] = View(name, path)
    return Recording("000001", views=views, matching=matching or Matching())


def test_views_that_agree_need_no_matching(tmp_path):
    clock = recording(tmp_path, view1=range(COUNT), view2=range(2, COUNT + 2), view3=range(COUNT - 2)).clock()
    assert (dict(clock.frames), clock.notes, len(clock)) == ({}, (), COUNT)
    assert clock.fps == pytest.approx(30)
    np.testing.assert_allclose(clock.times_s, np.arange(COUNT) / 30)
    assert clock.own("view2", 7) == 7
    found = {3: "a"}
    assert clock.by_frame("view2", found) is found


def test_half_the_rate_is_matched_by_time(tmp_path):
    clock = recording(tmp_path, view1=range(0, COUNT, 2), view2=range(COUNT), view3=range(COUNT)).clock()
    assert (clock.reference, len(clock)) == ("view3", COUNT)
    assert [clock.own("view1", frame) for frame in range(5)] == [0, None, 1, None, 2]
    assert [clock.own("view2", frame) for frame in range(5)] == [0, 1, 2, 3, 4]
    assert clock.by_frame("view1", {0: "a", 2: "b"}) == {0: "a", 4: "b"}
    assert clock.nearest["view1"][:5].tolist() == [0, 0, 1, 1, 2]
    [note] = clock.notes
    assert note == (
        "view1 has 15 frames at 15 fps, view2 has 30 frames at 30 fps, view3 has 30 frames at 30 fps: "
        "frames are matched by time"
    )
    assert flags_of(clock.notes) == ("views-by-time",)


def test_dropped_frames_leave_a_gap(tmp_path):
    dropped = [number for number in range(COUNT) if number not in (10, 11, 12, 20)]
    clock = recording(tmp_path, view1=dropped, view3=range(COUNT)).clock()
    assert [clock.own("view1", frame) for frame in (9, 10, 12, 13, 19, 20, 21, 29)] == [
        9,
        None,
        None,
        10,
        16,
        None,
        17,
        25,
    ]


def test_a_view_that_starts_later_is_matched_from_there_on(tmp_path):
    clock = recording(tmp_path, view1=range(12, COUNT + 12), view3=range(COUNT)).clock()
    assert [clock.own("view1", frame) for frame in (0, 11, 12, 29)] == [None, None, 0, 17]
    assert "view1 has 30 frames at 30 fps from 0.40 s on" in clock.notes[0]


def test_a_variable_rate_is_followed(tmp_path):
    varied = np.round(np.linspace(0, 1, 20) ** 1.4 * (COUNT - 1)).astype(int).tolist()
    varied = sorted(set(varied))
    clock = recording(tmp_path, view2=varied, view3=range(COUNT)).clock()
    assert [clock.own("view2", frame) for frame in varied] == list(range(len(varied)))


def test_lengths_that_differ_are_said(tmp_path):
    clock = recording(tmp_path, view1=range(20), view3=range(COUNT)).clock()
    assert (dict(clock.frames), len(clock)) == ({}, COUNT)
    assert clock.notes[0].endswith("view3 has 30 frames at 30 fps: by their time stamps all begin together")


def test_without_time_stamps_numbers_count(tmp_path):
    made = recording(tmp_path, view1=range(COUNT), view3=range(COUNT))
    content = made.views["view1"].video_path.read_bytes()
    steps = content.index(b"stts") + 8
    made.views["view1"].video_path.write_bytes(content[: steps + 8] + bytes(4) + content[steps + 12 :])
    clock = made.clock()
    assert [clock.own("view1", frame) for frame in (0, 7, 29)] == [0, 7, 29]
    assert "view1 has 30 frames without time stamps, view3 has 30 frames at 30 fps" in clock.notes[0]


def test_an_offset_is_added_and_numbers_count_when_asked(tmp_path):
    views = {"view1": range(COUNT - 6), "view3": range(COUNT)}
    clock = recording(tmp_path, Matching(offsets_s=(("view1", 0.2),)), **views).clock()
    assert [clock.own("view1", frame) for frame in (5, 6, 29)] == [None, 0, 23]
    assert "from 0.20 s on" in clock.notes[0]
    by_index = recording(tmp_path, Matching(by="index"), view1=range(0, COUNT, 2), view3=range(COUNT)).clock()
    assert dict(by_index.frames) == {}
    assert flags_of(by_index.notes) == ("views-by-index",)


@pytest.mark.parametrize(
    "arguments",
    [
        {"by": "sound"},
        {"offsets_s": (("view9", 1.0),)},
        {"offsets_s": (("view1", float("nan")),)},
        {"offsets_s": (("view1", 1.0), ("view1", 2.0))},
        {"by": "index", "offsets_s": (("view1", 1.0),)},
    ],
)
def test_a_matching_that_cannot_be_is_refused(arguments):
    with pytest.raises(ArgumentError):
        Matching(**arguments)


def test_a_matching_is_told_in_words():
    assert str(Matching()) == "by time"
    assert str(Matching(by="index")) == "by frame number"
    assert str(Matching(offsets_s=(("view1", 0.4), ("view2", -0.125)))) == "by time, view1 +0.4 s, view2 −0.125 s"


def test_the_clock_says_what_each_file_holds(tmp_path):
    clock = recording(tmp_path, view1=range(12, 42, 2), view3=range(COUNT)).clock()
    assert {name: view.count for name, view in clock.views.items()} == {"view1": 15, "view3": COUNT}
    assert (clock.views["view1"].fps, clock.views["view1"].start_s) == pytest.approx((15, 0.4))
    assert recording(tmp_path / "alike", view2=range(4)).clock().views["view2"].count == 4


def test_a_matched_video_has_the_recordings_frames(tmp_path):
    made = recording(tmp_path, view1=range(0, COUNT, 2), view3=range(COUNT))
    with made.video("view1") as matched, Video(made.views["view1"].video_path) as own:
        assert (len(matched), matched.frame_count, len(own)) == (COUNT, COUNT, COUNT // 2)
        for frame in (0, 2, 28, 14):
            np.testing.assert_array_equal(matched[frame], own[frame // 2])
        assert len(list(matched)) == COUNT
    with made.video("view3") as plain:
        assert type(plain) is Video


def test_views_that_cannot_be_read_are_left_out(tmp_path):
    made = recording(tmp_path, view1=range(4), view3=range(4))
    made.views["view1"].video_path.write_bytes(b"broken")
    assert len(made.clock()) == 4
    made.views["view3"].video_path.unlink()
    assert (len(made.clock()), made.clock().fps, made.clock().notes) == (0, 0.0, ())
