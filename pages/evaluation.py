"""How good the estimates are, on which containers, and why."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.evaluation.runs import chosen_run
from corsmal.ui.evaluation.sections import can_be_judged, section_control, show_section

st.title("Evaluation")
dataset, _ = session.opened()
run = chosen_run(dataset)
if run is not None and run.rows:
    show_section(section_control() if can_be_judged(dataset) else "Recordings", run, dataset)
