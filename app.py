"""The app: navigation, the dataset folder and the recording picker. ``streamlit run app.py -- --data DIR``."""

import importlib

import streamlit as st

from corsmal.ui import server


def main() -> None:
    """One run of the script: what Streamlit calls for every page and every change."""
    st.set_page_config(page_title="corsmal", page_icon="☕", layout="wide")
    # Paths differ from the files' names on purpose: otherwise Streamlit takes pages/ for its older kind of app
    page = st.navigation(
        [
            st.Page(
                "pages/overview.py",
                title="Overview",
                url_path="answers",
                icon=":material/dashboard:",
                default=True,
            ),
            st.Page("pages/recordings.py", title="Recordings", url_path="dataset", icon=":material/video_library:"),
            st.Page("pages/frames.py", title="Frames", url_path="best-frame", icon=":material/center_focus_strong:"),
            st.Page("pages/shape.py", title="Shape", url_path="hull", icon=":material/deployed_code:"),
            st.Page("pages/filling.py", title="Filling", url_path="sound", icon=":material/graphic_eq:"),
            st.Page("pages/mass.py", title="Mass", url_path="weight", icon=":material/scale:"),
            st.Page("pages/evaluation.py", title="Evaluation", url_path="results", icon=":material/leaderboard:"),
        ]
    )
    with importlib.import_module("corsmal.ui.sidebar").page_run(page.title.lower()):
        page.run()


if __name__ == "__main__":
    main()
else:
    app = st.App(
        __file__, routes=server.start(), lifespan=server.lifespan
    )  # Streamlit looks for this very assignment in the text of the file
