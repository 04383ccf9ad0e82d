"""What every section of the Evaluation page may end with: notes, tables as files, the estimates themselves."""

from collections.abc import Callable
from functools import partial

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import ENDINGS, TABLE_FORMATS, export_table, submission_csv, submission_table
from corsmal.evaluation.exporting import TableFormat
from corsmal.runs.run import Run

NAMES: dict[TableFormat, str] = {"csv": "CSV", "latex": "LaTeX", "html": "HTML", "markdown": "Markdown"}

Exporter = Callable[..., str]
"""Such as ``export_table``: a table and its ``table_format`` to text."""


def submission(run: Run, dataset: Dataset) -> None:
    """Buttons for the estimates themselves and for the challenge's file, with a row for every recording."""
    left, right = st.columns(2)
    left.download_button(
        "Estimates as CSV",
        partial(estimates_file, run),
        f"{run.name}_estimates.csv",
        icon=":material/table:",
        on_click="ignore",
        width="stretch",
    )
    right.download_button(
        "The challenge's submission file",
        partial(submission_file, run, dataset),
        f"{run.name}_submission.csv",
        icon=":material/upload_file:",
        on_click="ignore",
        width="stretch",
    )


def estimates_file(run: Run) -> bytes:
    """A run's estimates as ``runs export`` writes them to a CSV file."""
    return run.table.to_csv(index=False).encode()


def submission_file(run: Run, dataset: Dataset) -> bytes:
    """The challenge's file as ``submit`` writes it."""
    return submission_csv(submission_table(run.table, recordings=dataset.ids)).encode()


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
    columns = st.columns(len(TABLE_FORMATS))
    for column, table_format in zip(columns, TABLE_FORMATS, strict=True):
        column.download_button(
            NAMES[table_format],
            partial(_exported, export, table, table_format),
            f"{name}{ENDINGS[table_format]}",
            key=f"download {name} {table_format}",
            icon=":material/download:",
            on_click="ignore",
            width="stretch",
        )


def _exported(export: Exporter, table: pd.DataFrame, table_format: TableFormat) -> bytes:
    return export(table, table_format=table_format).encode()
