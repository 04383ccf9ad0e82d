"""A worker process: calls what its parent sends through a private connection, until the parent hangs up or dies."""

import signal
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import NoReturn

from corsmal.engines.lifeline import end_with


def main() -> None:
    """Serve the connection whose file descriptor is the first argument; standard input is a pipe of the parent's."""
    end_with(0)
    serve(Connection(int(sys.argv[1])))


def serve(connection: Connection) -> None:
    """Call what is sent, and send what it returns, until the other end is closed or SIGTERM arrives."""
    signal.signal(signal.SIGTERM, _leave)
    with suppress(EOFError, OSError):
        while True:
            function, *arguments = connection.recv()
            connection.send(function(*arguments))


def _leave(*_signal: object) -> NoReturn:
    """End by an exception, which removes unfinished files."""
    raise SystemExit


if __name__ == "__main__":
    main()
