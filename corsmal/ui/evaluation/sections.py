"""The sections of the Evaluation page; only the one that is shown is computed."""

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import STAMPS
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.typesetting import TITLES
from corsmal.runs.run import Run
from corsmal.ui.evaluation.attribution import attribution_section
from corsmal.ui.evaluation.comparison import comparison_section
from corsmal.ui.evaluation.downloads import notes
from corsmal.ui.evaluation.errors import confusion_section, spread_section
from corsmal.ui.evaluation.judged import Judged
from corsmal.ui.evaluation.leaderboard import leaderboard_section
from corsmal.ui.evaluation.report import report_section
from corsmal.ui.evaluation.summary import summary_section
from corsmal.ui.evaluation.sweep import sweep_section
from corsmal.ui.evaluation.tables import container_section, rows_section
from corsmal.ui.messages import guarded
from corsmal.ui.one_of import one_of

SECTIONS = {
    "Summary": summary_section,
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
    return one_of("", {name: name for name in SECTIONS}, key="section_control", field="section")


def protocol_control() -> Protocol:
    """Choose which numbers count, and say so where some are in-sample."""
    help_text = "Filling and mass come from networks. " + " ".join(STAMPS.values())
    protocol = one_of("Numbers that count", TITLES, key="protocol_control", help_text=help_text, field="protocol")
    if protocol == "in-sample":
        st.warning(f"**{STAMPS[protocol]}**", icon=":material/warning:")
    return protocol


@st.fragment
@guarded()
def show_section(name: str, run: Run, dataset: Dataset) -> None:
    """Draw one section."""
    judged = Judged(run, dataset, protocol_control())
    notes(judged.errors().attrs.get("notes", ()))
    SECTIONS[name](judged)
