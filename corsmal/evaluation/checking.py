"""Tables from files and people, taken as far as they are usable, with sentences on the rest."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.dataset.annotation import CONTAINERS
from corsmal.dataset.headings import heading_key
from corsmal.dataset.ids import listed, recording_id
from corsmal.errors import ArgumentError
from corsmal.evaluation.foreign import ASSUMED
from corsmal.evaluation.metrics import CLASS_NAMES, NO_ESTIMATE
from corsmal.quantities import MEASURED, QUANTITIES

_TRUTHS = (*MEASURED, *CLASS_NAMES, "filling_density_g_per_ml", "filling_mass_g")
_FILE_COLUMNS = {
    heading_key(shown): name
    for shown, name in (
        ("container id", "container_id"),
        *((quantity.submission_column, quantity.name) for quantity in QUANTITIES),
        ("filling density", "filling_density_g_per_ml"),
        ("filling mass", "filling_mass_g"),
    )
}
"""The annotation file's names of what a dataset's table has too."""


@dataclass(frozen=True, eq=False)
class Checked:
    """A table made usable.

    Args:
        table: indexed by recording id; numbers are float, NaN where there is none.
        notes: sentences on what was missing or left out.
    """

    table: pd.DataFrame
    notes: tuple[str, ...] = ()


def truth_table(annotation: pd.DataFrame) -> pd.DataFrame:
    """What an annotation knows, whichever of its two forms it comes in.

    Args:
        annotation: a dataset's table (``Dataset.table``), or the columns of the annotation file as ``pandas.read_csv``
            returns them. Columns may be missing: test sets come without truth.

    Returns:
        Indexed by ``recording_id``: ``container_id`` (NA where unknown), ``container``, ``kind`` (text, empty where
        unknown), and as float with NaN where unknown the quantities of ``Annotation`` from ``capacity_ml`` to
        ``filling_mass_g``.

    Raises:
        ArgumentError: it is no table, has no rows, no ids, or an id twice.
    """
    if not isinstance(annotation, pd.DataFrame):
        raise ArgumentError(f"annotation must be a pandas DataFrame, got {type(annotation).__name__}")
    ids = [recording_id(value) for value in _id_values(annotation, ("recording_id", "id"), "annotation")]
    if not ids:
        raise ArgumentError("annotation has no rows")
    if None in ids or len(set(ids)) < len(ids):
        wrong = next(name for place, name in enumerate(ids) if name is None or name in ids[:place])
        raise ArgumentError(f"annotation must have one row per recording id, got {wrong or 'a row without an id'}")
    given = annotation.rename(columns=lambda name: _FILE_COLUMNS.get(heading_key(name), name))
    index = pd.Index(ids, name="recording_id", dtype="str")
    numbers = _numbers(given["container_id"]) if "container_id" in given else np.full(len(index), np.nan)
    is_number = np.isfinite(numbers) & (numbers == np.floor(numbers))
    container_ids = pd.array(np.where(is_number, numbers, np.nan), dtype="Int64")
    table = pd.DataFrame({"container_id": container_ids}, index=index)
    for place, name in enumerate(("container", "kind")):
        known = [CONTAINERS.get(number, ("", ""))[place] for number in container_ids]
        named = given[name].astype("string").fillna("").to_list() if name in given else known
        table[name] = [text or default for text, default in zip(named, known, strict=True)]
    for name in _TRUTHS:
        found = _numbers(given[name]) if name in given else np.full(len(index), np.nan)
        table[name] = np.where(_is_usable(found, name) & ((found > 0) | (name not in MEASURED)), found, np.nan)
    return table


def rows_of(table: pd.DataFrame, recordings: pd.Index, *, id_column: str, what: str) -> Checked:
    """The rows of a table that belong to wanted recordings, one each, indexed by recording id, columns as they are.

    Args:
        table: has ``id_column`` as a column or as its index; 618 and "618" mean "000618".
        recordings: the ids that are wanted.
        id_column: name of the column with the recordings' ids.
        what: what messages call the table.

    Raises:
        ArgumentError: it is no table, has no ids, or none of the wanted recordings.
    """
    if not isinstance(table, pd.DataFrame):
        raise ArgumentError(f"{what} must be a pandas DataFrame, got {type(table).__name__}")
    ids = pd.Series([recording_id(value) for value in _id_values(table, (id_column,), what)], dtype="object")
    is_unusable, is_foreign = ids.isna(), ids.notna() & ~ids.isin(recordings)
    is_repeated = ids.duplicated() & ~is_unusable
    notes = list(table.attrs.get(ASSUMED, ()))
    if is_unusable.any():
        notes.append(f"{what}: {is_unusable.sum()} of {len(ids)} rows have no usable {id_column!r} and were left out")
    if is_repeated.any():
        notes.append(f"{what}: {listed(ids[is_repeated].unique())} appears more than once; the first row was taken")
    if is_foreign.any():
        notes.append(f"{what}: the annotation does not have {listed(ids[is_foreign].unique())}; left out")
    keep = ~(is_unusable | is_repeated | is_foreign).to_numpy()
    if not keep.any():
        raise ArgumentError(f"{what}: no row is of a recording of the annotation, which has {listed(recordings)}")
    return Checked(table[keep].set_axis(pd.Index(ids[keep], name="recording_id", dtype="str")), tuple(notes))


def numbers_of(rows: pd.DataFrame, columns: Mapping[str, str], *, what: str) -> Checked:
    """Quantities and classes as numbers.

    Args:
        rows: indexed by recording id.
        columns: the wanted columns, and what they are to be called.
        what: what messages call the table.

    Returns:
        Float; NaN where there is no such column, or something that is no estimate: −1, nothing, text, a negative or
        infinite number, a class number that there is not.
    """
    found, notes = {}, []
    for shown, name in columns.items():
        found[name], note = _column(rows, shown, name)
        notes += [f"{what}: {note}"] if note else []
    return Checked(pd.DataFrame(found, index=rows.index), tuple(notes))


def _id_values(table: pd.DataFrame, names: Iterable[str], what: str) -> list[Any]:
    for name in names:
        same = [column for column in table.columns if heading_key(column) == heading_key(name)]
        if same:
            return table[same[0]].to_list()
        if heading_key(table.index.name) == heading_key(name):
            return table.index.to_list()
    columns = ", ".join(map(str, table.columns[:8]))
    raise ArgumentError(f"{what} must have a column {next(iter(names))!r}, got {columns or 'no columns'}")


def _column(table: pd.DataFrame, shown: str, name: str) -> tuple[NDArray[np.float64], str]:
    """One column's numbers, and what is to be said about them."""
    if shown not in table:
        return np.full(len(table), np.nan), f"there is no column {shown!r}; counted as no estimate"
    found = _numbers(table[shown])
    is_usable = _is_usable(found, name)
    is_odd = ~is_usable & (found != NO_ESTIMATE) & table[shown].notna().to_numpy()
    note = f"{shown!r} is unusable for {listed(table.index[is_odd])}; counted as no estimate" if is_odd.any() else ""
    return np.where(is_usable, found, np.nan), note


def _numbers(column: pd.Series) -> NDArray[np.float64]:
    if column.dtype == "object":  # whole numbers of any length may stand there, which pandas refuses
        column = column.map(lambda value: np.inf if isinstance(value, int) and abs(value) > 2**63 else value)
    found: NDArray[np.float64] = pd.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    return found


def _is_usable(found: NDArray[np.float64], name: str) -> NDArray[np.bool_]:
    is_usable: NDArray[np.bool_] = np.isfinite(found) & (found >= 0)
    if name in CLASS_NAMES:
        is_usable &= np.isin(found, range(len(CLASS_NAMES[name])))
    return is_usable
