"""A task of a batch that fails on purpose; other processes import it, so that it loads little."""

import os
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path

from corsmal.errors import CorsmalError
from corsmal.store import Store


@dataclass(frozen=True)
class Faulty:
    """A task of a batch that fails for some recordings, in the ways that ``raises`` names.

    ``once``: a file that is made by the first failure, after which there are no more. ``pids``: a folder that gets a
    file for every process that was asked.
    """

    raises: dict[str, str] = field(default_factory=dict)
    once: Path | None = None
    pids: Path | None = None

    def __call__(self, recording):
        if self.pids is not None:
            (self.pids / str(os.getpid())).touch()
        fault = self.raises.get(recording.id)
        if self.once is not None and fault:
            fault = None if self.once.exists() else fault
            self.once.touch()
        if fault == "clear":
            raise CorsmalError("the recording is broken")
        if fault == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if fault == "pause":
            time.sleep(0.3)
        if fault == "sleep":
            time.sleep(600)
        if fault == "compute":
            sum(range(10**12))  # as in a long call of a compiled library: no signal is handled, no thread is switched
        return {"recording_id": recording.id, "status": "done", "ratio": 1 / (fault != "unforeseen")}


@dataclass(frozen=True)
class ReadsStore:
    """A task that looks for a kept result under a key."""

    cache: Path
    key: str

    def __call__(self, recording):
        Store(self.cache).json("fits", self.key)
        return {"recording_id": recording.id, "status": "done"}


def wait_for(condition, *, seconds=120):
    end_s = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end_s, "it did not happen"
        time.sleep(0.02)
