"""The report of a run: what goes into it, making it in the background, and its download."""

import uuid
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.figures.pin_collections import Collection
from corsmal.figures.report import Report, draw_report, report_html
from corsmal.runs.report import run_report
from corsmal.runs.run import Run
from corsmal.ui import shared
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.evaluation.judged import Judged, runs
from corsmal.ui.following import follow
from corsmal.ui.job import Job, Priority
from corsmal.ui.messages import plain
from corsmal.ui.pins.pinning import collection

JOB = "report_job"
KEPT_MAX = 8


@dataclass(frozen=True)
class MadeReport:
    """A report that can be downloaded.

    Args:
        name: of the file.
        content: the file.
        note: what is to be said about it; may be empty.
    """

    name: str
    content: bytes
    note: str


def report_section(judged: Judged) -> None:
    """What goes into the report, a button that makes it, and its download."""
    st.caption(
        "One HTML file that opens and prints without a network: what was tried and on what, the results beside the "
        "paper's, what was pinned on the other pages, and all parameters. Nothing is sent anywhere."
    )
    left, middle, right = st.columns(3)
    title = left.text_input("Title", placeholder="Run and dataset", max_chars=120, key="report_title")
    author = middle.text_input("Author", max_chars=80, key="report_author")
    others = {run.name: run for run in runs(judged.dataset) if run.name != judged.run.name and run.rows}
    against = right.selectbox(
        "Compare with", [None, *others], format_func=lambda name: name or "no other run", key="report_against"
    )
    pinned = _pinned()

    def make() -> Report:
        return run_report(
            judged.run,
            judged.dataset,
            protocol=judged.protocol,
            without=judged.without,
            against=others.get(str(against)),
            pins=pinned.load(store=shared.store()),
            title=title.strip(),
            author=author.strip(),
        )

    key = str(st.session_state.get(JOB, ""))
    if st.button("Make report", type="primary", icon=":material/description:", disabled=shared.jobs().is_active(key)):
        key = st.session_state[JOB] = f"report {uuid.uuid4().hex}"
        shared.jobs().start(
            key, "Report", partial(_make, key, judged.run, make), priority=Priority.NOW, is_for_guests=True
        )
    follow(key, unit="figures")
    made = _made().get(key)
    if made is not None:
        if made.note:
            st.caption(f":material/info: {plain(made.note)}")
        st.caption(f"Made: {plain(made.name)}, {len(made.content) / 1e6:.1f} MB.")
        download_buttons({"Download report (HTML)": (made.name, lambda: made.content)})


def _pinned() -> Collection:
    """What is pinned in the open collection; the tray in the sidebar changes it."""
    found = collection()
    if not found.pins:
        st.info(
            "Nothing is pinned yet: the pages have a *Pin* button under what they show.", icon=":material/push_pin:"
        )
    for pin in found.pins:
        st.markdown(f":material/push_pin: {plain(pin.title)}")
    if found.pins:
        st.caption("Order them, write notes and remove them in *Pins* in the sidebar.")
    return found


def _make(key: str, run: Run, make: Callable[[], Report], job: Job) -> None:
    """Make a report in the background and keep it for the session that asked."""
    report, pictures, note = make(), list[bytes](), ""
    try:
        pictures = draw_report(report, progress=job.advance, cancelled=job.cancelled)
    except CorsmalError as error:
        note = f"The reader's browser will draw the figures: {error}."
    if job.cancelled():
        return
    kept = _made()
    kept[key] = MadeReport(f"{run.name}_report.html", report_html(report, pictures=pictures).encode(), note)
    while len(kept) > KEPT_MAX:
        kept.popitem(last=False)


@cache
def _made() -> OrderedDict[str, MadeReport]:
    """The latest reports of this server, by the key of their job, which only their session knows."""
    return OrderedDict()
