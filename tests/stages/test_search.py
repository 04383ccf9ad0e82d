from dataclasses import replace

import numpy as np
import pytest

from corsmal.dataset import open_dataset
from corsmal.detection import Detections
from corsmal.errors import ArgumentError, FileError
from corsmal.parameters import METHOD_VIEWS, PAIRS
from corsmal.selection import select_best_frame
from corsmal.stages import inspection
from corsmal.stages.detections import detections_origin, load_detections
from corsmal.stages.search import detect_recording
from corsmal.store import Store
from tests.fakes import FakeDetector
from tests.tiny import CUP, FRAMES, write_tiny_dataset, write_video

TOTAL = FRAMES * len(METHOD_VIEWS)


@pytest.fixture(scope="module")
def with_files(dataset):
    return dataset["000000"]


@pytest.fixture(scope="module")
def without_files(dataset):
    return dataset["000002"]


def inspected(found):
    return {name: len(view) for name, view in found.views.items()}


def with_detections(recording, view, path):
    return replace(recording, views={**recording.views, view: replace(recording.views[view], detections_path=path)})


def test_views_come_in_the_order_of_the_pairs():
    assert METHOD_VIEWS == ("view3", "view1", "view2")


def test_files_beside_the_videos_are_read(with_files, store):
    found = load_detections(with_files, store=store)
    assert inspected(found) == dict.fromkeys(("view1", "view2", "view3"), FRAMES)
    assert (found.missing, found.notes) == ((), ())
    assert found.views["view1"].source == "file detections/000000.json"
    assert not store.root.exists()


def test_without_files_and_results_there_is_nothing(without_files, store):
    found = load_detections(without_files, store=store)
    assert (dict(found.views), found.missing, found.notes) == ({}, METHOD_VIEWS, ())


def test_a_view_that_the_recording_lacks_is_missing(dataset, store):
    assert load_detections(dataset["000001"], store=store).missing == ("view2",)


def test_a_detectors_results_are_kept_and_loaded(without_files, store):
    detector = FakeDetector()
    detect_recording(without_files, detector, store=store)
    assert detector.seen == TOTAL
    found = load_detections(without_files, store=store)
    assert inspected(found) == dict.fromkeys(METHOD_VIEWS, FRAMES)
    assert found.notes == ()
    assert found.views["view2"].source == detector.name
    assert found.views["view2"][5].boxes.tolist() == [[300, 150, 340, 200]]
    assert load_detections(without_files, store=Store(store.root)).key == found.key
    assert detections_origin(without_files, store=store) == found.key


def test_a_file_is_preferred_to_what_a_detector_found(with_files, store):
    detect_recording(with_detections(with_files, "view1", None), FakeDetector(), store=store)
    from_file = load_detections(with_files, store=store)
    from_store = load_detections(with_detections(with_files, "view1", None), store=store)
    assert from_file.views["view1"].source.startswith("file ")
    assert from_store.views["view1"].source == FakeDetector.name
    assert from_file.key != from_store.key


def test_views_with_a_file_are_not_inspected(with_files, store):
    detector = FakeDetector()
    detect_recording(with_detections(with_files, "view1", None), detector, store=store)
    assert detector.seen == FRAMES
    everything = FakeDetector()
    detect_recording(with_files, everything, store=store)
    assert everything.seen == 0


def test_a_broken_file_is_a_note_and_the_stored_results_stand_in(without_files, store, tmp_path):
    detect_recording(without_files, FakeDetector(), store=store)
    path = tmp_path / "000002.json"
    path.write_text("not JSON")
    found = load_detections(with_detections(without_files, "view1", path), store=store)
    [note] = found.notes
    assert str(path) in note
    assert found.views["view1"].source == FakeDetector.name
    alone = load_detections(with_detections(without_files, "view1", path), store=Store(tmp_path / "empty"))
    assert set(alone.missing) == set(METHOD_VIEWS)
    assert len(alone.notes) == 1


def test_entries_that_were_skipped_are_notes_that_name_the_file(with_files, store, tmp_path):
    path = tmp_path / "000000.json"
    content = with_files.views["view1"].detections_path.read_text()
    path.write_text(content.replace('"image_id": 0', '"image_id": 999', 1))
    found = load_detections(with_detections(with_files, "view1", path), store=store)
    [note] = found.notes
    assert note.startswith(f"{path}: 1 entry skipped: frame (image_id) out of range")


def test_progress_is_counted_over_all_views(without_files, store):
    calls = []
    detect_recording(without_files, FakeDetector(), store=store, progress=lambda *call: calls.append(call))
    assert calls[0] == (0, TOTAL)
    assert calls[-1] == (TOTAL, TOTAL)
    done = [call[0] for call in calls]
    assert done == sorted(done)
    assert {total for _, total in calls} == {TOTAL}
    assert done[:5] == [0, 0, 1, 2, 3]


