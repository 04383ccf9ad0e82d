"""How a process ends with the one that started it, however that one ends."""

import fcntl
import os
import select
import signal
import sys
import threading


def end_with(pipe: int) -> None:
    """End this process, whatever it does, as soon as the other end of a pipe is closed, as its owner's death does.

    On Linux the kernel sees to it: no long call of a compiled library delays it. Elsewhere, and where the owner was
    dead before this call, a thread does.

    Args:
        pipe: file descriptor of the end that is read; nothing is ever written to the other one.
    """
    if sys.platform == "linux":  # where SIGIO ends a process
        fcntl.fcntl(pipe, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    threading.Thread(target=_watch, args=(pipe,), name="lifeline", daemon=True).start()


def _watch(pipe: int) -> None:
    select.select([pipe], [], [])
    os.kill(os.getpid(), signal.SIGKILL)
