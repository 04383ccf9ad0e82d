"""What the browser asks the server to do to a mask: checked, done by the tools, and kept in the history."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from corsmal.by_hand import (
    Drawn,
    HandMask,
    Prompt,
    brush,
    eraser,
    fill,
    open_segmenter,
    polygon,
)
from corsmal.by_hand.following import follow_on
from corsmal.by_hand.record import mask_sentences
from corsmal.errors import ArgumentError, CorsmalError
from corsmal.parameters import METHOD_VIEWS
from corsmal.ui.folders import check_may_change
from corsmal.ui.mask_editor.edited import EditedFrame
from corsmal.ui.opened import OpenedRecording

Mask = NDArray[np.bool_]
Action = Mapping[str, Any]

PROPAGATED_FRAMES = 10
STROKES_MAX = 200
STEPS = ("undo", "redo", "remove")
WORDS = ("a number", "a list of numbers", "a list of points")


def apply(opened: OpenedRecording, action: Action, *, by: str) -> str:
    """Do what the browser asks for.

    Args:
        opened: the recording with its detected masks.
        action: from the browser: not to be trusted.
        by: the browser session.

    Returns:
        A sentence for the person; empty where there is nothing to say.

    Raises:
        ArgumentError: it cannot be done so.
        RefusedError: the server is read-only.
        FileError: a picture cannot be read, or the mask not be kept.
    """
    check_may_change()
    tool, view, frame = action.get("tool"), action.get("view"), action.get("frame")
    if view not in METHOD_VIEWS or view not in opened.recording.views or type(frame) is not int:
        raise ArgumentError(f"an edit must name a view and a frame, got {str(view)[:20]!r}, {str(frame)[:20]!r}")
    if not 0 <= frame < opened.video(view).frame_count:
        raise ArgumentError(f"frame must be one of {view}'s {opened.video(view).frame_count} frames, got {frame}")
    edited, who = EditedFrame(opened, view, frame), str(action.get("who", "")).strip()[:60]
    after = action.get("after")
    if type(after) is not int:
        raise ArgumentError(f"an edit must say which version it changes, got {str(after)[:20]!r}")
    if tool in STEPS:
        return str(getattr(edited.masks, tool)(edited.own, after=after, by=by, who=who).said)
    if tool == "propagate":
        return propagate(opened, frame, by=by, who=who)
    if tool == "accept":
        return accept(opened, by=by, who=who)
    return _draw(edited, action, after=after, by=by, who=who)


def propagate(opened: OpenedRecording, frame: int, *, by: str, who: str, frames: int = PROPAGATED_FRAMES) -> str:
    """Carry the masks by hand of a frame on to the next ones, in all views that have one; none is accepted yet.

    A frame that has a mask by hand keeps it, and ends the way.

    Returns:
        How far each view came, and why no farther.
    """
    said = []
    for view in METHOD_VIEWS:
        edited = EditedFrame(opened, view, frame) if view in opened.recording.views else None
        mask = None if edited is None else edited.history.mask
        if edited is None or mask is None or not mask.area:
            continue
        reached, why = frame, ""
        for number, found in follow_on(opened.video(view), mask.mask, frame, frames=frames):
            target = EditedFrame(opened, view, number)
            history = target.history
            if found.lost or (history.mask is not None and history.mask.is_accepted):
                why = f" ({found.lost})" if found.lost else f" (frame {number} has a mask by hand)"
                break
            facts: dict[str, Any] = {"label": mask.label, "based_on": f"frame {frame} by hand", "who": who}
            carried = HandMask.of(found.mask, frame=target.own, tool="propagated", is_accepted=False, **facts)
            target.masks.keep(carried, after=history.version, by=by)
            reached = number
        said.append(f"{view} up to frame {reached}{why}")
    return f"Propagated: {'; '.join(said)}. No estimate uses these masks until they are accepted." if said else ""


def accept(opened: OpenedRecording, *, by: str, who: str) -> str:
    """Accept all propagated masks of a recording.

    Returns:
        How many there were.
    """
    count = 0
    for view in METHOD_VIEWS:
        if view in opened.recording.views:
            masks = EditedFrame(opened, view, 0).masks
            for history in masks.frames().values():
                if history.mask is not None and not history.mask.is_accepted:
                    accepted = replace(history.mask, is_accepted=True, tool="accepted", who=who, when="")
                    masks.keep(accepted, after=history.version, by=by)
                    count += 1
    return f"Accepted {count} propagated masks."


def _draw(edited: EditedFrame, action: Action, *, after: int, by: str, who: str) -> str:
    before = edited.shown
    is_amodal = action.get("layer") == "amodal"
    amodal = before.amodal_mask
    mask = (before.mask if amodal is None else amodal) if is_amodal else before.mask
    drawn = _drawn(edited, mask, action)
    if drawn.said:
        return drawn.said
    visible, whole = (before.mask, drawn.mask) if is_amodal else (drawn.mask, amodal)
    facts: dict[str, Any] = {
        "label": before.label,
        "based_on": before.based_on,
        "who": who,
        "tool": str(action["tool"]),
    }
    kept = edited.masks.keep(HandMask.of(visible, frame=edited.own, amodal=whole, **facts), after=after, by=by)
    return " ".join(sentence for sentence in (kept.said, *mask_sentences(visible, whole)) if sentence)


def _drawn(edited: EditedFrame, mask: Mask, action: Action) -> Drawn:
    tool, points = action.get("tool"), action.get("points")
    if tool in ("brush", "eraser"):
        draw = brush if tool == "brush" else eraser
        return draw(mask, _numbers(points), radius_px=float(_numbers(action.get("radius"), dimensions=0)))
    if tool == "polygon":
        return polygon(mask, _numbers(points))
    if tool == "fill":
        return fill(mask, _numbers(points)[:1].ravel().tolist())
    if tool == "propose":
        strokes = {name: action.get(name) for name in ("inside", "outside")}
        if not all(isinstance(each, list) and len(each) <= STROKES_MAX for each in strokes.values()):
            raise ArgumentError(f"a proposal must have lists of at most {STROKES_MAX} strokes")
        box = _numbers(action.get("box"), dimensions=1).tolist()
        drawn = {name: [_numbers(stroke) for stroke in each or ()] for name, each in strokes.items()}
        prompt = Prompt(tuple(box), **drawn, start=_start(edited, mask))
        return open_segmenter().propose(edited.opened.image(edited.view, edited.frame), prompt)
    raise ArgumentError(f"there is no tool {str(tool)[:20]!r}")


def _start(edited: EditedFrame, mask: Mask) -> Mask | None:
    """What a proposal refines: the mask that is shown, or what was detected where that is a proposal itself."""
    if edited.shown.tool == "propose":
        return None if edited.detected is None else edited.detected.mask
    return mask if mask.any() else None


def _numbers(value: Any, *, dimensions: int = 2) -> NDArray[np.float64]:
    """A number, a list of them or, by default, a list of points."""
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ArgumentError(f"an edit must hold numbers, got {str(value)[:40]!r}") from error
    if found.ndim != dimensions:
        raise ArgumentError(f"an edit must hold {WORDS[dimensions]}, got {str(value)[:40]!r}")
    return found


def outcome(opened: OpenedRecording, actions: Any, *, by: str, most: int = 100) -> list[str]:
    """Do all that the browser asks for, in order.

    Returns:
        Sentences for the person; errors of the library among them.
    """
    said: list[str] = []
    for action in actions[:most] if isinstance(actions, list) else ():
        try:
            said.append(apply(opened, action if isinstance(action, Mapping) else {}, by=by))
        except CorsmalError as error:
            said.append(str(error))
    return list(dict.fromkeys(filter(None, said)))
