"""Masks by hand on the pages: what the server does with what was drawn, what it answers, and where it counts."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from corsmal.by_hand import Drawn, MaskHistory, Prompt
from corsmal.by_hand.prompted import GrabCutSegmenter
from corsmal.dataset import Recording, open_dataset
from corsmal.parameters import ShapeParameters
from corsmal.runs import make_run
from corsmal.runs.run import save_run
from corsmal.stages.detections import load_detections
from corsmal.stages.settings import EstimateSettings
from corsmal.ui import shared
from corsmal.ui.folders import READ_ONLY
from corsmal.ui.mask_editor.edits import outcome
from corsmal.ui.mask_editor.fits import outlines
from corsmal.ui.opened import OpenedRecording
from tests.app.driver import Visitor
from tests.tiny import SIZE, write_tiny_dataset

FRAME = 2


class Editor:
    """A visitor who corrects masks of a frame."""

    def __init__(self, root: Path, view: str = "view3") -> None:
        self.visitor = Visitor(root)
        self.visitor.open("frames")
        self.visitor.go_back(frame=str(FRAME), edit=view)

    @property
    def sent(self) -> dict[str, Any]:
        """What the component was given."""
        found: dict[str, Any] = self.visitor._components["mask_editor"]
        return found

    def view(self, name: str = "view3") -> dict[str, Any]:
        return next(view for view in self.sent["views"] if view["name"] == name)

    @property
    def said(self) -> str:
        return " ".join(self.sent["said"])

    def pixels(self, name: str = "view3") -> int:
        return sum(self.view(name)["mask"][1::2])

    def act(self, tool: str, *, view: str = "view3", after: int | None = None, **details: Any) -> None:
        version = self.view(view)["version"] if after is None else after
        action = {"tool": tool, "view": view, "frame": FRAME, "layer": "visible", "after": version, "who": "Ada"}
        self.visitor.report("mask_editor", actions=[{**action, **details}])
        assert self.visitor.crashes == self.visitor.errors == []

    def number(self, label: str, column: int) -> str:
        return str(next(row for row in self.sent["numbers"]["rows"] if row[0] == label)[column])


@pytest.fixture
def recording(sound_root: Path) -> Recording:
    return open_dataset(sound_root)["000000"]


@pytest.fixture
def editor(sound_root: Path) -> Editor:
    return Editor(sound_root)


def detected(recording: Recording, view: str = "view3") -> np.ndarray:
    return load_detections(recording, store=shared.store()).views[view][FRAME].mask(0)


def centre(mask: np.ndarray) -> tuple[float, float]:
    rows, columns = np.nonzero(mask)
    return float(columns.mean()), float(rows.mean())


def masks(recording: Recording, view: str = "view3") -> MaskHistory:
    return MaskHistory(recording.id, recording.views[view], store=shared.store())


def test_the_editor_begins_with_what_was_detected(editor: Editor, recording: Recording) -> None:
    assert [view["name"] for view in editor.sent["views"]] == ["view1", "view3", "view2"]
    assert editor.view()["source"] == "detected"
    assert editor.pixels() == detected(recording).sum()
    assert editor.view()["hull"]
    assert editor.number("Capacity", 1) == editor.number("Capacity", 2)
    assert "Annotated" in editor.sent["numbers"]["head"]


def test_a_stroke_is_kept_and_the_hull_fitted_anew(editor: Editor, recording: Recording) -> None:
    before = detected(recording)
    left = np.flatnonzero(before.any(axis=0))[0]
    bottom = np.flatnonzero(before.any(axis=1))[-1]
    editor.act("eraser", points=[[left, 0], [left, bottom]], radius=8)
    assert editor.view()["source"] == "by hand, Ada"
    assert editor.pixels() < before.sum()
    assert editor.number("Top width", 1) != editor.number("Top width", 2)
    kept = masks(recording).masks()[FRAME]
    assert (kept.who, kept.tool) == ("Ada", "eraser")
    assert kept.based_on.endswith("detection 1")
    assert detected(recording).sum() == before.sum()  # the detector's is as it was


def test_every_tool_does_what_it_says(editor: Editor, recording: Recording) -> None:
    x, y = centre(detected(recording))
    square = [[x - 20, y - 20], [x + 20, y - 20], [x + 20, y + 20], [x - 20, y + 20]]
    editor.act("polygon", points=square)
    assert abs(editor.pixels() - 1600) < 90
    editor.act("eraser", points=[[x, y]], radius=5)
    with_hole = editor.pixels()
    editor.act("fill", points=[[x, y]])
    assert 60 < editor.pixels() - with_hole < 100
    editor.act("brush", points=[[x + 30, y]], radius=5)
    assert "2 parts" not in editor.said or editor.pixels() > with_hole
    editor.act("undo")
    assert abs(editor.pixels() - 1600) < 90
    editor.act("redo")
    editor.act("remove")
    assert editor.view()["source"] == "detected"
    editor.act("undo")
    assert editor.view()["is_by_hand"]


def test_a_proposal_from_a_box_is_near_the_container(editor: Editor, recording: Recording) -> None:
    true = detected(recording)
    left, top, width, height = cv2.boundingRect(true.view(np.uint8))
    box = [left - 3, top - 3, left + width + 3, top + height + 3]
    editor.act("propose", box=box, inside=[[list(centre(true))]], outside=[])
    found = masks(recording).masks()[FRAME].mask
    assert (found & true).sum() / (found | true).sum() > 0.85


def test_a_proposal_refines_the_shown_mask_and_none_before_it(
    editor: Editor, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    starts: list[Any] = []

    def propose(_: GrabCutSegmenter, image: np.ndarray, prompt: Prompt) -> Drawn:
        starts.append(prompt.start)
        half = detected(recording)
        half[:, : image.shape[1] // 2] = False
        return Drawn(half)

    monkeypatch.setattr(GrabCutSegmenter, "propose", propose)
    box = {"box": [5, 5, 50, 50], "inside": [], "outside": []}
    editor.act("propose", **box)
    editor.act("propose", **box)
    for start in starts:
        np.testing.assert_array_equal(start, detected(recording))
    editor.act("polygon", points=[[10, 10], [40, 10], [40, 40], [10, 40]])
    editor.act("propose", **box)
    assert abs(int(starts[2].sum()) - 900) < 70
    editor.act("eraser", points=[[0, 0], [SIZE[0], SIZE[1]]], radius=400)
    editor.act("propose", **box)
    assert starts[3] is None


def test_what_cannot_be_done_is_said_and_changes_nothing(editor: Editor, recording: Recording) -> None:
    for tool, details, said in (
        ("brush", {"points": [[-500, -500]], "radius": 5}, "outside the picture"),
        ("brush", {"points": [["a", 1]], "radius": 5}, "must hold numbers"),
        ("brush", {"points": [[5, 5]], "radius": 1e9}, "radius_px"),
        ("polygon", {"points": [[5, 5]]}, "points must be"),
        ("propose", {"box": [5, 5, 5, 5], "inside": [], "outside": []}, "box must be"),
        ("propose", {"box": [5, 5, 50, 50], "inside": "x", "outside": []}, "strokes"),
        ("conjure", {}, "there is no tool"),
        ("brush", {"view": "view9"}, "must name a view"),
        ("brush", {"after": "x"}, "which version"),
        ("brush", {"frame": 10**9, "points": [[5, 5]], "radius": 5}, "frame must be one of"),
    ):
        action = {"tool": tool, "view": "view3", "frame": FRAME, "layer": "visible", "after": 0, **details}
        editor.visitor.report("mask_editor", actions=[action])
        assert editor.visitor.crashes == []
        assert said in editor.said
    editor.visitor.report("mask_editor", actions=["no action", 7])
    assert editor.visitor.crashes == []
    assert masks(recording).masks() == {}


@pytest.mark.parametrize(
    "details",
    [
        {"tool": "fill", "points": True},
        {"tool": "eraser", "points": [[1, 2]], "radius": [[1, 2], [3, 4]]},
        {"tool": "brush", "points": 10**400, "radius": 3},
        {"tool": "brush", "points": [[1, 2, 3]], "radius": 3},
        {"tool": "polygon", "points": [[None, None]]},
        {"tool": "propose", "box": 5.5, "inside": [], "outside": []},
        {"tool": "propose", "box": [1, 2], "inside": [], "outside": []},
        {"tool": "propose", "box": [1, 2, 30, 40], "inside": [[["a"]]], "outside": []},
        {"tool": {}, "points": []},
    ],
    ids=str,
)
def test_what_no_browser_of_ours_sends_is_a_sentence(recording: Recording, details) -> None:
    action = {"view": "view3", "frame": FRAME, "after": 0, **details}
    [sentence] = outcome(OpenedRecording(recording), [action], by="a stranger")
    assert sentence
    assert masks(recording).frames() == {}


def test_an_empty_mask_and_two_parts_are_kept_with_a_sentence(editor: Editor, recording: Recording) -> None:
    x, y = centre(detected(recording))
    editor.act("brush", points=[[10, 10]], radius=6)
    assert "2 parts" in editor.said
    editor.act("eraser", points=[[x, y], [10, 10]], radius=300)
    assert "no container is visible" in editor.said
    assert "Nothing fits these masks" in editor.said
    assert masks(recording).masks()[FRAME].area == 0


def test_the_whole_outline_is_a_layer_of_its_own_and_the_truth_on_mass(
    editor: Editor, recording: Recording, sound_root: Path
) -> None:
    x, y = centre(detected(recording))
    editor.act("brush", points=[[x, y], [x, y + 60]], radius=12, layer="amodal")
    assert editor.pixels() == detected(recording).sum()
    assert sum(editor.view()["amodal"][1::2]) > editor.pixels()
    visitor = Visitor(sound_root)
    visitor.open("mass")
    visitor.go_back(frame=str(FRAME))
    shown = str(visitor.plots["restoration"]["figure"])
    assert "IoU" in shown or "overlap" in shown.lower()


def test_the_later_of_two_people_is_told_and_finds_both_masks(sound_root: Path, recording: Recording) -> None:
    ada, bob = Editor(sound_root), Editor(sound_root)
    ada.act("brush", points=[[20, 20]], radius=6)
    shown = ada.pixels()
    bob.act("brush", points=[[60, 60]], radius=9, who="Bob")
    assert "Ada changed this mask" in bob.said
    assert "kept beside it as version 2" in bob.said
    assert bob.pixels() == shown
    bob.visitor.press("Use this version")
    assert bob.view()["source"].startswith("by hand")
    assert masks(recording).masks()[FRAME].mask[60, 60]


def test_masks_are_there_after_a_reload_with_all_their_steps(sound_root: Path) -> None:
    first = Editor(sound_root)
    for step in range(5):
        first.act("brush", points=[[20 + 12 * step, 20]], radius=4)
    again = Editor(sound_root)
    assert again.pixels() == first.pixels()
    assert again.view()["can_undo"] == 5
    again.act("undo")
    assert again.pixels() < first.pixels()
    assert again.view()["can_redo"] == 1


def test_masks_are_carried_on_in_all_views_and_count_once_accepted(editor: Editor, recording: Recording) -> None:
    for view in ("view3", "view1"):
        x, y = centre(detected(recording, view))
        editor.act("brush", view=view, points=[[x, y]], radius=4)
    editor.act("propagate")
    assert "view3 up to frame 5" in editor.said
    assert "view1 up to frame 5" in editor.said
    assert list(masks(recording).masks()) == [FRAME]
    assert list(masks(recording).masks(accepted_only=False)) == [2, 3, 4, 5]
    carried = masks(recording).masks(accepted_only=False)[4]
    true = load_detections(recording, store=shared.store()).views["view3"][4].mask(0)
    assert (carried.mask & true).sum() / (carried.mask | true).sum() > 0.8
    assert (carried.tool, carried.based_on) == ("propagated", "frame 2 by hand")
    editor.act("accept")
    assert list(masks(recording).masks()) == [2, 3, 4, 5]


def test_the_switch_says_which_masks_are_used_on_all_pages(sound_root: Path, recording: Recording) -> None:
    editor = Editor(sound_root)
    before = detected(recording)
    for view in ("view3", "view1"):
        shape = detected(recording, view)
        left = np.flatnonzero(shape.any(axis=0))[0]
        editor.act("eraser", view=view, points=[[left, 0], [left, SIZE[1]]], radius=5)
    visitor = Visitor(sound_root)
    visitor.open("shape")
    visitor.go_back(frame=str(FRAME))
    plain = visitor.frame_measures
    visitor.go_back(frame=str(FRAME), masks="by-hand")
    assert visitor.link["masks"] == "by-hand"
    assert visitor.frame_measures["Top width"] != plain["Top width"]
    assert before.sum() == detected(recording).sum()


def test_masks_by_hand_are_switched_on_where_there_are_some(sound_root: Path, recording: Recording) -> None:
    editor = Editor(sound_root)
    assert "masks_control" not in {item.key for item in editor.visitor.test.toggle}
    x, y = centre(detected(recording))
    editor.act("brush", points=[[x, y]], radius=3)
    editor.visitor.test.run()
    editor.visitor.choose("masks_control", True)
    assert editor.visitor.link["masks"] == "by-hand"
    assert f"view3: masks by hand in frame {FRAME}" in editor.visitor.sentences
    assert editor.view()["source"] == "by hand, Ada"
    assert editor.number("Capacity", 1) != "–"
    editor.visitor.choose("masks_control", False)
    assert "masks" not in editor.visitor.link


def test_shape_leads_to_the_editor(sound_root: Path) -> None:
    visitor = Visitor(sound_root).open("shape")
    visitor.press("Correct the mask of view3")
    assert visitor.test.title[0].value == "Frames"
    assert visitor.link["edit"] == "view3"
    assert "mask_editor" in visitor._components


def test_the_next_mask_is_proposed_and_opened(editor: Editor) -> None:
    editor.visitor.press("Which mask next?")
    label = next(label for label in editor.visitor.buttons if "the estimate uses it" in label)
    editor.visitor.press(label)
    assert editor.sent["frame"] == int(label.split()[1].strip(","))
    assert editor.sent["active"] == label.split()[2].strip(":")


def test_the_next_recording_is_the_least_sure_of_the_newest_run_and_opened(tmp_path: Path) -> None:
    root = write_tiny_dataset(tmp_path / "two", recordings=2, frames=6)
    editor = Editor(root)
    assert editor.visitor.link["recording"] == "000000"
    editor.visitor.press("Which recording next?")
    assert "No run of this dataset says how sure its estimates are" in editor.visitor.sentences
    dataset, store = open_dataset(root), shared.store()
    settings = EstimateSettings(replace(ShapeParameters.paper(), circumferences=40))
    made = make_run("surveyed", dataset, settings, store=store)
    rows = [{**row, "capacity_ml": 500.0, "capacity_ml_low": 400.0, "capacity_ml_high": 650.0} for row in made.rows]
    save_run(replace(made, rows=tuple(rows)), store=store)
    editor.visitor.press("Which recording next?")
    assert "By the 90 % intervals of run surveyed" in editor.visitor.sentences
    label = next(label for label in editor.visitor.buttons if "90 % intervals of 50 % of the values" in label)
    assert label.startswith("000001: ")
    assert not any(label.startswith("000000") for label in editor.visitor.buttons)
    editor.visitor.press(label)
    assert editor.visitor.test.title[0].value == "Frames"
    assert editor.visitor.link["recording"] == "000001"
    assert f"frame {editor.sent['frame']}, {editor.sent['active']}:" in label


def test_the_comparison_says_what_the_masks_change(editor: Editor, recording: Recording) -> None:
    editor.visitor.choose("masks_compared", True)
    assert "two views of a frame" in editor.visitor.sentences
    for view in ("view3", "view1"):
        x, y = centre(detected(recording, view))
        editor.act("brush", view=view, points=[[x, y]], radius=3)
    texts = " ".join(element.value for element in editor.visitor.test.markdown)
    assert "`paper`: the mean error of the 4 quantities" in texts


def test_guests_see_masks_and_change_none(
    sound_root: Path, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["app.py", "--read-only"])
    editor = Editor(sound_root)
    assert editor.sent["is_read_only"]
    editor.act("brush", points=[[20, 20]], radius=6)
    assert READ_ONLY in editor.said
    assert masks(recording).masks() == {}


def test_outlines_go_through_the_middles_of_the_pixels_at_the_edge() -> None:
    mask = np.zeros((10, 12), dtype=bool)
    mask[2:5, 3:9] = True
    [outline] = outlines(mask)
    assert sorted(map(tuple, outline)) == [(3.5, 2.5), (3.5, 4.5), (8.5, 2.5), (8.5, 4.5)]
