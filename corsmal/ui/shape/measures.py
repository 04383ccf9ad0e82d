"""Pieces of pages: measures beside the truth, problems, the detection job."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial

import streamlit as st

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.estimation import Estimate, Fit
from corsmal.figures import reprojection_figure
from corsmal.parameters import CentreRule
from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.shape import MESH_FORMATS, export_mesh, profile_table
from corsmal.stages.detections import DetectionSet
from corsmal.ui import data
from corsmal.ui.linked_plot import linked_plot

WAITING = "waiting_to_be_said"


@contextmanager
def guarded() -> Iterator[None]:
    """Show an error of the library as its sentence, and go on with the rest of the page."""
    try:
        yield
    except CorsmalError as error:
        st.error(plain(str(error)), icon=":material/error:")


def plain(text: str) -> str:
    """Text for a place that reads Markdown: names of files and what stood in an address are shown as they are."""
    return re.sub(r"([\\`*_{}\[\]()<>#+!|$:~&-])", r"\\\1", text)


def measures(fit: Fit, *, truth: Mapping[str, float], beside: tuple[str, Fit] | None = None) -> None:
    """The four quantities of a fit, each with its error against the annotation, and those of another fit under them."""
    if not fit.ok:
        st.error(
            plain(f"The fit of {' + '.join(fit.pair)} in frame {fit.frame} failed: {fit.dimensions.reason}.")
            + " Try another frame or the other pair.",
            icon=":material/error:",
        )
        return
    for column, name in zip(st.columns(4), GEOMETRY, strict=True):
        label, unit = BY_NAME[name].label, BY_NAME[name].unit
        value = getattr(fit.dimensions, name)
        true = truth.get(name)
        note = "no annotation" if not true else f"{_error(value, true)} of {true:.0f} {unit}"
        column.metric(label, _amount(value, unit), note, delta_color="off")
        if beside is not None and beside[1].ok:
            value = getattr(beside[1].dimensions, name)
            column.caption(plain(f"{beside[0]}: {_amount(value, unit)}" + (f", {_error(value, true)}" if true else "")))
    if fit.hull.depth_mm is not None:
        st.caption(f"A box: the silhouettes agree better with one than with a round container; {_depth(fit)} deep.")
    if beside is not None and not beside[1].ok:
        st.caption(plain(f"{beside[0]} failed: {beside[1].dimensions.reason}"))


def say_later(sentence: str) -> None:
    """Have something said by the page: what a callback shows itself would replace the page's first elements."""
    st.session_state[WAITING] = sentence


def say_what_waits() -> None:
    """Say what a callback left to be said."""
    if (sentence := st.session_state.pop(WAITING, None)) is not None:
        st.toast(sentence)


def recording_measures(found: Estimate, *, truth: Mapping[str, float]) -> None:
    """The four quantities of an estimate over several frames, with their 90 % intervals."""
    if found.fit is None:
        st.error(plain("; ".join(found.notes)), icon=":material/error:")
        return
    for column, name in zip(st.columns(4), GEOMETRY, strict=True):
        label, unit = BY_NAME[name].label, BY_NAME[name].unit
        value, true = getattr(found, name), truth.get(name)
        low, high = (_amount(end, unit) for end in found.intervals.get(name, (value, value)))
        note = f"{low} to {high}" + (f"; {_error(value, true)}" if true else "")
        column.metric(f"{label}, whole recording", _amount(value, unit), note, delta_color="off", delta_arrow="off")


def _depth(fit: Fit) -> str:
    return _amount(fit.hull.depth_mm or 0.0, "mm")


def _amount(value: float, unit: str) -> str:
    return f"{value:.0f} {unit}" if unit == "mL" else f"{value:.1f} {unit}"


def _error(value: float, true: float) -> str:
    return f"{100 * (value - true) / true:+.1f} %"


def notes(found: DetectionSet) -> None:
    """Where the detections come from, and what is wrong with them."""
    sources = sorted({view.source for view in found.views.values()})
    if sources:
        st.caption(f":material/center_focus_strong: Detections: {plain('; '.join(sources))}")
    for note in found.notes:
        st.warning(plain(note), icon=":material/warning:")


def reprojection(
    recording: Recording, *, view: str, frame: int, fit: Fit, centre_rule: CentreRule, points: int
) -> None:
    """The circumferences over one view's picture and mask."""
    st.markdown(f"**{view}**, frame {frame}: the circumferences' points over the container's mask")
    mask = data.mask(recording, view=view, frame=frame, centre_rule=centre_rule)
    image = data.frame_image(recording, view=view, frame=frame)
    camera = data.cameras(recording).get(view)
    if mask is None or camera is None:
        st.image(data.frame_picture(recording, view=view, frame=frame, centre_rule=centre_rule))
        st.caption("no mask in this frame" if mask is None else "no calibration: nothing can be projected")
        return
    linked_plot(
        reprojection_figure(image, mask, camera, fit.hull, points=points),
        key=f"reprojection_{view}",
        label=f"Circumferences reprojected into {view}",
        height_px=460,
        revision=f"{recording.id} {frame}",
    )


def hull_downloads(recording: Recording, fit: Fit) -> None:
    """Buttons for the hull as a mesh and as a table."""
    if not fit.hull.ok:
        return
    name = f"{recording.id}_{'-'.join(fit.pair)}_frame{fit.frame}"
    columns = st.columns(len(MESH_FORMATS) + 1)
    for column, file_format in zip(columns, MESH_FORMATS, strict=False):
        column.download_button(
            f"Hull as {file_format.upper()}",
            partial(export_mesh, fit.hull, file_format=file_format),
            f"{name}.{file_format}",
            icon=":material/download:",
            on_click="ignore",
            disabled=not fit.hull.converged.sum() > 1,
            width="stretch",
        )
    columns[-1].download_button(
        "Radii profile as CSV",
        lambda: profile_table(fit.hull, fit.dimensions).to_csv(index=False).encode(),
        f"{name}_profile.csv",
        icon=":material/download:",
        on_click="ignore",
        width="stretch",
    )
