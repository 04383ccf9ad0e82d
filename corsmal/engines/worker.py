"""A worker process: calls what its parent sends through a private connection, until the parent hangs up or dies."""

import fcntl
import os
import signal
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import NoReturn


def main() -> None:
    """Serve the connection whose file descriptor is the first argument; standard input is a pipe of the parent's."""
    signal.signal(signal.SIGTERM, _leave)
    # The parent's death closes the pipe, and on Linux the kernel then ends this process with SIGIO, whatever it does
    fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(0, fcntl.F_SETFL, fcntl.fcntl(0, fcntl.F_GETFL) | os.O_ASYNC)
    connection = Connection(int(sys.argv[1]))
    with suppress(EOFError, OSError):
        while True:
            function, *arguments = connection.recv()
            connection.send(function(*arguments))


def _leave(*_signal: object) -> NoReturn:
    """End by an exception, which removes unfinished files."""
    raise SystemExit


if __name__ == "__main__":
    main()
