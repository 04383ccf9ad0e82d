"""All runs on a dataset as people keep them: sorted, renamed, archived, deleted and brought back, compared."""

from typing import Any

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.errors import CorsmalError
from corsmal.evaluation import METRICS
from corsmal.evaluation.typesetting import TITLES
from corsmal.runs.keeping import NOTE_MAX, label_run
from corsmal.runs.names import NAME_MAX
from corsmal.runs.run import Run
from corsmal.ui import shared
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged, averages, deleted, has_truth, runs
from corsmal.ui.evaluation.new_run import job_key
from corsmal.ui.evaluation.overlay import compare_parameters, overlay
from corsmal.ui.evaluation.runs import delete, restore, show_run, undo_control
from corsmal.ui.evaluation.sections import flags_control, protocol_control
from corsmal.ui.evaluation.tables import SHORT
from corsmal.ui.folders import check_may_change, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.messages import plain, show_problem

ROW_PX, HEAD_PX = 35, 38


def all_runs(dataset: Dataset) -> None:
    """The table of runs, and what can be done with those that are ticked."""
    found, key = runs(dataset), job_key(dataset)
    undo_control(dataset)
    follow(key)
    left, middle, right = st.columns([3, 3, 1.4], vertical_alignment="bottom")
    with left:
        protocol = protocol_control()
    with middle:
        without = flags_control([run.table for run in found])
    archived = sum(run.is_archived for run in found)
    is_all = bool(archived) and right.toggle(f"Archived too ({archived})", key="runs_archived")
    shown = [run for run in found if is_all or not run.is_archived]
    if shown:
        judged = [Judged(run, dataset, protocol, without) for run in shown]
        _table(judged, running=shared.jobs().is_active(key))
    else:
        st.info(
            "There is no run on this dataset yet: make one under *Results*."
            if not found
            else "All runs are in the archive.",
            icon=":material/play_circle:",
        )
    _deleted(dataset)


def _table(judged: list[Judged], *, running: bool) -> None:
    shown, first = [each.run for each in judged], judged[0]
    key = f"all_runs {first.protocol} {first.without} {[run.id for run in shown]}"
    chosen = [judged[row] for row in _ticked(key) if row < len(judged)]
    place = st.container(key="beside_runs")
    left, right = place.columns([11, 5], gap="medium") if len(chosen) == 1 else (place, None)
    with left:
        _runs_table(judged, key=key, running=running)
        st.caption(
            "MPF1 of level and type (↑), MAPE of the others (↓), averages over containers in %. Click a heading to "
            "sort. Tick a run to rename it, to write a note, to archive or delete it; tick several to compare them."
        )
    if right is not None:
        with right:
            _one(chosen[0].run, running=running)
    if len(chosen) > 1:
        _several(chosen, running=running)


def _ticked(key: str) -> list[int]:
    selection = (st.session_state.get(key) or {}).get("selection", {})
    return sorted(int(row) for row in selection.get("rows", ()))


def _runs_table(judged: list[Judged], *, key: str, running: bool) -> None:
    has_numbers = has_truth(judged[0].dataset)
    rows = [_row(each, has_numbers=has_numbers, running=running) for each in judged]
    widths: dict[str, Any] = {
        "name": st.column_config.TextColumn("Name", pinned=True, width=100),
        "note": st.column_config.TextColumn("Note", width=90),
        "preset": st.column_config.TextColumn("Preset", width=62),
        "recordings": st.column_config.TextColumn("Recordings", width=84),
        "protocol": st.column_config.TextColumn("Protocol", width=68),
        "failed": st.column_config.NumberColumn("Failed", width=48),
        "created": st.column_config.DatetimeColumn("Made (UTC)", format="YYYY-MM-DD HH:mm", width=122),
        "archived": st.column_config.CheckboxColumn("Archived", width=64),
    }
    for metric in METRICS:
        label = SHORT.get(metric, METRIC_NAMES[metric])
        kind = "MAPE, the lower the better" if metric.endswith("_mape") else "MPF1, the higher the better"
        width = 44 + 4 * len(label)
        helped = f"{METRIC_NAMES[metric]}: {kind}"
        widths[metric] = st.column_config.NumberColumn(label, format="%.1f", width=width, help=helped)
    shown = pd.DataFrame(rows)
    if not shown["archived"].any():
        shown = shown.drop(columns="archived")
    st.dataframe(
        shown,
        key=key,
        on_select="rerun",
        selection_mode="multi-row",
        hide_index=True,
        height=HEAD_PX + ROW_PX * min(12, len(rows)),
        column_config=widths,
        placeholder="–",
    )


