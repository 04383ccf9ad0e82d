"""The sections of the Evaluation page; only the one that is shown is computed."""

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import PROTOCOLS, STAMPS
from corsmal.evaluation.typesetting import TITLES
from corsmal.runs.run import Run
from corsmal.ui.evaluation import run_tables
from corsmal.ui.evaluation.attribution import attribution_section
from corsmal.ui.evaluation.comparison import comparison_section
from corsmal.ui.evaluation.downloads import notes
from corsmal.ui.evaluation.errors import confusion_section, spread_section
from corsmal.ui.evaluation.leaderboard import leaderboard_section
from corsmal.ui.evaluation.report import report_section
from corsmal.ui.evaluation.sweep import sweep_section
from corsmal.ui.evaluation.tables import container_section, rows_section
from corsmal.ui.messages import guarded
from corsmal.ui.one_of import one_of

SECTIONS = {
    "Containers": container_section,
    "Errors": spread_section,
    "Confusion": confusion_section,
    "Leaderboard": leaderboard_section,
    "Recordings": rows_section,
    "Compare": comparison_section,
    "Attribution": attribution_section,
    "Sweep": sweep_section,
    "Report": report_section,
}


def section_control() -> str:
    """Choose what is shown."""
    return one_of("", {name: name for name in SECTIONS}, key="section_control")


def protocol_control() -> None:
    """Choose which numbers count, and say so where some are in-sample."""
    st.session_state["protocol_control"] = run_tables.protocol()
    st.segmented_control(
        "Numbers that count",
        PROTOCOLS,
        key="protocol_control",
        required=True,
        format_func=TITLES.__getitem__,
        help="Filling and mass come from networks. " + " ".join(STAMPS.values()),
        on_change=lambda: st.session_state.update({run_tables.PROTOCOL: st.session_state["protocol_control"]}),
    )
    if run_tables.protocol() == "in-sample":
        st.warning(f"**{STAMPS['in-sample']}**", icon=":material/warning:")


@st.fragment
@guarded()
def show_section(name: str, run: Run, dataset: Dataset) -> None:
    """Draw one section."""
    protocol_control()
    notes(run_tables.errors(run, dataset).attrs.get("notes", ()))
    SECTIONS[name](run, dataset)


def can_be_judged(dataset: Dataset) -> bool:
    """Whether there is a truth to hold estimates against; if not, the page says what to do."""
    if run_tables.is_annotated(dataset):
        return True
    st.info(
        "There is no annotation with a truth here, so nothing can be evaluated: put `ccm_train_annotation.json` (or "
        "`.csv`) into the dataset's folder. The estimates themselves are below, and can be submitted.",
        icon=":material/rule:",
    )
    return False
