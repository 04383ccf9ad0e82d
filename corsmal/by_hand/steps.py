"""The changes of masks by hand, and what those of one frame amount to."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from corsmal.by_hand.log import Line
from corsmal.by_hand.record import WORDS_MAX, HandMask

UNDO, REDO, REMOVE = "undo", "redo", "remove"


@dataclass(frozen=True)
class Step:
    """One change.

    Args:
        number: of the change, from 1, among all of the view.
        frame: of the view's own video.
        video: fingerprint of the video that it was made on, see ``video_digest``.
        path: where that video was.
        tool: what was done.
        who: by whom.
        by: the browser session, or another name of the place where it was done.
        when: UTC, ISO 8601.
        mask: as it was then; None where it was removed, undone or redone.
        is_beside: whether somebody else had changed the mask meanwhile: it is kept, and not shown.
    """

    number: int
    frame: int
    video: str
    path: str
    tool: str
    who: str
    by: str
    when: str
    mask: HandMask | None
    is_beside: bool = False


@dataclass(frozen=True)
class FrameHistory:
    """What was done to the mask of one frame.

    Args:
        mask: that counts now; None: the detector's.
        version: number of the last change that counts, 0 where there is none.
        can_undo: how many changes can be undone.
        can_redo: how many can be done again.
        steps: all changes in order.
    """

    mask: HandMask | None = None
    version: int = 0
    can_undo: int = 0
    can_redo: int = 0
    steps: tuple[Step, ...] = ()

    @classmethod
    def of(cls, steps: Sequence[Step]) -> "FrameHistory":
        """What steps in order amount to."""
        masks: dict[int, HandMask | None] = {0: None}
        before: dict[int, int] = {}
        shown, version, undone = 0, 0, list[int]()
        for step in steps:
            masks[step.number] = step.mask
            if step.is_beside:
                continue
            version = step.number
            if step.tool == UNDO:
                undone.append(shown)
                shown = before.get(shown, 0)
            elif step.tool == REDO:
                shown = undone.pop() if undone else shown
            else:
                before[step.number], shown = shown, step.number
                undone.clear()
        depth, place = 0, shown
        while place:
            depth, place = depth + 1, before.get(place, 0)
        return cls(masks.get(shown), version, depth, len(undone), tuple(steps))


def mask_facts(mask: HandMask) -> dict[str, Any]:
    """What a line of the log holds of a mask."""
    return {
        "size": list(mask.size),
        "counts": mask.counts.decode("ascii"),
        "amodal": None if mask.amodal is None else mask.amodal.decode("ascii"),
        "label": mask.label,
        "based_on": mask.based_on[:WORDS_MAX],
        "accepted": mask.is_accepted,
    }


def read_step(line: Line) -> Step:
    """A change from its line in the log.

    Raises:
        ArgumentError, LookupError, TypeError, ValueError, AttributeError: the line holds none.
    """
    facts: dict[str, Any] = {name: line[name] for name in ("tool", "who", "when")}
    mask = None
    if "counts" in line:
        amodal = None if line["amodal"] is None else line["amodal"].encode("ascii")
        counts, size = line["counts"].encode("ascii"), tuple(line["size"])
        more = {"label": line["label"], "based_on": line["based_on"], "is_accepted": line["accepted"]}
        mask = HandMask(line["frame"], size, counts, amodal, **facts, **more)
    place = {name: line[name] for name in ("number", "frame", "video", "path", "by")}
    return Step(**place, **facts, mask=mask, is_beside=line["beside"])
