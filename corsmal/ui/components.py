"""Pieces of pages: measures beside the truth, problems, the detection job."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial

import streamlit as st

from corsmal.batch import DetectionSet, detect_recording
from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.estimation import Fit
from corsmal.figures import reprojection_figure
from corsmal.parameters import CentreRule
from corsmal.shape import MESH_FORMATS, export_mesh, profile_table
from corsmal.ui import data
from corsmal.ui.jobs import Job
from corsmal.ui.linked_plot import linked_plot

QUANTITIES = {
    "capacity_ml": ("Capacity", "mL"),
    "width_top_mm": ("Width at the top", "mm"),
    "width_bottom_mm": ("Width at the bottom", "mm"),
    "height_mm": ("Height", "mm"),
}


@contextmanager
def guarded() -> Iterator[None]:
    """Show an error of the library as its sentence, and go on with the rest of the page."""
    try:
        yield
    except CorsmalError as error:
        st.error(str(error), icon=":material/error:")


def measures(fit: Fit, *, truth: Mapping[str, float]) -> None:
    """The four quantities of a fit, each with its error against the annotation."""
    if not fit.ok:
        st.error(f"The fit failed: {fit.dimensions.reason}.", icon=":material/error:")
        return
    for column, (name, (label, unit)) in zip(st.columns(4), QUANTITIES.items(), strict=True):
        value = getattr(fit.dimensions, name)
        true = truth.get(name)
        note = "no annotation" if not true else f"{100 * (value - true) / true:+.1f} % of {true:.0f} {unit}"
        column.metric(label, f"{value:.0f} {unit}" if unit == "mL" else f"{value:.1f} {unit}", note, delta_color="off")


def notes(found: DetectionSet) -> None:
    """Where the detections come from, and what is wrong with them."""
    sources = sorted({view.source for view in found.views.values()})
    if sources:
        st.caption(f":material/center_focus_strong: Detections: {'; '.join(sources)}")
    for note in found.notes:
        st.warning(note, icon=":material/warning:")


def reprojection(
    recording: Recording, *, view: str, frame: int, fit: Fit, centre_rule: CentreRule, points: int
) -> None:
    """The circumferences over one view's picture and mask."""
    st.markdown(f"**{view}**, frame {frame}: the circumferences' points over the container's mask")
    mask = data.mask(recording, view=view, frame=frame, centre_rule=centre_rule)
    image = data.frame_image(recording, view=view, frame=frame)
    camera = data.cameras(recording).get(view)
    if mask is None or camera is None:
        st.caption("no mask in this frame" if mask is None else "no calibration")
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
        disabled=not fit.hull.ok,
        width="stretch",
    )


def detection_job(recording: Recording, found: DetectionSet) -> None:
    """Offer to detect in the views that have no detections, or show how far the job is."""
    key = f"detect {data.recording_key(recording)}"
    job = data.jobs().get(key)
    if job is not None and job.active:
        _watch(key)
        return
    if job is not None and job.state == "failed":
        st.error(job.problem, icon=":material/error:")
    # a view whose file could not be used is not detected in: the notes say what is wrong with the file
    lacking = [
        name for name in found.missing if name in recording.views and recording.views[name].detections_path is None
    ]
    if not lacking:
        return
    st.info(
        f"{', '.join(lacking)}: no detections yet. Mask R-CNN can look for containers in every frame; or put COCO "
        f"results in `{lacking[0]}/detections/{recording.id}.json`.",
        icon=":material/search:",
    )
    if st.button("Detect with Mask R-CNN", type="primary", icon=":material/play_arrow:"):
        data.jobs().start(key, "Detecting containers", lambda job: _detect(job, recording))
        st.rerun()


@st.fragment(run_every=0.5)
def _watch(key: str) -> None:
    job = data.jobs().get(key)
    if job is None or not job.active:
        data.forget_detections()
        st.rerun()
        return
    left = job.seconds_left
    time_left = (
        "" if left is None else f", about {left:.0f} s left" if left < 90 else f", about {left / 60:.0f} min left"
    )
    text = f"{job.label}: {job.done} of {job.total} frames{time_left}" if job.total else f"{job.label}: loading weights"
    st.progress(job.done / job.total if job.total else 0.0, text=text)
    st.button("Stop", on_click=job.cancel, help="What was done is kept.", icon=":material/stop:")


def _detect(job: Job, recording: Recording) -> None:
    from corsmal.detection import MaskRCNNDetector  # noqa: PLC0415 - PyTorch takes seconds to import

    detector = MaskRCNNDetector()
    detect_recording(recording, detector, store=data.store(), progress=job.advance, cancelled=job.cancelled)
