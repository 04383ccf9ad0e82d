"""How good the estimates are, on which containers, and why."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.evaluation.judged import has_truth
from corsmal.ui.evaluation.runs import chosen_run
from corsmal.ui.evaluation.sections import section_control, show_section

st.title("Evaluation")
dataset, _ = session.opened()
run = chosen_run(dataset)
if run is not None and run.rows:
    show_section(section_control() if has_truth(dataset) else "Recordings", run, dataset)