def test_what_was_done_before_a_cancel_is_kept_and_the_next_run_does_the_rest(without_files, store):
    first, second, third = FakeDetector(), FakeDetector(), FakeDetector()
    detect_recording(without_files, first, store=store, cancelled=lambda: first.seen >= FRAMES + 4)
    # from coarse to fine: every thirty-second, sixteenth, eighth, fourth, second frame of all views, then the odd ones
    half = load_detections(without_files, store=store)
    assert inspected(half) == dict.fromkeys(METHOD_VIEWS, FRAMES // 2)
    assert half.views["view1"].frames == tuple(range(0, FRAMES, 2))
    assert half.notes == ()
    calls = []
    detect_recording(without_files, second, store=store, progress=lambda *call: calls.append(call))
    assert first.seen == second.seen == TOTAL // 2
    assert (calls[0], calls[-1]) == ((0, TOTAL), (TOTAL, TOTAL))
    whole = load_detections(without_files, store=store)
    assert inspected(whole) == dict.fromkeys(METHOD_VIEWS, FRAMES)
    assert whole.notes == ()
    detect_recording(without_files, third, store=store)
    assert third.seen == 0


def test_a_process_that_dies_loses_seconds_of_its_work_only(without_files, store, monkeypatch):
    monkeypatch.setattr(inspection, "KEEP_EVERY_S", 0.0)

    class Dying(FakeDetector):
        def detect(self, frames):
            if self.seen >= FRAMES:
                raise KeyboardInterrupt
            return super().detect(frames)

    first, second = Dying(), FakeDetector()
    with pytest.raises(KeyboardInterrupt):
        detect_recording(without_files, first, store=store)
    detect_recording(without_files, second, store=store)
    assert first.seen + second.seen == TOTAL


def test_frames_that_another_process_kept_meanwhile_are_not_lost(without_files, store):
    class Other(FakeDetector):
        """Before its first answer another process detects in everything."""

        def detect(self, frames):
            if not self.seen:
                detect_recording(without_files, FakeDetector(), store=Store(store.root))
            return super().detect(frames)

    stopped = Other()
    detect_recording(without_files, stopped, store=store, cancelled=lambda: stopped.seen > 0)
    assert inspected(load_detections(without_files, store=store)) == dict.fromkeys(METHOD_VIEWS, FRAMES)


def test_another_detector_inspects_all_frames_again_and_is_then_the_one_that_counts(without_files, store):
    detect_recording(without_files, FakeDetector(), store=store)
    other = FakeDetector()
    other.digest, other.name = "2", "another detector"
    detect_recording(without_files, other, store=store)
    assert other.seen == TOTAL
    assert load_detections(without_files, store=store).views["view1"].source == "another detector"
    again = FakeDetector()
    detect_recording(without_files, again, store=store)
    assert again.seen == 0
    assert load_detections(without_files, store=store).views["view1"].source == FakeDetector.name


def test_a_video_that_changed_has_no_detections_yet(tmp_path):
    root = write_tiny_dataset(tmp_path / "set", recordings=3, frames=4)
    recording, store = open_dataset(root)["000002"], Store(tmp_path / "cache")
    detect_recording(recording, FakeDetector(), store=store)
    video = recording.views["view1"].video_path
    video.write_bytes(recording.views["view2"].video_path.read_bytes() + b"\0")
    assert load_detections(recording, store=store).missing == ("view1",)


def test_results_that_cannot_be_kept_are_one_sentence(without_files, blocked):
    with pytest.raises(FileError, match="could not be kept") as raised:
        detect_recording(without_files, FakeDetector(), store=blocked)
    assert str(blocked.root) in str(raised.value)


def test_a_broken_video_is_named(without_files, store, tmp_path):
    path = tmp_path / "000002.mp4"
    path.write_bytes(b"no video")
    views = {**without_files.views, "view1": replace(without_files.views["view1"], video_path=path)}
    with pytest.raises(FileError, match=r"000002\.mp4"):
        detect_recording(replace(without_files, views=views), FakeDetector(), store=store)


def test_a_broken_video_does_not_keep_the_other_views_from_being_inspected(without_files, store, tmp_path):
    path = tmp_path / "000002.mp4"
    path.write_bytes(b"no video")
    views = {**without_files.views, "view1": replace(without_files.views["view1"], video_path=path)}
    recording, detector, calls = replace(without_files, views=views), FakeDetector(), []
    with pytest.raises(FileError, match=r"000002\.mp4"):
        detect_recording(recording, detector, store=store, progress=lambda *call: calls.append(call))
    assert detector.seen == 2 * FRAMES
    assert calls[-1] == (2 * FRAMES, 2 * FRAMES)
    found = load_detections(recording, store=store)
    assert inspected(found) == {"view3": FRAMES, "view2": FRAMES}
    assert found.missing == ("view1",)


@pytest.mark.parametrize(("every", "passes"), [(1, 5), (4, 3 + 2), (10, 2 + 4)])
def test_more_can_be_read_after_every_pass_and_is_told_apart(without_files, store, every, passes):
    found = []
    detect_recording(
        without_files,
        FakeDetector(),
        store=store,
        every=every,
        kept=lambda: found.append(load_detections(without_files, store=store)),
    )
    counts = [sum(inspected(one).values()) for one in found]
    assert len(counts) == passes
    assert counts[0] == 3
    assert counts == sorted(counts)
    assert counts[-1] == TOTAL if every == 1 else counts[0] < counts[-1] < TOTAL
    assert len({one.key for one in found}) == len(set(counts))


def test_nothing_is_told_to_be_kept_that_is_not_there_yet(without_files, store):
    detector, seen = FakeDetector(), []
    detect_recording(without_files, detector, store=store, kept=lambda: seen.append(detector.seen))
    # frame 0, then 8, then 4, then 2, 6 and 10, then the odd ones, of three views
    assert seen == [3, 6, 9, 18, 36]


class Overtaking(inspection.InProcess):
    """The first frame of the second pass is done before the last of the first, as with two processes."""

    def __call__(self, pieces, *, cancelled):
        turns = [0, 1, 3, 2, *range(4, len(pieces))]
        for position, found in super().__call__([pieces[turn] for turn in turns], cancelled=cancelled):
            yield turns[position], found


def test_no_process_waits_for_the_end_of_a_pass_and_each_is_kept_when_it_is_whole(without_files, store, tmp_path):
    counts, here = [], Store(tmp_path / "here")
    detect_recording(
        without_files,
        Overtaking(FakeDetector(), 1),
        store=store,
        kept=lambda: counts.append(sum(inspected(load_detections(without_files, store=store)).values())),
    )
    assert counts == [4, 6, 9, 18, 36]
    detect_recording(without_files, FakeDetector(), store=here)
    found, expected = (load_detections(without_files, store=one).views for one in (store, here))
    for name, view in expected.items():
        assert found[name].frames == view.frames
        assert [found[name][frame].boxes.tolist() for frame in view] == [each.boxes.tolist() for each in view.values()]


class PeakDetector(FakeDetector):
    """Reads the frame's number from its grey level; the container is largest in frame 13."""

    def detect(self, frames):
        self.seen += len(frames)
        found = []
        for frame in frames:
            number = round(float(frame.mean()) / 8)
            mask = np.zeros((1, 48, 64), dtype=bool)
            mask[0].flat[: 1000 - 5 * abs(number - 13)] = True
            found.append(Detections([[30, 20, 34, 28]], [0.9], [CUP], mask))
        return found


@pytest.fixture
def grey_recording(tmp_path):
    """Thirty frames a view, each as grey as its number."""
    for view in METHOD_VIEWS:
        images = [np.full((48, 64, 3), 8 * number, dtype=np.uint8) for number in range(30)]
        write_video(tmp_path / "set" / view / "rgb" / "000007.mp4", images)
    return open_dataset(tmp_path / "set")["000007"]


@pytest.mark.parametrize("every", [2, 5, 8, 64])
def test_the_coarse_search_finds_the_best_frame_with_fewer_frames(grey_recording, store, every):
    calls = []
    detect_recording(
        grey_recording, PeakDetector(), store=store, every=every, progress=lambda *call: calls.append(call)
    )
    views = load_detections(grey_recording, store=store).views
    for view in views.values():
        assert set(range(0, 30, every)) <= set(view)
        assert len(view) < 30
    if every <= 8:  # with a wider step the slope may lead away from the best frame
        assert {select_best_frame(views, pair=pair).frame for pair in PAIRS} == {13}
    assert calls[-1][0] == calls[-1][1]
    assert all(0 <= done <= total for done, total in calls)
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)


@pytest.mark.parametrize("every", [2, 5, 8, 64])
def test_a_search_that_is_begun_again_finds_everything_done(grey_recording, store, every):
    detect_recording(grey_recording, PeakDetector(), store=store, every=every)
    again = PeakDetector()
    detect_recording(grey_recording, again, store=store, every=every)
    assert again.seen == 0


def test_a_search_of_every_frame_follows_a_coarse_one_without_repeating_it(grey_recording, store):
    detect_recording(grey_recording, PeakDetector(), store=store, every=8)
    before = sum(len(view) for view in load_detections(grey_recording, store=store).views.values())
    detector = PeakDetector()
    detect_recording(grey_recording, detector, store=store)
    assert detector.seen == 3 * 30 - before
    assert inspected(load_detections(grey_recording, store=store)) == dict.fromkeys(METHOD_VIEWS, 30)


def test_a_step_that_is_not_positive_is_refused(without_files, store):
    with pytest.raises(ArgumentError, match="every must be at least 1, got 0"):
        detect_recording(without_files, FakeDetector(), store=store, every=0)
