"""What the server does when it starts: what would make the first visitors wait is begun before they come."""

import gc
import importlib
import threading

from starlette.routing import Route
from streamlit.runtime.pages_manager import PagesManager

from corsmal.synthetic import start_processes
from corsmal.ui import folders

LIBRARIES_AFTER_S = 20.0
"""The first page and a new demo come first."""


def start() -> list[Route]:
    """Begin to make a demo that is not there, and have large libraries loaded later.

    Returns:
        The routes of the application.
    """
    PagesManager.uses_pages_directory = False  # an address of a page opened first must go through the script, too
    if folders.is_demo(folders.default_folder()) and not folders.is_demo_ready():
        # its processes come before anything that takes long to import here
        processes = start_processes(folders.demo_folder())
        importlib.import_module("corsmal.ui.demo").begin(processes)
    libraries = threading.Timer(LIBRARIES_AFTER_S, _load_libraries)
    libraries.daemon = True
    libraries.start()
    routes: list[Route] = importlib.import_module("corsmal.ui.routes").routes()
    gc.freeze()  # Streamlit collects garbage after every run of the script; what is loaded here stays
    return routes


def _load_libraries() -> None:
    """Load what the first visitor of some page would wait seconds for."""
    importlib.import_module("torch")
    gc.collect()
    gc.freeze()
