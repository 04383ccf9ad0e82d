"""The error of capacity and dimensions over a grid of two parameters that the run's fit depends on."""

from typing import Any

import streamlit as st

from corsmal.engines.local import local_engine
from corsmal.evaluation.bootstrap import RESAMPLES
from corsmal.evaluation.sweep import MEAN, MEASURED
from corsmal.figures.heatmaps import sweep_figure
from corsmal.runs.run import Run
from corsmal.runs.sweep import OFFERED, Axis, Grid, load_sweep, run_grid, sweep_run, with_setting
from corsmal.ui import session, shared
from corsmal.ui.evaluation.downloads import downloads
from corsmal.ui.evaluation.judged import METRIC_NAMES, Judged
from corsmal.ui.evaluation.parameter_names import parameter_label
from corsmal.ui.folders import READ_ONLY, is_read_only
from corsmal.ui.following import follow
from corsmal.ui.job import Job, Priority
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.one_of import one_of

RECORDINGS_MAX = 30


def sweep_section(judged: Judged) -> None:
    """A heat map of errors over settings; a click on a cell takes the setting to the Shape page."""
    run, dataset = judged.run, judged.dataset
    if not run.is_complete:
        st.info("This run is incomplete. A sweep can be made once all recordings are estimated.")
        return
    ids = _chosen_ids(judged)
    axes = _axes(run)
    key = f"sweep {run.key}"
    if follow(key):
        return
    if not ids or any(len(axis.values) < 2 for axis in axes):
        st.caption("Choose at least one recording and two values of each parameter.")
        return
    grid = run_grid(run, ids, *axes)
    rows = load_sweep(run, grid, store=shared.store())
    if rows is not None:
        _heat_map(rows, judged, grid)
        return
    if is_read_only():
        st.caption(f":material/lock: These settings were not swept. {READ_ONLY}")
        return
    label = f"Sweep {len(grid.settings)} settings over {len(ids)} recordings"
    if st.button(label, type="primary", icon=":material/grid_on:", key="start_sweep"):
        store = shared.store()

        def work(job: Job) -> None:
            sweep_run(
                run,
                dataset,
                grid,
                store=store,
                engine=local_engine(len(ids), gives_way=True),
                progress=job.advance,
                cancelled=job.cancelled,
            )

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
        key=f"sweep_recordings {judged.run.id}",
        help=f"At first up to {RECORDINGS_MAX} of those that were fitted, spread over the run.",
    )


def _axes(run: Run) -> tuple[Axis, Axis]:
    """Two parameters of those that the run's fit depends on, and their values."""
    varied, preset = run.settings.shape.varied, run.preset
    columns = st.columns(2)
    axes: list[Axis] = []
    for column, what in zip(columns, ("across", "down"), strict=True):
        names = {name: parameter_label(name) for name in varied if name not in {axis.name for axis in axes}}
        with column:
            name = one_of(f"Parameter {what}", names, key=f"sweep_{what} {preset}")
            values = sorted({*OFFERED[name], getattr(run.settings.shape, name)})
            chosen = st.multiselect("Values", values, values, format_func="{:g}".format, key=f"sweep_{name} {preset}")
        axes.append(Axis(name, tuple(sorted(chosen))))
    st.caption(
        f"The parameters that `{preset}` uses; the others would change nothing. Its own values are always tried."
    )
    return axes[0], axes[1]


def _heat_map(rows: list[dict[str, Any]], judged: Judged, grid: Grid) -> None:
    run, axes = judged.run, (grid.across.name, grid.down.name)
    own = {name: getattr(run.settings.shape, name) for name in axes}
    table = judged.swept(grid, rows)
    names = {MEAN: "Mean of the four"} | {metric: METRIC_NAMES[metric] for metric in MEASURED.values()}
    metric = one_of("Error of", names, key="sweep_metric", field="metric")
    click = plot_event("sweep").click
    if click is not None and isinstance(click.customdata, list) and len(click.customdata) > len(axes):
        setting = dict(zip(axes, map(float, click.customdata[:2]), strict=True))
        session.open_page("shape", shape=with_setting(run.settings.shape, setting))
    labels = (parameter_label(axes[0]), parameter_label(axes[1]), names[metric])
    linked_plot(
        sweep_figure(table, metric=metric, axes=axes, labels=labels, current=(own[axes[0]], own[axes[1]])),
        key="sweep",
        label=f"Error of {names[metric]} over {labels[0]} and {labels[1]}",
        height_px=130 + 34 * len(grid.down.values),
        revision=f"{metric} {axes}",
    )
    st.caption(
        f"MAPE in % over {len(grid.recordings)} recordings. A cell is coloured where it differs from the "
        "run's own setting by more than noise, green where it is better: the 95 % interval of the difference excludes "
        f"0. The interval is that of a paired bootstrap over recordings ({RESAMPLES} draws of those that both settings "
        "measure); one cell in twenty may be coloured by chance. Recordings that cannot be measured with a setting are "
        "in no mean; rest the mouse on a cell to see how many. Click it to take its setting to the *Shape* page."
    )
    downloads(table.drop(columns=[name for name in table if str(name).endswith(("_low", "_high"))]), name="sweep")
