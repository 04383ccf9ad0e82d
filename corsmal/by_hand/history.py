"""The history of one view's masks by hand: every change is appended, none is ever taken out.

Undoing is a change, too: it is there after a reload, and for everybody. Who changes a mask that somebody else changed
meanwhile is told so, and the change is kept beside the other one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

from corsmal.by_hand.log import Line, open_log
from corsmal.by_hand.record import WORDS_MAX, HandMask
from corsmal.by_hand.steps import REDO, REMOVE, UNDO, FrameHistory, Step, mask_facts, read_step
from corsmal.dataset import View
from corsmal.digests import digest, file_fingerprint
from corsmal.errors import ArgumentError, FileError
from corsmal.store import Store
from corsmal.weights import file_sha256

KIND = "by-hand"
VIDEO_DIGITS = 16
VIDEOS_KEPT = 256


@dataclass(frozen=True)
class Kept:
    """What became of a change.

    Args:
        number: of the change, 0 where nothing was kept.
        said: a sentence where it does not count; empty: it does.
    """

    number: int
    said: str = ""


class MaskHistory:
    """The masks by hand of one view of one recording.

    Args:
        recording_id: the recording's id.
        view: the view, with its video as it is now.
        store: keeps the changes.
    """

    def __init__(self, recording_id: str, view: View, *, store: Store) -> None:
        key = digest("masks by hand", recording_id, view.name)
        self._log = open_log(store.file(KIND, key, ".jsonl"), read_step)
        self._view = view

    @property
    def video(self) -> str:
        """See ``video_digest``."""
        return video_digest(self._view.video_path)

    def frames(self) -> dict[int, FrameHistory]:
        """What was done on the video as it is now, by its frames.

        Raises:
            FileError: the video or the changes cannot be read.
        """
        by_frame: dict[int, list[Step]] = {}
        for step in self._of_video(self._log.items()):
            by_frame.setdefault(step.frame, []).append(step)
        return {frame: FrameHistory.of(of_frame) for frame, of_frame in sorted(by_frame.items())}

    def frame(self, frame: int) -> FrameHistory:
        """What was done in one frame; raises what ``frames`` does."""
        return self._of_frame(self._log.items(), frame)

    def masks(self, *, accepted_only: bool = True) -> dict[int, HandMask]:
        """The masks that count now, by frame; by default without those that nobody has accepted."""
        found = {frame: history.mask for frame, history in self.frames().items()}
        return {
            frame: mask for frame, mask in found.items() if mask is not None and (mask.is_accepted or not accepted_only)
        }

    def problems(self) -> tuple[str, ...]:
        """Sentences on masks that are kept and not used: drawn on another video in this place, or damaged."""
        name, path, found = self._view.name, self._view.video_path, []
        here = [step for step in self._log.items() if step.path == str(path.absolute())]
        video = self.video if here else ""
        others = sorted({step.frame for step in here if step.video != video})
        if others:
            frames = f"frame{'s' if len(others) > 1 else ''} {', '.join(map(str, others[:8]))}"
            found.append(
                f"{name}: masks by hand ({frames}) were drawn before {path.name} changed; they are kept, and not used"
            )
        if self._log.damaged:
            found.append(f"{name}: {self._log.damaged} changes of masks by hand are damaged and left out")
        return tuple(found)

    def keep(self, mask: HandMask, *, after: int, by: str = "") -> Kept:
        """Keep a mask as the newest of its frame.

        Args:
            mask: the mask; where it has no time, it is given that of now.
            after: ``FrameHistory.version`` of what it was made from.
            by: where it was made: changes of the same place do not contradict each other.

        Returns:
            Its number. Where somebody else changed the frame after ``after``, it is kept beside that; ``said`` says so.

        Raises:
            FileError: it cannot be written.
        """
        mask = mask if mask.when else replace(mask, when=_now())
        content = {**mask_facts(mask), "tool": mask.tool, "who": mask.who, "when": mask.when}
        return self._change(mask.frame, content, after=after, by=by)

    def undo(self, frame: int, *, after: int, by: str = "", who: str = "") -> Kept:
        """Undo the last change of a frame; arguments as for ``keep``. Where there is none, nothing is kept."""
        return self._step_back(frame, UNDO, after=after, by=by, who=who)

    def redo(self, frame: int, *, after: int, by: str = "", who: str = "") -> Kept:
        """Do again what was undone last; arguments as for ``keep``."""
        return self._step_back(frame, REDO, after=after, by=by, who=who)

    def remove(self, frame: int, *, after: int, by: str = "", who: str = "") -> Kept:
        """Let the detector's mask count in a frame, which can be undone; arguments as for ``keep``."""
        return self._change(frame, {"tool": REMOVE, "who": who, "when": _now()}, after=after, by=by)

    def restore(self, frame: int, number: int, *, by: str = "", who: str = "") -> Kept:
        """Let the mask of an earlier change count again, whatever was done since.

        Raises:
            ArgumentError: the frame has no mask of this number.
        """
        history = self.frame(frame)
        mask = next((step.mask for step in history.steps if step.number == number), None)
        if mask is None:
            raise ArgumentError(f"number must be that of a mask of frame {frame}, got {number}")
        again = replace(mask, tool=f"version {number}", who=who, when="")
        return self.keep(again, after=history.version, by=by)

    def _step_back(self, frame: int, tool: str, *, after: int, by: str, who: str) -> Kept:
        """Undo or redo where there is something to, and nobody else changed the frame meanwhile."""
        said: list[str] = []

        def make(steps: tuple[Step, ...]) -> Line | None:
            history = self._of_frame(steps, frame)
            said.extend(_contradiction(history, after, by))
            if said or not (history.can_undo if tool == UNDO else history.can_redo):
                return None
            return self._line(steps, frame, {"tool": tool, "who": who, "when": _now()}, by)

        step = self._log.append(make)
        return Kept(0, f"{said[0]} Nothing was undone." if said else "") if step is None else Kept(step.number)

    def _change(self, frame: int, content: Mapping[str, Any], *, after: int, by: str) -> Kept:
        said: list[str] = []

        def make(steps: tuple[Step, ...]) -> Line:
            said.extend(_contradiction(self._of_frame(steps, frame), after, by))
            return self._line(steps, frame, {**content, "beside": bool(said)}, by)

        step = self._log.append(make)
        number = 0 if step is None else step.number
        return Kept(number, f"{said[0]} Yours is kept beside it as version {number}." if said else "")

    def _line(self, steps: Sequence[Step], frame: int, content: Mapping[str, Any], by: str) -> Line:
        number = steps[-1].number + 1 if steps else 1
        place = {"video": self.video, "path": str(self._view.video_path.absolute())}
        who = str(content["who"])[:WORDS_MAX]
        return {"number": number, "frame": frame, **place, "by": by, "beside": False, **content, "who": who}

    def _of_frame(self, steps: Sequence[Step], frame: int) -> FrameHistory:
        return FrameHistory.of([step for step in self._of_video(steps) if step.frame == frame])

    def _of_video(self, steps: Sequence[Step]) -> list[Step]:
        """Those that were made on the video as it is now, which is read only where there are any."""
        video = self.video if steps else ""
        return [step for step in steps if step.video == video]


def video_digest(path: Path) -> str:
    """The first digits of the SHA-256 of a video's content, which tell whether it has changed.

    Raises:
        FileError: it cannot be read.
    """
    return _video_digest(path, file_fingerprint(path))


@lru_cache(maxsize=VIDEOS_KEPT)
def _video_digest(path: Path, _fingerprint: str) -> str:
    try:
        return file_sha256(path)[:VIDEO_DIGITS]
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error


def _contradiction(history: FrameHistory, after: int, by: str) -> list[str]:
    """A sentence if somebody else changed a frame after a version; none if nobody did."""
    others = [step for step in history.steps if step.number > after and not step.is_beside and step.by != by]
    if not others:
        return []
    last = others[-1]
    return [f"{last.who or 'Somebody'} changed this mask at {last.when[11:19]} UTC, after you had opened it."]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
