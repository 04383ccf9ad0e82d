"""The panel beside what was clicked: the recordings behind a number, or one recording with all its numbers."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.evaluation import recordings_behind
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.quantities import QUANTITIES, Quantity
from corsmal.ui import media, shared
from corsmal.ui.amounts import percent_error
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.links import STAGE_PAGES, behind_table, clicked_row, open_recording
from corsmal.ui.messages import plain
from corsmal.ui.overview.tiles import ICONS

_Row = dict[Any, Any]

FOCUS, HANDLED = "evaluation_focus", "evaluation_handled"


@dataclass(frozen=True)
class Focus:
    """What was clicked.

    Args:
        section: where it was clicked.
        title: what it is, for people.
        metric: a key of ``METRIC_NAMES``, or ``failures``.
        recordings: ids, in the order in which they are listed.
        is_one: whether it is a recording, and not a number with the recordings behind it.
    """

    section: str
    title: str
    metric: str
    recordings: tuple[str, ...]
    is_one: bool = False


def focus_container(errors: pd.DataFrame, *, section: str, metric: str, container: str | None) -> None:
    """Look at the recordings behind a metric of one container, or of all."""
    rows = errors if container is None else errors[errors["container"] == container]
    behind = recordings_behind(rows, metric)
    what = "Failures" if metric == "failures" else METRIC_NAMES[metric]
    title = f"{what}, {container or 'all containers'}"
    st.session_state[FOCUS] = Focus(section, title, metric, tuple(behind.index))


def focus_recording(recording: str, *, section: str, metric: str = "capacity_mape") -> None:
    """Look at one recording."""
    st.session_state[FOCUS] = Focus(section, f"Recording {recording}", metric, (recording,), is_one=True)


def newly_selected(key: str) -> tuple[int, str] | None:
    """The row and column of a table that were clicked since the last run; the column is empty for a ticked row.

    A selection lasts in the browser: what it opened once may be closed since.
    """
    selection = (st.session_state.get(key) or {}).get("selection", {})
    cells = [(int(row), str(column)) for row, column in selection.get("cells", ())]
    cells += [(int(row), "") for row in selection.get("rows", ())]
    handled: dict[str, list[tuple[int, str]]] = st.session_state.setdefault(HANDLED, {})
    if handled.get(key, []) == cells:
        return None
    handled[key] = cells
    return cells[0] if cells else None


@contextmanager
def beside_panel(judged: Judged, *, section: str) -> Iterator[None]:
    """Draw what is clicked on, and beside it a panel about what was clicked last, which stays in view.

    Args:
        judged: whose numbers they are.
        section: in which the click is.
    """
    place = st.container(key=f"beside_{section}")
    found: Focus | None = st.session_state.get(FOCUS)
    if found is None or found.section != section:
        with place:
            yield
        return
    left, right = place.columns([11, 9], gap="medium")
    with left:
        yield
    with right:
        title, close = st.columns([6, 1], vertical_alignment="center")
        title.subheader(_title(judged, found))
        close.button("", icon=":material/close:", help="Close", key="close_panel", type="tertiary", on_click=_close)
        (_recording if found.is_one else _recordings)(judged, found)


def _close() -> None:
    st.session_state.pop(FOCUS, None)


def _title(judged: Judged, found: Focus) -> str:
    count = len(_known(judged, found))
    return plain(found.title) + ("" if found.is_one else f": {count} recording{'' if count == 1 else 's'}")


def _known(judged: Judged, found: Focus) -> list[str]:
    errors = judged.errors()
    return [name for name in found.recordings if name in errors.index]


def _recordings(judged: Judged, found: Focus) -> None:
    """The recordings behind the number that was clicked; a click on one opens it."""
    ids, page = _known(judged, found), STAGE_PAGES[found.metric]
    if not ids:
        st.caption("None.")
        return
    where = "the page where it failed" if found.metric == "failures" else f"the *{page.capitalize()}* page"
    st.caption(f"The worst first. Click a row to open the recording on {where}, with this run's parameters.")
    shown = behind_table(judged, judged.errors().loc[ids], metric=found.metric)
    clicked_row(shown, run=judged.run, metric=found.metric, key=f"behind {found.section} {found.title}")


def _recording(judged: Judged, found: Focus) -> None:
    """One recording: its picture, all quantities beside the truth, and the pages that explain them."""
    known = _known(judged, found)
    if not known:
        st.caption("This run has no such recording.")
        return
    name = known[0]
    errors, estimate = _row(judged.errors(), name), _row(judged.run.table.set_index("recording_id"), name)
    left, right = st.columns([2, 3], vertical_alignment="center")
    with left, suppress(CorsmalError):
        st.image(media.thumbnail(judged.dataset[name], store=shared.store()), width="stretch")
    truth = _row(judged.dataset.table, name)
    filling = " ".join(str(value) for value in (truth["level"], truth["filling"]) if pd.notna(value))
    right.markdown(f"**{plain(str(errors['container']))}**, {plain(filling)}")
    right.caption(f"{plain(str(estimate['status']))}; frame {estimate['best_frame']}, {plain(str(estimate['pair']))}")
    rows = [_quantity_row(quantity, estimate, truth, errors) for quantity in QUANTITIES]
    st.dataframe(pd.DataFrame(rows), hide_index=True, key=f"recording panel {name}", placeholder="–")
    if estimate["notes"]:
        st.caption(f":material/info: {plain(str(estimate['notes']))}")
    st.caption("Open it with this run's parameters on the page of a stage:")
    for column, page in zip(st.columns(2) * 2, ("frames", "shape", "filling", "mass"), strict=True):
        metric = next(each for each, own in STAGE_PAGES.items() if own == page)
        if column.button(page.capitalize(), icon=ICONS[page], key=f"panel {page}", width="stretch"):
            open_recording(judged.run, name, metric=metric, page=page)


def _row(table: pd.DataFrame, name: str) -> _Row:
    return dict(table.loc[[name]].iloc[0])


def _quantity_row(quantity: Quantity, estimate: _Row, truth: _Row, errors: _Row) -> dict[str, Any]:
    found, true = estimate[quantity.name], truth[quantity.name]
    row: dict[str, Any] = {"Quantity": quantity.label}
    if quantity.is_class:
        names = dict(enumerate(CLASS_NAMES[quantity.name]))
        is_right = errors[f"{quantity.name}_correct"]
        row |= {"Estimate": names.get(found) if pd.notna(found) else None, "Truth": names.get(true)}
        return row | {"Error": None if pd.isna(is_right) else "right" if is_right else "wrong"}
    error = errors[quantity.error_column]
    low, high = (estimate.get(f"{quantity.name}_{end}") for end in ("low", "high"))
    row |= {"Estimate": None if pd.isna(found) else quantity.text(float(found))}
    row |= {"Truth": None if pd.isna(true) else quantity.text(float(true))}
    row |= {"Error": None if pd.isna(error) else percent_error(float(found), float(true))}
    return row | {"90 % interval": None if pd.isna(low) or pd.isna(high) else f"{low:,.0f}–{high:,.0f}"}
