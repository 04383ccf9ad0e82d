"""The report of a run: its tables, the views that were pinned, and the parameters, in one file."""

from dataclasses import asdict
from functools import partial

import pandas as pd
import streamlit as st

from corsmal.evaluation import STAMPS, comparison_note, table_2_texts
from corsmal.evaluation.typesetting import UNLIKE
from corsmal.figures.report import report_html
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.evaluation.judged import Judged
from corsmal.ui.messages import plain
from corsmal.ui.pins import pins


def report_section(judged: Judged) -> None:
    """What goes into the report, and its download."""
    st.caption(
        "One HTML file that opens without a network: the tables of this run, what was pinned on the other pages, and "
        "the parameters. Nothing is sent anywhere."
    )
    run, found, protocol, cells = judged.run, judged.split, judged.protocol, judged.cells()
    scores = judged.scores(found.split)
    sentences = [
        comparison_note(cells),
        "" if found.split == "train" else UNLIKE,
        *judged.errors().attrs["notes"],
    ]
    tables = {
        f"By container ({protocol}): number [95 % interval], recordings, failures": table_2_texts(cells),
        "Notes": pd.DataFrame({"note": [sentence for sentence in sentences if sentence]}),
        f"The challenge's scores in % ({protocol}). {found}": scores.rename("score").reset_index(),
        "Recordings": run.table,
    }
    parameters = {
        "run": run.name,
        "dataset": judged.dataset.root.name,
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
    for pin in chosen:
        st.markdown(f":material/push_pin: {plain(pin.title)}")
    if chosen:
        st.caption("Order them, write notes and remove them in *Pins* in the sidebar.")
    report = partial(
        report_html, f"Run {run.name}", banner=STAMPS[protocol], tables=tables, pins=chosen, parameters=parameters
    )
    download_buttons({"Download report (HTML)": ("report.html", lambda: report().encode())})
