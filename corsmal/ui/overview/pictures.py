"""What the numbers come from: the views with their masks, the hull, the restored mask, the sound."""

from collections.abc import Mapping

import streamlit as st

from corsmal.errors import CorsmalError, NotFoundError
from corsmal.estimation import Estimate, Fit
from corsmal.figures import hull_figure
from corsmal.figures.answer import answer_figure
from corsmal.figures.pins import Pin
from corsmal.figures.restoration import restored_figure
from corsmal.mass import restore_mask
from corsmal.parameters import FRONTAL_VIEW
from corsmal.selection import BestFrame
from corsmal.ui import session
from corsmal.ui.filling import sound
from corsmal.ui.filling.answer import HEADS
from corsmal.ui.linked_plot import linked_plot, plot_event
from corsmal.ui.messages import guarded, plain
from corsmal.ui.opened import OpenedRecording, show_panel
from corsmal.ui.overview.numbers import Tile
from corsmal.ui.overview.tiles import page_link
from corsmal.ui.shape.parameters import chosen_camera, parameter_texts, turned
from corsmal.ui.time_line import time_line

HULL, HEIGHT_PX = "overview_hull", 330


def views(opened: OpenedRecording, found: Estimate) -> None:
    """The three views with their masks, at first at the best frame."""
    best = found.best_frame or _first_pair(opened)
    page_link(f"Frames: {_best_text(opened, best)}", "frames", found)
    show_panel(lambda opened: time_line(opened, best, is_large=True), opened)


def _first_pair(opened: OpenedRecording) -> BestFrame:
    shape = session.choice().estimated_shape
    return opened.best_frame(shape.pairs[0], shape)


def _best_text(opened: OpenedRecording, best: BestFrame) -> str:
    if best.frame is None:
        return "none is the best yet"
    time = f" ({best.frame / opened.fps:.2f} s)" if opened.fps else ""
    if best.is_fallback:
        return f"{best.frame}{time}, because none passes the rules"
    return f"{best.frame}{time} {'fits best' if best.is_by_fit else 'has the best View Score'}"


def hull(opened: OpenedRecording, found: Estimate) -> None:
    """The hull of the best-fitting frame."""
    page_link("Hull", "shape", found)
    if found.fit is None or not found.fit.hull.ok:
        st.caption(plain("; ".join(found.notes)) or "Nothing was fitted.")
        return
    show_panel(lambda opened: _hull_plot(opened, found.fit), opened)


def _hull_plot(opened: OpenedRecording, fit: Fit | None) -> None:
    if fit is None:
        return
    if changes := turned(plot_event(HULL)):
        session.choose(**changes)
    linked_plot(
        hull_figure.parts(fit.hull, fit.dimensions, cameras=opened.cameras, preset=session.choice().estimate_preset),
        key=HULL,
        label="Hull and circumferences in 3D",
        height_px=HEIGHT_PX,
        revision=opened.id,
        follows_camera=True,
        camera=session.choice().camera if session.choice().scope is None else None,
    )


def answer_pins(opened: OpenedRecording, found: Estimate, tiles: Mapping[str, Tile]) -> list[Pin]:
    """The hull with all numbers of the page, to be pinned."""
    fit, current = found.fit, session.choice()
    if fit is None:
        raise NotFoundError(f"nothing was fitted in recording {opened.id}: there is no hull to pin")
    figure = hull_figure(fit.hull, fit.dimensions, cameras=opened.cameras, preset=current.estimate_preset)
    if current.scope is None:
        figure.update_layout(chosen_camera())
    return [
        Pin(
            f"Answers for {opened.id}, {current.estimate_name}",
            figure,
            numbers={
                label: " · ".join(filter(None, (tile.value, tile.interval, tile.verdict)))
                for label, tile in tiles.items()
            },
            parameters=parameter_texts(current.estimated_shape, name=current.estimate_name),
            recording=opened.id,
            frame=fit.frame,
        )
    ]


def mask(opened: OpenedRecording, found: Estimate) -> None:
    """The mask that the container's mass is predicted from, restored."""
    page_link("Mask, restored by symmetry", "mass", found)
    if found.mass_frame is None or found.best_frame is None:
        st.caption("There is no mask without a fit.")
        return
    with guarded():
        frame, rule = found.mass_frame, found.best_frame.centre_rule
        seen = opened.mask(FRONTAL_VIEW, frame, rule)
        restored = restore_mask(seen) if found.mass is None else found.mass.restored
        linked_plot(
            restored_figure.parts(opened.image(FRONTAL_VIEW, frame), seen, restored),
            key="overview_mask",
            label=f"The mask of {FRONTAL_VIEW}, frame {frame}, restored",
            height_px=HEIGHT_PX,
            revision=f"{opened.id} {frame}",
        )


def heard(opened: OpenedRecording, found: Estimate, *, left_out: str) -> None:
    """The sound, and the probabilities and logits that it gave."""
    page_link("Sound", "filling", found)
    try:
        st.audio(sound.wav(opened, session.choice().channel, None))
    except CorsmalError as error:
        st.caption(plain(str(error)))
        return
    prediction, known = found.filling, opened.recording.annotation
    if prediction is None or not prediction.ok:
        st.caption(plain(left_out or (prediction.reason if prediction is not None else "")))
        return
    truth = {"type": getattr(known, "filling", None), "level": getattr(known, "level", None)}
    for head in HEADS:
        figure = answer_figure.parts(prediction, head=head, true=truth[head])
        linked_plot(
            figure,
            key=f"overview_{head}",
            label=f"Probabilities and logits of the {head}",
            height_px=figure["layout"]["height"],
        )
    st.caption("Probability, logit in brackets; ◆ annotated.")
