"""The history of masks by hand: nothing is lost, whoever writes and whenever the program ends."""

import multiprocessing
import shutil
from dataclasses import replace

import numpy as np
import pytest

from corsmal.by_hand import HandMask, MaskHistory
from corsmal.dataset.layout import View
from corsmal.errors import ArgumentError, FileError
from corsmal.store import Store

SHAPE = (20, 30)


def mask_of(size, frame=3, **facts):
    """The first ``size`` columns."""
    mask = np.zeros(SHAPE, dtype=bool)
    mask[:, :size] = True
    return HandMask.of(mask, frame=frame, **{"tool": "brush", **facts})


@pytest.fixture
def video(tmp_path):
    path = tmp_path / "view1" / "rgb" / "000618.mp4"
    path.parent.mkdir(parents=True)
    path.write_bytes(b"a video")
    return path


@pytest.fixture
def opened(tmp_path, video):
    """Opens the history anew."""
    return lambda name="view1": MaskHistory("000618", View(name, video), store=Store(tmp_path / "cache"))


def test_nothing_was_drawn_at_first(opened):
    history = opened()
    assert history.frames() == {}
    assert history.masks() == {}
    assert history.problems() == ()
    assert history.frame(3).mask is None


def test_the_newest_mask_counts_and_says_who_drew_it(opened):
    history = opened()
    first = history.keep(mask_of(4, who="Ada", based_on="Mask R-CNN, detection 1"), after=0)
    history.keep(mask_of(5, who="Ada"), after=first.number)
    found = opened().masks()[3]
    assert found.area == 5 * SHAPE[0]
    assert found.who == "Ada"
    assert found.when.endswith("+00:00")
    assert opened().frame(3).steps[0].mask.based_on == "Mask R-CNN, detection 1"


def test_two_hundred_steps_are_undone_and_done_again_in_a_program_that_begins_anew(opened):
    version = 0
    for size in range(1, 201):
        version = opened().keep(mask_of(1 + size % 29), after=version).number
    assert opened().frame(3).can_undo == 200
    for size in range(199, -1, -1):
        version = opened().undo(3, after=version).number
        mask = opened().frame(3).mask
        assert (mask is None) if size == 0 else (mask.area == (1 + size % 29) * SHAPE[0])
    assert (opened().frame(3).can_undo, opened().frame(3).can_redo) == (0, 200)
    assert opened().undo(3, after=version).number == 0
    for _ in range(200):
        version = opened().redo(3, after=version).number
    assert opened().frame(3).mask.area == (1 + 200 % 29) * SHAPE[0]
    assert opened().redo(3, after=version).number == 0


def test_a_new_mask_after_an_undo_has_no_redo_and_the_old_one_can_be_restored(opened):
    history = opened()
    first = history.keep(mask_of(4), after=0).number
    second = history.keep(mask_of(5), after=first).number
    undone = history.undo(3, after=second).number
    history.keep(mask_of(9), after=undone)
    assert history.frame(3).can_redo == 0
    history.restore(3, second)
    assert history.frame(3).mask.area == 5 * SHAPE[0]
    history.undo(3, after=history.frame(3).version)
    assert history.frame(3).mask.area == 9 * SHAPE[0]
    with pytest.raises(ArgumentError, match="number must be that of a mask of frame 3"):
        history.restore(3, 99)


def test_without_the_mask_the_detector_counts_and_that_can_be_undone(opened):
    history = opened()
    version = history.keep(mask_of(4), after=0).number
    version = history.remove(3, after=version, who="Ada").number
    assert history.masks() == {}
    history.undo(3, after=version)
    assert history.masks()[3].area == 4 * SHAPE[0]


def test_the_later_of_two_people_is_told_and_neither_loses_a_mask(opened):
    ada, bob = opened(), opened()
    seen = ada.keep(mask_of(4, who="Ada"), after=0, by="ada").number
    ada.keep(mask_of(6, who="Ada"), after=seen, by="ada")
    kept = bob.keep(mask_of(9, who="Bob"), after=seen, by="bob")
    assert "Ada changed this mask at" in kept.said
    assert f"Yours is kept beside it as version {kept.number}" in kept.said
    assert opened().masks()[3].area == 6 * SHAPE[0]
    assert [step.is_beside for step in opened().frame(3).steps] == [False, False, True]
    bob.restore(3, kept.number, by="bob", who="Bob")
    assert opened().masks()[3].area == 9 * SHAPE[0]
    assert "Bob changed this mask" in ada.undo(3, after=seen, by="ada").said
    assert opened().masks()[3].area == 9 * SHAPE[0]


