"""The report of a run: its tables, the views that were pinned, and the parameters, in one file."""

from dataclasses import asdict

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import STAMPS, comparison_note, table_2_texts
from corsmal.evaluation.typesetting import UNLIKE
from corsmal.figures.report import report_html
from corsmal.runs.run import Run
from corsmal.ui.evaluation import run_tables
from corsmal.ui.messages import plain
from corsmal.ui.pins import pins


def report_section(run: Run, dataset: Dataset) -> None:
    """What goes into the report, and its download."""
    st.caption(
        "One HTML file that opens without a network: the tables of this run, what was pinned on the other pages, and "
        "the parameters. Nothing is sent anywhere."
    )
    found, protocol = run_tables.split(dataset), run_tables.protocol()
    cells = run_tables.cells(run, dataset)
    scores = run_tables.scores(run, dataset, split=found.split)
    sentences = [
        comparison_note(cells),
        "" if found.split == "train" else UNLIKE,
        *run_tables.errors(run, dataset).attrs["notes"],
    ]
    tables = {
        f"By container ({protocol}): number [95 % interval], recordings, failures": table_2_texts(cells),
        "Notes": pd.DataFrame({"note": [sentence for sentence in sentences if sentence]}),
        f"The challenge's scores in % ({protocol}). {found}": scores.rename("score").reset_index(),
        "Recordings": run.table,
    }
    parameters = {
        "run": run.name,
        "dataset": dataset.root.name,
        **run.facts(),
        "protocol": protocol,
        "files": run.data_digest,
        **{f"{part} digest": digest for part, digest in run.digests.items() if digest is not None},
        **asdict(run.settings.shape),
    }
    chosen = pins()
    if not chosen:
        st.info(
            "Nothing is pinned yet: the pages have a *Pin* button under what they show.", icon=":material/push_pin:"
        )
    for index, pin in enumerate(chosen):
        left, right = st.columns([8, 1], vertical_alignment="center")
        left.markdown(f":material/push_pin: {plain(pin.title)}")
        right.button("Remove", key=f"unpin_{index}", on_click=_remove, args=(index,), icon=":material/close:")
    st.download_button(
        "Download report (HTML)",
        lambda: report_html(
            f"Run {run.name}", banner=STAMPS[protocol], tables=tables, pins=chosen, parameters=parameters
        ).encode(),
        "report.html",
        "text/html",
        icon=":material/download:",
        on_click="ignore",
    )


def _remove(index: int) -> None:
    del pins()[index]
