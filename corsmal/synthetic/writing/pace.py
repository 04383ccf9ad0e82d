"""How far the making of a dataset is, and how long it will still take."""

import time
from collections import deque
from collections.abc import Callable, Sequence

from corsmal.synthetic.writing.parts import PARTS, SOUND

SOUND_COST = 0.125
"""What the sound of a recording takes, of the time that one of its views takes."""

WINDOW = 16
"""The pace is that of the last pieces, four recordings of them: it follows what else the machine does."""


class Pace:
    """The work that is done and left, in views of a recording, and its pace.

    The first piece starts the clock: until it is made, kernels are compiled, which takes as long as several pieces.

    Args:
        recordings: how many the dataset has.
        parts: of the pieces that are to be made.
        clock_s: tells the time.
    """

    def __init__(self, recordings: int, parts: Sequence[str], *, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._total = recordings * sum(map(_cost, PARTS))
        self._left = sum(map(_cost, parts))
        self._clock_s = clock_s
        self._made: deque[tuple[float, float]] = deque(maxlen=WINDOW + 1)

    @property
    def fraction(self) -> float:
        """Share of the work that is done, 0..1."""
        return 1 - self._left / self._total

    @property
    def left_s(self) -> float | None:
        """How long the rest will take at the pace of the last pieces; None before two pieces are made."""
        if len(self._made) < 2:
            return None
        (first_s, first_left), (last_s, last_left) = self._made[0], self._made[-1]
        return (last_s - first_s) / (first_left - last_left) * self._left

    def note(self, part: str) -> None:
        """A piece was made."""
        self._left = max(0.0, self._left - _cost(part))
        self._made.append((self._clock_s(), self._left))


def _cost(part: str) -> float:
    return SOUND_COST if part == SOUND else 1.0