def _row(judged: Judged, *, has_numbers: bool, running: bool) -> dict[str, Any]:
    run = judged.run
    count = f"{len(run.rows)} of {len(run.recordings)}"
    state = "" if run.is_complete else " (running)" if running else " (partial)"
    row: dict[str, Any] = {"name": run.name, "note": run.note, "preset": run.preset, "recordings": count + state}
    row["protocol"] = TITLES[judged.protocol]
    numbers = None
    if has_numbers and run.rows:
        try:
            numbers = averages(judged)
        except CorsmalError:  # it has no recording in common with the annotation
            numbers = None
    row |= {metric: None if numbers is None else numbers[metric] for metric in METRICS}
    row |= {
        "failed": None if numbers is None else numbers["failures"],
        "created": pd.to_datetime(run.created, utc=True, errors="coerce").tz_localize(None),
    }
    return row | {"archived": run.is_archived}


def _one(run: Run, *, running: bool) -> None:
    """Name, note, archive and deletion of the run that is ticked."""
    if not is_read_only():
        _label_form(run)
    st.button(
        "Show its results",
        icon=":material/monitoring:",
        on_click=show_run,
        args=(run,),
        width="stretch",
        key="show_run",
    )
    _archive_and_delete([run], running=running)


def _label_form(run: Run) -> None:
    with st.form(f"label {run.id} {run.name}", border=True):
        name = st.text_input("Name", run.name, max_chars=NAME_MAX, key=f"label_name {run.id}")
        note = st.text_area("Note", run.note, max_chars=NOTE_MAX, height=100, key=f"label_note {run.id}")
        if st.form_submit_button("Save", icon=":material/save:", type="primary", width="stretch"):
            _label(run, name=name, note=note)


def _several(chosen: list[Judged], *, running: bool) -> None:
    compare_parameters([each.run for each in chosen])
    overlay([each for each in chosen if each.run.rows])
    _archive_and_delete([each.run for each in chosen], running=running)


def _archive_and_delete(chosen: list[Run], *, running: bool) -> None:
    if is_read_only():
        return
    left, right = st.columns(2)
    is_archived = all(run.is_archived for run in chosen)
    left.button(
        "Out of the archive" if is_archived else "Archive",
        icon=":material/unarchive:" if is_archived else ":material/archive:",
        on_click=_archive,
        args=(chosen,),
        kwargs={"is_archived": not is_archived},
        width="stretch",
        key="archive_runs",
        help="Archived runs are listed only on request.",
    )
    right.button(
        "Delete",
        icon=":material/delete:",
        on_click=delete,
        args=(chosen,),
        disabled=running and not all(run.is_complete for run in chosen),
        width="stretch",
        key="delete_runs",
        help="Can be undone for 30 days. A run that is being made must be stopped first.",
    )


def _archive(chosen: list[Run], *, is_archived: bool) -> None:
    for run in chosen:
        _label(run, is_archived=is_archived)


def _label(run: Run, **changes: Any) -> None:
    try:
        check_may_change()
        label_run(run, store=shared.store(), **changes)
    except CorsmalError as error:
        show_problem(error)
    else:
        st.rerun() if "name" in changes else None


def _deleted(dataset: Dataset) -> None:
    """The runs that can be brought back."""
    gone = deleted(dataset)
    if not gone or is_read_only():
        return
    with st.expander(f"Deleted runs ({len(gone)})", icon=":material/delete:"):
        for each in gone:
            left, right = st.columns([5, 1.4], vertical_alignment="center")
            left.markdown(
                f"**{plain(each.run.name)}** · {len(each.run.rows)} recordings · {each.run.created[:10]} · "
                f"removed for good on {each.until:%Y-%m-%d}"
            )
            right.button(
                "Restore",
                icon=":material/restore_from_trash:",
                on_click=restore,
                args=([each.run],),
                key=f"restore {each.run.id}",
                width="stretch",
            )
