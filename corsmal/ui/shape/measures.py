"""What was measured of a container, beside the truth, and its downloads."""

from collections.abc import Callable, Mapping
from functools import partial

import streamlit as st

from corsmal.dataset import Recording
from corsmal.estimation import Estimate, Fit
from corsmal.quantities import BY_NAME, DIMENSIONS, GEOMETRY
from corsmal.shape import MESH_FORMATS, export_mesh, profile_table
from corsmal.ui.amounts import amount, measure, percent_error
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.messages import plain


def annotated(recording: Recording) -> dict[str, float]:
    """The annotated capacity (mL), widths and height (mm) of a recording, as far as they are known."""
    values = {name: getattr(recording.annotation, name, None) for name in GEOMETRY}
    return {name: value for name, value in values.items() if value is not None}


def annotated_profile_mm(truth: Mapping[str, float]) -> tuple[float, float, float] | None:
    """Annotated bottom width, top width and height, mm; None unless all are known."""
    if not truth.keys() >= set(DIMENSIONS):
        return None
    return truth["width_bottom_mm"], truth["width_top_mm"], truth["height_mm"]


def measures(
    fit: Fit, *, truth: Mapping[str, float], is_inspected: bool = True, beside: tuple[str, Fit] | None = None
) -> None:
    """The four quantities of a fit, each with its error against the annotation, and those of another fit under them.

    Args:
        fit: the fit.
        truth: from ``annotated``.
        is_inspected: whether a detector has inspected the frame in both views.
        beside: another fit and its name.
    """
    if not is_inspected:
        st.info(
            plain(f"No detections of {' + '.join(fit.pair)} in frame {fit.frame} yet: there is nothing to fit.")
            + " Inspect the frame, or choose an inspected one.",
            icon=":material/search:",
        )
        return
    if not fit.ok:
        st.error(
            plain(f"The fit of {' + '.join(fit.pair)} in frame {fit.frame} failed: {fit.dimensions.reason}.")
            + " Try another frame or the other pair.",
            icon=":material/error:",
        )
        return
    for column, name in zip(st.columns(4), GEOMETRY, strict=True):
        value, true = getattr(fit.dimensions, name), truth.get(name)
        note = f"{percent_error(value, true)} of {BY_NAME[name].text(true)}" if true else "no annotation"
        measure(column, BY_NAME[name].label, amount(name, value), note)
        if beside is not None and beside[1].ok:
            value = getattr(beside[1].dimensions, name)
            note = f", {percent_error(value, true)}" if true else ""
            column.caption(plain(f"{beside[0]}: {amount(name, value)}{note}"))
    if fit.hull.depth_mm is not None:
        depth = amount("height_mm", fit.hull.depth_mm)
        st.caption(f"A box: the silhouettes agree better with one than with a round container; {depth} deep.")
    if beside is not None and not beside[1].ok:
        st.caption(plain(f"{beside[0]} failed: {beside[1].dimensions.reason}"))


def recording_measures(found: Estimate, *, truth: Mapping[str, float]) -> None:
    """The four quantities of an estimate over several frames, with their 90 % intervals."""
    if found.fit is None:
        st.info(plain("; ".join(found.notes)), icon=":material/search_off:")
        return
    for column, name in zip(st.columns(4), GEOMETRY, strict=True):
        value, true = getattr(found, name), truth.get(name)
        low, high = found.intervals.get(name, (value, value))
        note = f"90 % interval {low:.0f}–{high:.0f} {BY_NAME[name].unit}"
        note += f"; error {percent_error(value, true)}" if true else ""
        measure(column, f"{BY_NAME[name].label}, whole recording", amount(name, value), note)


def hull_downloads(recording_id: str, fit: Fit) -> None:
    """Buttons for the hull as a mesh and as a table."""
    if not fit.hull.ok:
        return
    name, has_surface = f"{recording_id}_{'-'.join(fit.pair)}_frame{fit.frame}", fit.hull.converged.sum() > 1
    meshes: dict[str, tuple[str, Callable[[], bytes] | None]] = {
        f"Download hull ({ending.upper()})": (
            f"{name}.{ending}",
            partial(export_mesh, fit.hull, file_format=ending) if has_surface else None,
        )
        for ending in MESH_FORMATS
    }
    profile = partial(profile_table, fit.hull, fit.dimensions)
    download_buttons(
        meshes | {"Download profile (CSV)": (f"{name}_profile.csv", lambda: profile().to_csv(index=False).encode())}
    )
