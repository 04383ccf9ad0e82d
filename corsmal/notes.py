"""What is said besides numbers: sentences on an estimate, the flags that a program reads, and sentences of stores."""

import contextlib
from collections.abc import Iterable, Iterator
from contextvars import ContextVar

FLAGS = {
    "detections-interpreted": "Frames, classes or scores of a detections file were read in a way that the notes name.",
    "detections-incomplete": "Part of a detections file could not be used, or it holds no container's class.",
    "by-hand": "Masks by hand took the place of detected ones, or could not be used.",
    "views-by-time": "The views differ in frame rate, number of frames or start, and were matched by time.",
    "views-by-index": "The views differ in frame rate, number of frames or start, and were matched by frame number.",
    "unit-assumed": "The cameras' translations were taken for millimetres or centimetres.",
    "implausible": "A camera, the container's size or the distance between the views' rays is not plausible.",
    "width-missing": "A width could not be measured by itself, and is a training mean or missing.",
    "frame-fallback": "No frame passed the rules of selection, and a fixed one was taken.",
    "sound-repaired": "The sound file's samples were rescaled, or its header is wrong and was not followed.",
    "sound-cut": "The sound was cut where its recorder should have been stopped.",
    "sound-outside-training": "The sound's sampling rate is lower than that of the sound the network learned from.",
    "mass-assumed": "The container's mass is the training set's least or mean one: the network had no answer.",
    "dimensions-assumed": "The container's mass was predicted from the training set's mean dimensions.",
    "network-synthetic": "A network that was trained on synthetic recordings only judged a real one.",
}
"""The flags that an estimate may carry, and what each says."""

SEPARATOR = "; "


class Note(str):
    """A sentence that raises a flag; wherever only the sentence counts, it is a string like any other.

    Args:
        sentence: for people.
        flag: one of ``FLAGS``.
    """

    flag: str
    __slots__ = ("flag",)

    def __new__(cls, sentence: str, *, flag: str) -> "Note":
        """See the class."""
        note = super().__new__(cls, sentence)
        note.flag = flag
        return note

    def __reduce__(self) -> tuple[object, ...]:
        return _note, (str(self), self.flag)


def _note(sentence: str, flag: str) -> Note:
    return Note(sentence, flag=flag)


def flags_of(sentences: Iterable[str]) -> tuple[str, ...]:
    """The flags that sentences raise, each once, in the order of ``FLAGS``."""
    raised = {sentence.flag for sentence in sentences if isinstance(sentence, Note)}
    return tuple(flag for flag in FLAGS if flag in raised)


def prefixed(prefix: str, sentence: str) -> str:
    """The sentence with ``prefix`` and a colon before it, and its flag, if it has one."""
    text = f"{prefix}: {sentence}"
    return Note(text, flag=sentence.flag) if isinstance(sentence, Note) else text


_said: ContextVar[list[str] | None] = ContextVar("_said", default=None)


@contextlib.contextmanager
def listening() -> Iterator[list[str]]:
    """Gather the sentences that all stores of this thread add to their ``problems`` within the block."""
    said: list[str] = []
    token = _said.set(said)
    try:
        yield said
    finally:
        _said.reset(token)


def repeat(sentences: Iterable[str]) -> None:
    """Hand sentences, such as those from another process, to the block that is ``listening``, if there is one."""
    said = _said.get()
    if said is not None:
        said.extend(sentences)