def test_quick_strokes_of_one_person_do_not_contradict_each_other(opened):
    history = opened()
    for size in (4, 5, 6):
        assert history.keep(mask_of(size), after=0, by="ada").said == ""
    assert history.masks()[3].area == 6 * SHAPE[0]


def test_frames_and_views_have_histories_of_their_own(opened):
    opened().keep(mask_of(4, frame=3), after=0)
    opened().keep(mask_of(5, frame=7), after=0)
    opened("view2").keep(mask_of(6, frame=3), after=0)
    assert {frame: mask.area // SHAPE[0] for frame, mask in opened().masks().items()} == {3: 4, 7: 5}
    assert {frame: mask.area // SHAPE[0] for frame, mask in opened("view2").masks().items()} == {3: 6}


def test_a_propagated_mask_does_not_count_until_it_is_accepted(opened):
    history = opened()
    propagated = mask_of(4, is_accepted=False, tool="propagated")
    version = history.keep(propagated, after=0).number
    assert history.masks() == {}
    assert history.masks(accepted_only=False)[3].tool == "propagated"
    history.keep(replace(propagated, is_accepted=True, tool="accept", when=""), after=version)
    assert history.masks()[3].area == 4 * SHAPE[0]


def test_masks_of_a_video_that_changed_are_not_used_and_come_back_with_it(opened, video):
    opened().keep(mask_of(4), after=0)
    video.write_bytes(b"another video")
    assert opened().masks() == {}
    [sentence] = opened().problems()
    assert "view1: masks by hand (frame 3) were drawn before 000618.mp4 changed" in sentence
    opened().keep(mask_of(7), after=0)
    assert opened().masks()[3].area == 7 * SHAPE[0]
    video.write_bytes(b"a video")
    assert opened().masks()[3].area == 4 * SHAPE[0]


def test_masks_go_with_a_video_that_was_moved(opened, video, tmp_path):
    opened().keep(mask_of(4), after=0)
    elsewhere = tmp_path / "copy.mp4"
    shutil.copyfile(video, elsewhere)
    moved = MaskHistory("000618", View("view1", elsewhere), store=Store(tmp_path / "cache"))
    assert moved.masks()[3].area == 4 * SHAPE[0]
    elsewhere.write_bytes(b"another recording of this number")
    other = MaskHistory("000618", View("view1", elsewhere), store=Store(tmp_path / "cache"))
    assert other.masks() == {}
    assert other.problems() == ()


def test_a_damaged_line_costs_only_itself(opened, tmp_path):
    for size in (4, 5, 6):
        opened().keep(mask_of(size), after=0, by="ada")
    [path] = (tmp_path / "cache" / "by-hand").glob("*/*.jsonl")
    lines = path.read_bytes().split(b"\n")
    lines[1] = lines[1].replace(b"brush", b"crush")
    path.unlink()
    path.write_bytes(b"\n".join(lines)[:-40])  # and the last one was cut
    assert opened().masks()[3].area == 4 * SHAPE[0]
    opened().keep(mask_of(8), after=0, by="ada")
    assert opened().masks()[3].area == 8 * SHAPE[0]
    assert any("2 changes of masks by hand are damaged" in sentence for sentence in opened().problems())


def _keep_many(folder, video, name):
    history = MaskHistory("000618", View("view1", video), store=Store(folder))
    for size in range(1, 21):
        history.keep(mask_of(size, frame=size, who=name), after=0, by=name)


def test_processes_that_write_at_once_lose_nothing(tmp_path, video, opened):
    context = multiprocessing.get_context("fork")
    workers = [context.Process(target=_keep_many, args=(tmp_path / "cache", video, name)) for name in ("ada", "bob")]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(30)
    steps = [step for history in opened().frames().values() for step in history.steps]
    assert sorted(step.number for step in steps) == list(range(1, 41))
    assert all(len(history.steps) == 2 for history in opened().frames().values())
    assert all([step.is_beside for step in history.steps] == [False, True] for history in opened().frames().values())


def test_a_store_that_cannot_be_written_is_said(video, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    history = MaskHistory("000618", View("view1", video), store=Store(tmp_path / "cache"))
    with pytest.raises(FileError, match="cannot be"):
        history.keep(mask_of(4), after=0)
