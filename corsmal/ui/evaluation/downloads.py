"""What every section of the Evaluation page may end with: notes, tables as files, the estimates themselves."""

from collections.abc import Callable, Mapping
from functools import partial

import pandas as pd
import plotly.graph_objects as go
import streamlit as st

from corsmal.evaluation import ENDINGS, TABLE_FORMATS, export_table, submission_csv, submission_table
from corsmal.evaluation.estimates import estimates_csv
from corsmal.evaluation.exporting import TableFormat
from corsmal.evaluation.typesetting import TITLES
from corsmal.figures.pins import Pin
from corsmal.figures.style import Part
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.evaluation.judged import Judged
from corsmal.ui.pins import pin_button

NAMES: dict[TableFormat, str] = {"csv": "CSV", "latex": "LaTeX", "html": "HTML", "markdown": "Markdown"}

Exporter = Callable[..., str]
"""Such as ``export_table``: a table and its ``table_format`` to text."""


def submission(judged: Judged) -> None:
    """Buttons for the estimates themselves and for the challenge's file, with a row for every recording."""
    run = judged.run
    download_buttons(
        {
            "Estimates as CSV": (f"{run.name}_estimates.csv", partial(estimates_file, judged)),
            "The challenge's submission file": (
                f"{run.name}_submission.csv",
                partial(submission_file, judged),
            ),
        }
    )


def estimates_file(judged: Judged) -> bytes:
    """A run's estimates as ``runs export`` writes them to a CSV file, without the rows that are left out."""
    return estimates_csv(judged.table).encode()


def submission_file(judged: Judged) -> bytes:
    """The challenge's file as ``submit`` writes it; rows that are left out have no estimate in it."""
    return submission_csv(submission_table(judged.table, recordings=judged.dataset.ids)).encode()


def pin_figure(
    judged: Judged, figure: go.Figure | Part, *, title: str, key: str, numbers: Mapping[str, str] | None = None
) -> None:
    """A button that pins a figure of a run, with what the run was made with.

    Args:
        judged: the run.
        figure: what is shown.
        title: what it is.
        key: of the button.
        numbers: what it shows, with units.
    """
    run = judged.run
    pin_button(
        "the figure",
        lambda: [
            Pin(
                f"{title}, run {run.name}",
                go.Figure(figure),
                numbers=numbers or {},
                parameters={"protocol": TITLES[judged.protocol], **_left_out(judged), **run.facts()},
                run=run.name,
            )
        ],
        key=key,
    )


def _left_out(judged: Judged) -> dict[str, str]:
    return {"rows left out": ", ".join(judged.without)} if judged.without else {}


def notes(sentences: tuple[str, ...]) -> None:
    """What was missing or left out."""
    if sentences:
        with st.expander(
            f"{len(sentences)} note{'' if len(sentences) == 1 else 's'} on what is missing", icon=":material/info:"
        ):
            for sentence in sentences:
                st.text(sentence)


def downloads(table: pd.DataFrame, *, name: str, export: Exporter = export_table) -> None:
    """Buttons for a table in every format."""

    def content(table_format: TableFormat) -> bytes:
        return export(table, table_format=table_format).encode()

    download_buttons({NAMES[each]: (f"{name}{ENDINGS[each]}", partial(content, each)) for each in TABLE_FORMATS})
