"""The app: navigation, the dataset folder and the recording picker. ``streamlit run app.py -- --data DIR``."""

import gc
import importlib
import threading

import streamlit as st
from streamlit.runtime.pages_manager import PagesManager

from corsmal.ui import demo, session
from corsmal.ui.routes import routes

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
    session.begin()
    page.run()


def load_libraries() -> None:
    """Load what the first visitor of some page would wait seconds for.

    Streamlit collects garbage after every run of the script; what is loaded once and never goes is spared that, which
    is most of what there is.
    """
    importlib.import_module("torch")
    gc.collect()
    gc.freeze()


if __name__ == "__main__":
    main()
else:
    PagesManager.uses_pages_directory = False  # an address of a page opened first must go through this file, too
    if demo.is_demo(session.default_folder()):
        demo.begin_ahead()
    libraries = threading.Timer(LIBRARIES_AFTER_S, load_libraries)
    libraries.daemon = True
    libraries.start()
    app = st.App(__file__, routes=routes())
