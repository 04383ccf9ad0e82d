"""Tables of recordings, and the way from a recording to the page of the stage that a number came from."""

from typing import Any

import pandas as pd
import streamlit as st

from corsmal.estimation.records import FITTED
from corsmal.evaluation import METRICS
from corsmal.evaluation.metrics import CLASS_NAMES
from corsmal.parameters import SELECTION_PRESETS, own_selection
from corsmal.quantities import BY_METRIC, QUANTITIES
from corsmal.runs.run import Run
from corsmal.ui import session
from corsmal.ui.choice import OF_RECORDING, Choice, estimate_of
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged

STAGE_PAGES = {quantity.metric: quantity.stage for quantity in QUANTITIES} | {"failures": "frames"}
"""The page of the stage that a number comes from."""

COLUMNS = {
    "error": st.column_config.NumberColumn(format="%+.1f %%"),
    "estimated": st.column_config.NumberColumn(format="%.1f"),
    "annotated": st.column_config.NumberColumn(format="%.1f"),
    "notes": st.column_config.TextColumn(width="large"),
}


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


def open_recording(run: Run, recording: str, *, metric: str, page: str | None = None) -> None:
    """Go to a page, by default that of a metric's stage, with the run's parameters, frame and pair."""
    row = next((row for row in run.rows if row["recording_id"] == recording), {})
    pair = tuple(str(row.get("pair") or "").split(" + "))
    shape, matching = run.settings.shape, run.settings.matching
    session.open_page(
        page or (STAGE_PAGES[metric] if metric != "failures" else _failed_stage(row)),
        recording=recording,
        shape=shape,
        estimate=estimate_of(shape),
        selection=_selection_name(run),
        **OF_RECORDING
        | {
            "frame": row.get("best_frame"),
            "pair": pair if len(pair) == 2 else None,
            "match": None if matching.by == "time" else matching.by,
            "offsets_s": matching.offsets_s,
            "masks": None if run.settings.masks == "detected" else run.settings.masks,
        },
    )


def _selection_name(run: Run) -> str | None:
    """The preset of a run's selection where an address has to say it."""
    own = own_selection(Choice(shape=run.settings.shape).preset)
    name = next((name for name, each in SELECTION_PRESETS.items() if each == run.settings.selection), own)
    return None if name == own else name


def _failed_stage(row: dict[str, Any] | Any) -> str:
    """The page that explains a failed recording: where its first missing number should have come from."""
    if row.get("status") not in FITTED:
        return "frames"
    return "filling" if row.get("filling_type") is None else "mass"
