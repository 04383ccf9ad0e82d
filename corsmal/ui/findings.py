"""What is wrong with a dataset's files, for the whole set and for one recording, and the check that opens them all."""

from functools import cache

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset, Recording
from corsmal.dataset.findings import SEVERITIES, Finding, in_order
from corsmal.digests import digest
from corsmal.engines.engine import completed_rows
from corsmal.engines.local import local_engine
from corsmal.stages.checkup import examined_findings, set_findings
from corsmal.stages.examination import ExamineTask
from corsmal.ui import shared
from corsmal.ui.folders import is_read_only
from corsmal.ui.following import follow
from corsmal.ui.jobs import Job, Priority
from corsmal.ui.messages import plain

COLUMNS = {
    "severity": st.column_config.TextColumn("severity", width="small"),
    "recording": st.column_config.TextColumn("recording", width="small"),
    "file": st.column_config.TextColumn("file", width="medium"),
    "what": st.column_config.TextColumn("finding", width="large"),
    "advice": st.column_config.TextColumn("what to do", width="large"),
}
ICONS = {"error": ":material/error:", "warning": ":material/warning:", "note": ":material/info:"}


@cache
def _examined() -> dict[str, tuple[Finding, ...]]:
    """What checks found, by the key of their job."""
    return {}


def known_findings(dataset: Dataset) -> list[Finding]:
    """What opening the folder found, and, once it was checked, what its files hold."""
    return in_order([*set_findings(dataset, list(dataset)), *_examined().get(_key(dataset), ())])


def show_findings(dataset: Dataset) -> None:
    """The findings of the whole set, with the button that opens all files."""
    found = known_findings(dataset)
    with st.expander(counted(found), key="findings_expander", icon=ICONS[found[0].severity if found else "note"]):
        if found:
            rows = pd.DataFrame([finding.to_json() for finding in found])[list(COLUMNS)]
            st.dataframe(rows, key="findings", hide_index=True, column_config=COLUMNS, height="auto")
        key = _key(dataset)
        is_checked = key in _examined()
        if not follow(key, unit="recordings"):
            left, right = st.columns([1, 3], vertical_alignment="center")
            left.button(
                "Check all files again" if is_checked else "Check all files",
                on_click=_start,
                args=(dataset,),
                disabled=is_read_only(),
                icon=":material/fact_check:",
            )
            right.caption(
                "Every file was opened." if is_checked else "So far only names and tables were read.",
                help="Opens every file, of videos and sound the headers, and compares calibration with detections. "
                "`doctor --deep` reads everything.",
            )


def show_recordings_findings(dataset: Dataset, recording: Recording) -> None:
    """The findings of one recording."""
    for finding in known_findings(dataset):
        if finding.recording == recording.id and finding.kind != "missing":
            show = st.warning if finding.is_problem else st.info
            show(plain(str(finding)), icon=ICONS[finding.severity])


def counted(findings: list[Finding]) -> str:
    """How many findings there are of each severity, in words."""
    counts = {severity: sum(finding.severity == severity for finding in findings) for severity in SEVERITIES}
    parts = [f"{count} {severity}{'' if count == 1 else 's'}" for severity, count in counts.items() if count]
    return f"Files: {', '.join(parts)}" if parts else "Files: nothing to report"


def _key(dataset: Dataset) -> str:
    return f"check {digest('check', str(dataset.root), [str(finding) for finding in dataset.findings], dataset.ids)}"


def _start(dataset: Dataset) -> None:
    key, recordings = _key(dataset), list(dataset)

    def work(job: Job) -> None:
        task = ExamineTask(shared.store().root.resolve())
        engine = local_engine(len(recordings), gives_way=True)
        rows = list(completed_rows(task, recordings, engine=engine, progress=job.advance, cancelled=job.cancelled))
        if not job.cancelled():
            _examined()[key] = tuple(examined_findings(rows, root=dataset.root))

    shared.jobs().start(key, "Checking files", work, priority=Priority.SHOWN)
