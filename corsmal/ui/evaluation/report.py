"""The report of a run: its tables, the views that were pinned, and the parameters, in one file."""

from dataclasses import asdict

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import beside_paper
from corsmal.runs.run import Run
from corsmal.ui.evaluation import cached as evaluation
from corsmal.ui.pins import report_panel


def report_section(run: Run, dataset: Dataset) -> None:
    """What goes into the report, and its download."""
    st.caption(
        "One HTML file that opens without a network: the tables of this run, what was pinned on the other pages, and "
        "the parameters. Nothing is sent anywhere."
    )
    by_container = evaluation.containers(run, dataset)
    tables = {
        "By container: MPF1 and MAPE in %": by_container,
        "Beside the paper's Table 2": beside_paper(by_container),
        "The challenge's scores in %": evaluation.scores(run, dataset, split="other").rename("score").reset_index(),
        "Recordings": run.table,
    }
    parameters = {
        "run": run.name,
        "dataset": dataset.root.name,
        **run.facts(),
        "files": run.data_digest,
        **{f"{part} digest": digest for part, digest in run.digests.items() if digest is not None},
        **asdict(run.settings.shape),
    }
    report_panel(f"Run {run.name}", tables, parameters)
