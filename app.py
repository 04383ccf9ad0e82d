"""The app: navigation, the dataset folder and the recording picker. ``streamlit run app.py -- --data DIR``."""

import gc
import importlib
import threading

import streamlit as st
from streamlit.runtime.pages_manager import PagesManager

from corsmal.synthetic.writing.parts import STAGING
from corsmal.synthetic.writing.worker import start_ahead
from corsmal.ui import folders

LIBRARIES_AFTER_S = 20.0  # the first page and a new demo come first


def main() -> None:
    """One run of the script: what Streamlit calls for every page and every change."""
    st.set_page_config(page_title="corsmal", page_icon="☕", layout="wide")
    # Paths differ from the files' names on purpose: otherwise Streamlit takes pages/ for its older kind of app
    page = st.navigation(
        [
            st.Page(
                "pages/recordings.py",
                title="Recordings",
                url_path="dataset",
                icon=":material/video_library:",
                default=True,
            ),
            st.Page("pages/frames.py", title="Frames", url_path="best-frame", icon=":material/center_focus_strong:"),
            st.Page("pages/shape.py", title="Shape", url_path="hull", icon=":material/deployed_code:"),
            st.Page("pages/filling.py", title="Filling", url_path="sound", icon=":material/graphic_eq:"),
            st.Page("pages/mass.py", title="Mass", url_path="weight", icon=":material/scale:"),
            st.Page("pages/evaluation.py", title="Evaluation", url_path="results", icon=":material/leaderboard:"),
        ]
    )
    importlib.import_module("corsmal.ui.session").begin()
    page.run()


def begin_demo() -> None:
    """Begin to make a demo that is not there before the first page is asked for: a browser takes seconds to come.

    Its processes come before anything that takes long to import.
    """
    if folders.is_demo(folders.default_folder()) and not folders.is_demo_ready():
        start_ahead(folders.demo_folder() / STAGING)
        importlib.import_module("corsmal.ui.demo").begin()


def load_libraries() -> None:
    """Load what the first visitor of some page would wait seconds for."""
    importlib.import_module("torch")
    gc.collect()
    spare_what_is_loaded()


def spare_what_is_loaded() -> None:
    """Streamlit collects garbage after every run of the script; most of what there is was loaded once and stays."""
    gc.freeze()


if __name__ == "__main__":
    main()
else:
    PagesManager.uses_pages_directory = False  # an address of a page opened first must go through this file, too
    begin_demo()
    libraries = threading.Timer(LIBRARIES_AFTER_S, load_libraries)
    libraries.daemon = True
    libraries.start()
    app = st.App(__file__, routes=importlib.import_module("corsmal.ui.routes").routes())
    spare_what_is_loaded()
