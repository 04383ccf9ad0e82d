"""The error of capacity and dimensions over a grid of L and d_max."""

from dataclasses import replace

import pandas as pd
import streamlit as st

from corsmal.dataset import Dataset
from corsmal.evaluation import sweep_table
from corsmal.evaluation.sweep import MEASURED
from corsmal.figures.heatmaps import sweep_figure
from corsmal.runs.run import Run
from corsmal.runs.sweep import SETTINGS, Grid, load_sweep, sweep_run
from corsmal.ui import session, shared
from corsmal.ui.evaluation.downloads import downloads
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.jobs import Job, Priority
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.one_of import one_of

CIRCUMFERENCES = (40, 70, 100, 145, 180, 220, 260, 320, 400, 500)
MAX_DIFFERENCES_MM = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0)
RECORDINGS_MAX = 30


def sweep_section(judged: Judged) -> None:
    """A heat map of errors over settings; a click on a cell takes the setting to the Shape page."""
    run, dataset, ids = judged.run, judged.dataset, _chosen_ids(judged)
    left, right = st.columns(2)
    counts = left.multiselect("L, circumferences", CIRCUMFERENCES, CIRCUMFERENCES, key="sweep_circumferences")
    steps_mm = right.multiselect("d_max (mm)", MAX_DIFFERENCES_MM, MAX_DIFFERENCES_MM, key="sweep_max_differences")
    key = f"sweep {run.key}"
    if follow(key):
        return
    if not (ids and len(counts) > 1 and len(steps_mm) > 1):
        st.caption("Choose at least one recording and two values of each parameter.")
        return
    grid = Grid(tuple(ids), tuple(sorted(counts)), tuple(sorted(steps_mm)))
    rows = load_sweep(run, grid, store=shared.store())
    if rows is not None:
        _heat_map(pd.DataFrame(rows), dataset, run)
        return
    if is_read_only():
        st.caption(f":material/lock: These settings were not swept. {READ_ONLY}")
        return
    label = f"Sweep {len(counts) * len(steps_mm)} settings over {len(ids)} recordings"
    if st.button(label, type="primary", icon=":material/grid_on:", key="start_sweep"):
        store = shared.store()

        def work(job: Job) -> None:
            sweep_run(run, dataset, grid, store=store, progress=job.advance, cancelled=job.cancelled)

        shared.jobs().start(key, "Sweeping", work, priority=Priority.SHOWN)
        st.rerun()


def _chosen_ids(judged: Judged) -> list[str]:
    errors = judged.errors()
    is_measured = errors["status"].str.startswith("fitted") & errors["capacity_error_percent"].notna()
    measured = [str(name) for name in errors.index[is_measured]]
    if not measured:
        st.info(
            "No recording of this run was fitted and has an annotation: there is nothing to sweep over. Find "
            "containers first (*New run*, above).",
            icon=":material/grid_off:",
        )
    return st.multiselect(
        "Recordings",
        measured,
        measured[:: -(-len(measured) // RECORDINGS_MAX)] if measured else [],
        key=f"sweep_recordings {judged.run.name}",
        help=f"At first up to {RECORDINGS_MAX} of those that were fitted, spread over the run.",
    )


def _heat_map(rows: pd.DataFrame, dataset: Dataset, run: Run) -> None:
    table = sweep_table(rows, dataset.table, settings=SETTINGS)
    table["mean_mape"] = table[list(MEASURED.values())].mean(axis=1)
    names = {"mean_mape": "Mean of the four"} | {metric: METRIC_NAMES[metric] for metric in MEASURED.values()}
    metric = one_of("Error of", names, key="sweep_metric", field="metric")
    click = plot_event("sweep").click
    if click is not None and isinstance(click.customdata, list) and len(click.customdata) == len(SETTINGS) + 2:
        count, step_mm = click.customdata[:2]
        session.choose(shape=replace(run.settings.shape, circumferences=int(count), max_difference_mm=float(step_mm)))
        st.switch_page("pages/shape.py")
    shape = session.choice().shape
    linked_plot(
        sweep_figure(
            table, metric=metric, label=names[metric], current=(shape.circumferences, shape.max_difference_mm)
        ),
        key="sweep",
        label=f"Error of {names[metric]} over L and d_max",
        height_px=460,
        revision=metric,
    )
    st.caption(
        f"MAPE in % over {rows['recording_id'].nunique()} recordings; those that cannot be measured with a setting are "
        "in no mean, hover to see how many. Click a cell to take its setting to the *Shape* page."
    )
    if run.settings.shape.width_rule == "widest":
        st.caption(":material/info: This run takes twice the largest radius for a width: d_max has no part in it.")
    downloads(table, name="sweep")
