"""The challenge's submission file: one row per recording, −1 where there is no estimate."""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from corsmal.dataset.headings import Columns
from corsmal.dataset.ids import recording_id
from corsmal.errors import ArgumentError, FileError
from corsmal.evaluation.checking import Checked, listed, numbers_of, rows_of
from corsmal.evaluation.estimates import estimates_table
from corsmal.evaluation.foreign import SOURCES, UNITS, read_frame
from corsmal.evaluation.metrics import NO_ESTIMATE
from corsmal.files import writing
from corsmal.quantities import QUANTITIES

ID_COLUMN = "Configuration ID"

SCORED_COLUMNS = {quantity.submission_column: quantity.name for quantity in QUANTITIES}
"""The columns that are scored, and what an estimates table calls them."""

_SIMULATED = ("Object safety", "Distance", "Angle difference")
"""Columns that only the challenge's simulator can fill."""

SUBMISSION_COLUMNS = (ID_COLUMN, *list(SOURCES)[:-1], *_SIMULATED, "Execution time")
"""All columns of the file, in order."""


_TABLE_COLUMNS = Columns(
    ids=ID_COLUMN,
    spellings={name: (SOURCES[name],) if name in SOURCES else () for name in SUBMISSION_COLUMNS[1:]},
    units=UNITS,
)


def read_submission(path: str | Path) -> pd.DataFrame:
    """Read a submission file, whatever program wrote it: text with any separator, JSON or Parquet.

    Returns:
        Those of ``SUBMISSION_COLUMNS`` that it has, and its others; ``attrs`` holds under ``foreign.ASSUMED`` sentences
        on how the file was read, which the scores' notes repeat.

    Raises:
        FileError: the file is absent, broken, no submission, or can be read in two ways.
    """
    path = Path(path)
    table = read_frame(path, _TABLE_COLUMNS)
    if ID_COLUMN not in table:
        columns = ", ".join(map(str, table.columns[:8]))
        raise FileError(path, f"is no submission: it has no column {ID_COLUMN!r} but {columns or 'none'}")
    return table


def submission_table(estimates: pd.DataFrame, *, recordings: Iterable[str | int] | None = None) -> pd.DataFrame:
    """An estimates table as a submission.

    Args:
        estimates: with columns of ``ESTIMATE_COLUMNS``; a number that is missing or cannot be used becomes −1.
        recordings: ids of the rows that the file must have, in order; default: the estimates'. A recording that the
            estimates lack is −1 throughout.

    Returns:
        ``SUBMISSION_COLUMNS``. An id of digits is a number there, as the challenge writes it.

    Raises:
        ArgumentError: the estimates have no ids, or none of the recordings.
    """
    wanted = estimates_table(estimates)["recording_id"] if recordings is None else recordings
    ids = pd.Index(list(dict.fromkeys(recording_id(value) or str(value) for value in wanted)), dtype="str")
    rows = rows_of(estimates, ids, id_column="recording_id", what="estimates").table
    columns = {source: source for source in SOURCES.values()}
    numbers = numbers_of(rows, columns, what="estimates").table.reindex(ids).fillna(NO_ESTIMATE)
    table = numbers.rename(columns={source: shown for shown, source in SOURCES.items()})
    table = table.round({"Execution time": 0}).astype(dict.fromkeys(("Filling type", "Filling level"), "int64"))
    table.insert(0, ID_COLUMN, [int(name) if name.isdecimal() else name for name in ids])
    return table.reset_index(drop=True).reindex(columns=list(SUBMISSION_COLUMNS), fill_value=NO_ESTIMATE)


def check_submission(submission: pd.DataFrame, recordings: pd.Index, *, what: str = "submission") -> Checked:
    """What a submission, called ``what`` in messages, says about each of some recordings.

    Returns:
        A row per recording with the quantities of ``SCORED_COLUMNS``; NaN where there is no usable estimate.

    Raises:
        ArgumentError: it is no table, has no ids, none of the recordings, or its values are in the wrong columns.
    """
    _check_columns_are_in_place(submission, what)
    rows = rows_of(submission, recordings, id_column=ID_COLUMN, what=what)
    absent = recordings.difference(rows.table.index)
    notes = (f"{what}: there is no row for {listed(absent)}; counted as no estimate",) if len(absent) else ()
    numbers = numbers_of(rows.table, SCORED_COLUMNS, what=what)
    return Checked(numbers.table.reindex(recordings), (*rows.notes, *notes, *numbers.notes))


def _check_columns_are_in_place(submission: pd.DataFrame, what: str) -> None:
    """Refuse what ``pandas.read_csv`` makes of rows that end in a comma: all values stand one column further left."""
    if not isinstance(submission, pd.DataFrame) or not len(submission) or not len(submission.columns):
        return
    if ID_COLUMN not in submission or not submission.iloc[:, -1].isna().all():
        return
    ids = [recording_id(value) for value in submission[ID_COLUMN]]
    if None in ids or len(set(ids)) < len(ids) or _is_numbered(submission.index):
        last = submission.columns[-1]
        raise ArgumentError(
            f"{what} must have its values below their headings: {last!r}, its last column, is empty and its ids are "
            "its index, as where rows end in a comma; read the file with read_submission"
        )


def _is_numbered(index: pd.Index) -> bool:
    """Whether an index was made from a file's cells: it has no name, and is more than the rows' places."""
    return index.name is None and not isinstance(index, pd.RangeIndex) and not index.is_monotonic_increasing


def submission_csv(submission: pd.DataFrame) -> str:
    """The content of a submission file, from ``submission_table``.

    Raises:
        ArgumentError: a column is missing.
    """
    absent = [name for name in SUBMISSION_COLUMNS if name not in submission]
    if absent:
        raise ArgumentError(f"submission must have the columns {', '.join(SUBMISSION_COLUMNS)}; it lacks {absent[0]!r}")
    return submission[list(SUBMISSION_COLUMNS)].to_csv(index=False, float_format="%.10g", lineterminator="\n")


def write_submission(submission: pd.DataFrame, path: str | Path) -> None:
    """Write a submission file; an older one is replaced.

    Raises:
        ArgumentError: a column is missing.
        FileError: the file cannot be written.
    """
    content = submission_csv(submission)
    with writing(Path(path), advice="choose another folder") as part:
        part.write_bytes(content.encode())
