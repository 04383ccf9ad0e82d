"""From a number to the recordings behind it, and from a recording to the page of the stage that it came from."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pandas as pd
import streamlit as st

from corsmal.evaluation import METRICS, recordings_behind
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.parameters import PAIRS
from corsmal.quantities import BY_METRIC, QUANTITIES
from corsmal.runs.run import Run
from corsmal.ui import session
from corsmal.ui.choice import OF_RECORDING, estimate_of
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.messages import plain

FOCUS = "evaluation_focus"
STAGE_PAGES = {quantity.metric: quantity.stage for quantity in QUANTITIES} | {"failures": "frames"}
"""The page of the stage that a number comes from."""

COLUMNS = {
    "error": st.column_config.NumberColumn(format="%+.1f %%"),
    "estimated": st.column_config.NumberColumn(format="%.1f"),
    "annotated": st.column_config.NumberColumn(format="%.1f"),
    "notes": st.column_config.TextColumn(width="large"),
}


@dataclass(frozen=True)
class Focus:
    """The number that was clicked, and what it is made from.

    Args:
        section: where it was clicked.
        title: what it is, for people.
        metric: a key of ``METRIC_NAMES``, or ``failures``.
        recordings: ids, in the order in which they are listed.
    """

    section: str
    title: str
    metric: str
    recordings: tuple[str, ...]


def focus_container(errors: pd.DataFrame, *, section: str, metric: str, container: str | None) -> None:
    """Look at the recordings behind a metric of one container, or of all."""
    rows = errors if container is None else errors[errors["container"] == container]
    behind = recordings_behind(rows, metric)
    what = "Failures" if metric == "failures" else METRIC_NAMES[metric]
    title = f"{what}, {container or 'all containers'}"
    st.session_state[FOCUS] = Focus(section, title, metric, tuple(behind.index))


@contextmanager
def beside_list(judged: Judged, *, section: str) -> Iterator[None]:
    """Draw what is clicked on, and beside it, on a narrow page below it, the recordings behind the number clicked.

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
        _recordings_list(judged, found)


def _recordings_list(judged: Judged, found: Focus) -> None:
    """The recordings behind the number that was clicked; a click on one opens it."""
    errors = judged.errors()
    ids = [name for name in found.recordings if name in errors.index]
    page = STAGE_PAGES[found.metric]
    st.subheader(f"{plain(found.title)}: {len(ids)} recording{'' if len(ids) == 1 else 's'}")
    if not ids:
        st.caption("None.")
        return
    where = "the page where it failed" if found.metric == "failures" else f"the *{page.capitalize()}* page"
    st.caption(f"The worst first. Click a row to open the recording on {where}, with this run's parameters.")
    shown = behind_table(judged, errors.loc[ids], metric=found.metric)
    clicked_row(shown, run=judged.run, metric=found.metric, key=f"behind {found.section} {found.title}")


def clicked_row(table: pd.DataFrame, *, run: Run, metric: str | list[str], key: str, height: int | None = None) -> None:
    """A table of recordings whose rows open them.

    Args:
        table: indexed by recording id, or with a column ``recording_id``. A column with the name of a metric opens its
            own stage.
        run: whose numbers they are.
        metric: what the other columns are about, or a metric for each row.
        key: names the table.
        height: px; default: as high as the table, up to about ten rows.
    """
    ids = list(table.get("recording_id", table.index))
    event: Any = st.dataframe(
        table,
        key=key,
        on_select="rerun",
        selection_mode=["single-row", "single-cell"],
        height=height or min(400, 38 + 35 * max(1, len(table))),
        column_config=COLUMNS,
        placeholder="–",
        hide_index="recording_id" in table,
    )
    cells = [*event.selection.cells, *((row, "") for row in event.selection.rows)]
    if cells and cells[0][0] < len(ids):
        row, column = cells[0]
        own = {name: each for each, name in METRIC_NAMES.items()}.get(column)
        open_recording(run, ids[row], metric=own or (metric if isinstance(metric, str) else metric[row]))


def behind_table(judged: Judged, errors: pd.DataFrame, *, metric: str) -> pd.DataFrame:
    """What a metric is made from, recording by recording."""
    estimates = judged.run.table.set_index("recording_id").loc[errors.index]
    truth = judged.dataset.table.loc[errors.index]
    columns: dict[str, Any] = {"container": errors["container"]}
    quantity = BY_METRIC.get(metric)
    name = "" if quantity is None else quantity.name
    if name in CLASS_NAMES:
        names = dict(enumerate(CLASS_NAMES[name]))
        columns["predicted"] = estimates[name].map(names).astype("object").fillna("no estimate")
        columns["truth"] = truth[name].map(names)
        columns["right"] = errors[f"{name}_correct"]
    elif quantity is not None:
        columns["error"] = errors[METRICS[metric]]
        columns |= {"estimated": estimates[name], "annotated": truth[name], "unit": quantity.unit}
    else:
        columns["status"] = errors["status"]
    columns["filling"] = truth["level"].fillna("") + " " + truth["filling"].fillna("")
    if name not in CLASS_NAMES:
        columns["status"] = errors["status"]
        columns |= {"frame": errors["best_frame"], "pair": errors["pair"]}
    return pd.DataFrame(columns | {"notes": errors["notes"]}, index=errors.index.rename("recording"))


def open_recording(run: Run, recording: str, *, metric: str) -> None:
    """Go to the page of the stage that a number comes from, with the run's parameters, frame and pair."""
    row = next((row for row in run.rows if row["recording_id"] == recording), {})
    pair = tuple(str(row.get("pair") or "").split(" + "))
    shape = run.settings.shape
    session.choose(
        recording=recording,
        shape=shape,
        estimate=estimate_of(shape),
        **OF_RECORDING | {"frame": row.get("best_frame"), "pair": pair if pair in PAIRS else None},
    )
    page = STAGE_PAGES[metric] if metric != "failures" else _failed_stage(row)
    st.switch_page(f"pages/{page}.py")


def _failed_stage(row: dict[str, Any] | Any) -> str:
    """The page that explains a failed recording: where its first missing number should have come from."""
    if row.get("status") not in ("fitted", "fitted, second pair"):
        return "frames"
    return "filling" if row.get("filling_type") is None else "mass"
