"""The sections of the Evaluation page; only the one that is shown is computed."""

from collections.abc import Sequence

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import STAMPS
from corsmal.evaluation.flagged import flag_counts
from corsmal.evaluation.protocols import Protocol
from corsmal.evaluation.typesetting import TITLES
from corsmal.notes import FLAGS
from corsmal.runs.run import Run
from corsmal.ui import session
from corsmal.ui.evaluation.attribution import attribution_section
from corsmal.ui.evaluation.comparison import comparison_section
from corsmal.ui.evaluation.confidence import confidence_section
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
    "Confidence": confidence_section,
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


def flags_control(tables: Sequence[pd.DataFrame]) -> tuple[str, ...]:
    """Choose flags whose rows are left out of estimates tables; nothing is shown where no row raises one."""
    counts = flag_counts(pd.DataFrame({"flags": [flags for table in tables for flags in table["flags"]]}))
    chosen, state = session.choice().without, st.session_state
    options = [*counts, *(flag for flag in chosen if flag not in counts)]
    if not options:
        return ()
    state["without_control"] = list(chosen)
    st.multiselect(
        "Leave out rows with flags",
        options,
        key="without_control",
        format_func=lambda flag: f"{flag} ({counts.get(flag, 0)})",
        placeholder="none",
        help="What was assumed, cut or implausible; the number of rows stands in brackets. "
        + " ".join(f"`{flag}`: {FLAGS[flag]}" for flag in options if flag in FLAGS),
        on_change=lambda: session.choose(without=tuple(state["without_control"])),
    )
    return chosen


@st.fragment
@guarded()
def show_section(name: str, run: Run, dataset: Dataset) -> None:
    """Draw one section."""
    left, right = st.columns(2, vertical_alignment="bottom")
    with left:
        protocol = protocol_control()
    with right:
        judged = Judged(run, dataset, protocol, flags_control([run.table]))
    left_out = len(run.table) - len(judged.table)
    if left_out:
        st.caption(
            f":material/flag: {left_out} of {len(run.table)} rows are left out, here, in downloads and in the report."
        )
    notes(judged.errors().attrs.get("notes", ()))
    SECTIONS[name](judged)
