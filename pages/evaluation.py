"""How good the estimates are, on which containers, and why."""

import streamlit as st

from corsmal.ui import session
from corsmal.ui.evaluation.all_runs import all_runs
from corsmal.ui.evaluation.judged import has_truth
from corsmal.ui.evaluation.reproduction import reproduction_section
from corsmal.ui.evaluation.rules import rules_section
from corsmal.ui.evaluation.runs import chosen_run
from corsmal.ui.evaluation.sections import section_control, show_section
from corsmal.ui.one_of import one_of

VIEWS = {"results": "Results", "runs": "All runs", "reproduction": "Reproduce Table 2", "rules": "Paper and program"}

st.title("Evaluation")
dataset, _ = session.opened()
view = one_of("", VIEWS, key="evaluation_view", field="view")
if view == "reproduction":
    reproduction_section(dataset)
elif view == "rules":
    rules_section(dataset)
elif view == "runs":
    all_runs(dataset)
else:
    run = chosen_run(dataset)
    if run is not None and run.rows:
        show_section(section_control() if has_truth(dataset) else "Recordings", run, dataset)
