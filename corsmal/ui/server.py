"""What the server does when it starts, little, and then it loads what visitors would wait for; and what at its end."""

import asyncio
import gc
import importlib
import logging
import os
import signal
import sys
import threading
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from functools import partial
from types import FrameType

from starlette.routing import Route
from streamlit.runtime.pages_manager import PagesManager

from corsmal.errors import CorsmalError
from corsmal.ui.routes import routes

PAGES_AFTER_S, FITS_AFTER_S, NETWORKS_AFTER_S = 0.3, 3.0, 20.0
"""When to load, s after the start: what pages need while the browser loads Streamlit, the rest after the first page.
Between them another process compiles what the first fit of an installation would wait for, 9 s."""

READING_S = 0.5
"""For how long a server that is stopped waits until its visitors have read what they asked for."""

SWITCH_S = 0.0005
"""For how long a thread that computes may keep the interpreter from one that answers a visitor. By default it is ten
times as long, and a page asks for the interpreter some hundred times."""

OF_PAGES = (
    "corsmal.ui.sidebar",
    "corsmal.ui.opened",
    "corsmal.ui.detecting",
    "corsmal.ui.linked_plot.component",
    "corsmal.ui.media",
    "corsmal.ui.filling.sound",
    "corsmal.ui.recordings",
)
OF_NETWORKS = ("torch", "corsmal.shape.kernels")


def start() -> list[Route]:
    """Have libraries loaded in the background.

    Returns:
        The routes of the application.
    """
    _log_jobs()
    PagesManager.uses_pages_directory = False  # an address of a page opened first must go through the script, too
    for delay_s, work in (
        (PAGES_AFTER_S, partial(_load, OF_PAGES)),
        (FITS_AFTER_S, _compile),
        (NETWORKS_AFTER_S, partial(_load, OF_NETWORKS)),
    ):
        timer = threading.Timer(delay_s, work)
        timer.daemon = True
        timer.start()
    return routes()


def _log_jobs() -> None:
    """Print which jobs had the cores; the rest of the log belongs to Streamlit."""
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s"))
    jobs = logging.getLogger("corsmal.ui.jobs")
    jobs.setLevel(logging.INFO)
    jobs.handlers = [handler]
    jobs.propagate = False


@asynccontextmanager
async def lifespan(_app: object) -> AsyncIterator[None]:
    """From the start of the application to its end, at which background jobs keep what they have found and stop.

    A server that is sent SIGTERM ends by that signal, without what Python does at its exit.
    """
    if threading.current_thread() is threading.main_thread():
        _end_in_time()
    sys.setswitchinterval(SWITCH_S)  # not before: what is loaded until then would take longer
    yield
    await asyncio.to_thread(_stop_jobs)


def _end_in_time() -> None:
    """At SIGTERM wait only so long for visitors who do not read what they asked for; the web server would for ever."""
    handle = signal.getsignal(signal.SIGTERM)

    def end(number: int, frame: FrameType | None) -> None:
        if callable(handle):
            handle(number, frame)
        timer = threading.Timer(READING_S, _force)
        timer.daemon = True
        timer.start()

    if callable(handle):
        signal.signal(signal.SIGTERM, end)


def _force() -> None:
    _stop_jobs()
    os.kill(os.getpid(), signal.SIGINT)  # the second signal, at which the web server leaves its visitors


def _stop_jobs() -> None:
    jobs = getattr(sys.modules.get("corsmal.ui.shared"), "jobs", None)
    if jobs is not None:  # the server may be stopped before, or while, its pages are loaded
        jobs().stop()


def _compile() -> None:
    from corsmal.engines.processes import Processes  # noqa: PLC0415 - the server starts before anything is loaded
    from corsmal.shape.compiling import compile_fits  # noqa: PLC0415

    with suppress(CorsmalError):  # without a process each fit compiles what it needs
        list(Processes(1, gives_way=True)(compile_fits, [None]))


def _load(names: Sequence[str]) -> None:
    for name in names:
        importlib.import_module(name)
    gc.collect()
    gc.freeze()  # Streamlit collects garbage after every run of the script; what is loaded here stays
