"""The Mass page: the mask and the numbers that the network is given, its prediction, and the object's mass."""

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import plotly.graph_objects as go
import streamlit as st
from numpy.typing import NDArray

from corsmal.errors import CorsmalError, NotFoundError
from corsmal.estimation import Estimate, Fit, mass_inputs
from corsmal.estimation.filling_mass import filling_mass_interval_g
from corsmal.figures.pins import Pin
from corsmal.figures.restoration import mask_png, restoration_figure
from corsmal.figures.sensitivity import sensitivity_figure
from corsmal.filling import FillingPrediction
from corsmal.mass import AxisRule, MassPrediction, filling_mass_g
from corsmal.parameters import FRONTAL_VIEW, ShapeParameters
from corsmal.quantities import GEOMETRY
from corsmal.selection import BestFrame
from corsmal.ui import session
from corsmal.ui.amounts import filling_text, grams, mass_error, mass_interval, measure, total
from corsmal.ui.controls import PADDING_MAX_PX
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.filling import sound
from corsmal.ui.linked_plot import Slider, linked_plot
from corsmal.ui.mass_numbers import INPUTS, Numbers
from corsmal.ui.messages import guarded, plain
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.pins import pin_button

if TYPE_CHECKING:
    from corsmal.mass import MassPredictor

Mask = NDArray[np.bool_]

CHANGES = np.linspace(-0.3, 0.3, 25)
"""Relative changes of the numbers whose effect is drawn; the one in the middle is none."""


def estimate_in_frame(
    opened: OpenedRecording, found: Estimate, best: BestFrame, frame: int, shape: ShapeParameters
) -> tuple[Estimate, Fit]:
    """The estimate over the recording in the frame whose mask it uses; in others what the frame's fit says.

    Args:
        opened: the recording.
        found: its estimate.
        best: the chosen pair of views.
        frame: the shown frame.
        shape: parameters of both.

    Returns:
        The estimate and its fit.
    """
    if found.fit is not None and (found.fit.pair, found.mass_frame) == (best.pair, frame):
        return found, found.fit
    fit = opened.fit(best, frame, shape)
    if found.fit is None and not fit.ok:
        return replace(found, best_frame=best, fit=fit, mass_frame=frame), fit
    measures: dict[str, Any] = {name: getattr(fit.dimensions, name) for name in GEOMETRY}
    return Estimate(opened.id, "fitted", **measures, best_frame=best, fit=fit, notes=(), mass_frame=frame), fit


def best_for_mass(found: Estimate, best: BestFrame) -> BestFrame:
    """The best frame of a pair, of the estimate's own pair the one whose mask the mass is predicted from."""
    is_own = found.mass_frame is not None and found.best_frame is not None and found.best_frame.pair == best.pair
    return replace(best, frame=found.mass_frame, reason="") if is_own else best


def network_inputs(opened: OpenedRecording, found: Estimate) -> tuple[Mask, Numbers] | None:
    """The container's mask and the numbers, None where the fit failed; without a mask the page says why."""
    try:
        inputs = mass_inputs(found, opened) or {}
    except NotFoundError as error:
        st.info(
            f"{plain(str(error))}: there is no mask to predict from. Choose another frame; the *Frames* page shows "
            "what was detected where.",
            icon=":material/search_off:",
        )
        return None
    return inputs.pop("mask"), inputs | {"capacity_ml": found.capacity_ml}


def predict(
    mask: Mask, numbers: Numbers, *, network: "MassPredictor | None", axis: AxisRule, padding_px: int
) -> tuple[MassPrediction, dict[str, NDArray[np.float64]]]:
    """The prediction, and the masses as each number changes by ``CHANGES``."""
    from corsmal.mass.sensitivity import predict_with_changes  # noqa: PLC0415 - as above

    model = None if network is None else network.model
    return predict_with_changes(model, mask, numbers, changes=CHANGES, axis=axis, padding_px=padding_px)


def object_mass(opened: OpenedRecording, container_g: float | None, *, capacity_ml: float | None) -> str:
    """Container, filling and object mass beside the truth.

    Returns:
        Where the filling is from, in Markdown.
    """
    note = opened.recording.annotation
    annotated = None
    if note is not None and note.filling_type is not None and note.filling_level is not None:
        annotated = note.filling_type, note.filling_level
    pair, source, between = annotated, "the annotation", ""
    with suppress(CorsmalError):
        predicted = sound.prediction(opened, None)
        if predicted.pair is not None:
            pair, source, between = predicted.pair, "the sound", _interval(predicted, capacity_ml)
    filling_g = None if pair is None else filling_mass_g(*pair, capacity_ml)
    true_g = [getattr(note, name, None) for name in ("container_mass_g", "filling_mass_g")]
    masses = {
        "Container mass": (container_g, true_g[0]),
        "Filling mass": (filling_g, true_g[1]),
        "Object mass": (total(container_g, filling_g), total(*true_g)),
    }
    for column, (label, (value, true)) in zip(st.columns(3), masses.items(), strict=True):
        measure(column, label, grams(value), mass_error(value, true))
    text = "unknown, without sound and annotation" if pair is None else f"{filling_text(*pair)}, from {source}"
    if pair is not None and filling_mass_g(*pair, None) is None:
        text += "; the capacity is missing" if capacity_ml is None else f"; capacity {capacity_ml:.0f} mL"
    text += between
    if pair and annotated and filling_text(*annotated) != filling_text(*pair):
        text += f" (annotated: {filling_text(*annotated)})"
    return f":material/water_full: Filling: {text}. Object = container + filling."


def _interval(predicted: FillingPrediction, capacity_ml: float | None) -> str:
    """Where the filling's mass lies for that capacity."""
    types, levels = predicted.type_probabilities, predicted.level_probabilities
    if capacity_ml is None or types is None or levels is None:
        return ""
    ends_g = filling_mass_interval_g(types.tolist(), levels.tolist(), capacity_ml)
    return f"; filling mass: {mass_interval(ends_g)}"


def problems(shown: Estimate, prediction: MassPrediction, *, is_asked: bool) -> None:
    """Why a mass is missing or assumed, and what can be done; ``is_asked`` unless a network or a number is missing."""
    fit = shown.fit
    if fit is not None and not fit.ok:
        means = "" if shown.height_mm is None else " The mean dimensions of the training set are used, as in a run."
        st.warning(
            plain(f"The fit of {' + '.join(fit.pair)} in frame {fit.frame} failed: {fit.dimensions.reason}.{means}")
            + " Type the dimensions below, try another frame or the other pair.",
            icon=":material/straighten:",
        )
    elif prediction.reason and is_asked:
        st.warning(plain(f"No container mass: {prediction.reason}."), icon=":material/warning:")
    for note in prediction.notes:
        st.warning(plain(f"The mass is assumed: {note}."), icon=":material/warning:")
    if not prediction.restored.ok:
        st.warning(plain(f"Nothing was restored: {prediction.restored.reason}."), icon=":material/warning:")


def pictures(
    opened: OpenedRecording,
    mask: Mask,
    prediction: MassPrediction,
    *,
    frame: int,
    resize: str,
    axis: AxisRule,
    padding_px: int,
) -> None:
    """The mask before and after, against the truth, and as the network sees it; padding is dragged below."""
    restored, amodal = prediction.restored, None
    if prediction.network_input is None:
        return
    with guarded():
        amodal = opened.true_mask(FRONTAL_VIEW, frame)
    figure = restoration_figure.parts(
        opened.image(FRONTAL_VIEW, frame),
        mask,
        restored,
        network_input=prediction.network_input,
        resize=resize,
        amodal=amodal,
    )
    label = "Padding around the mask's box: nothing is added outside it"
    linked_plot(
        figure,
        key="restoration",
        label=f"The mask of {FRONTAL_VIEW}, frame {frame}, before and after restoration",
        sliders=[Slider("padding_px", label, 0, PADDING_MAX_PX, 1, padding_px, "px")],
        height_px=340,
        revision=f"{opened.id} {frame} {restored.crop}",
    )
    if restored.notes:
        notes = "; ".join(restored.notes)
        st.caption(f":material/info: {plain(notes[0].upper() + notes[1:])}.")
    title = f"Mask of {opened.id}, {FRONTAL_VIEW}, frame {frame}"
    numbers = {} if prediction.mass_g is None else {"Container mass": grams(prediction.mass_g)}
    parameters = {"preset of the shape": session.choice().estimate_name, "axis": axis, "padding": f"{padding_px} px"}
    pin_button(
        "the masks",
        lambda: [
            Pin(
                title,
                go.Figure(figure),
                numbers=numbers,
                parameters=parameters,
                recording=opened.id,
                frame=frame,
            )
        ],
        key="masks",
    )


def sensitivity(opened: OpenedRecording, numbers: Numbers, curves_g: dict[str, NDArray[np.float64]]) -> None:
    """The mass as each number changes."""
    if not curves_g:
        st.caption("Once there is a mass, its sensitivity to each number is drawn here.")
        return
    linked_plot(
        sensitivity_figure.parts(
            CHANGES,
            {INPUTS[name][0]: curve for name, curve in curves_g.items()},
            values={INPUTS[name][0]: float(numbers[name] or 0) for name in curves_g},
            true_g=getattr(opened.recording.annotation, "container_mass_g", None),
        ),
        key="mass_sensitivity",
        label="Container mass as one of the network's numbers changes",
        height_px=420,
        revision=opened.id,
    )


def downloads(opened: OpenedRecording, prediction: MassPrediction, *, frame: int) -> None:
    """Buttons for the restored mask and the network's input as pictures."""
    name, image = f"{opened.id}_{FRONTAL_VIEW}_frame{frame}", prediction.network_input
    download_buttons(
        {
            "Download restored mask (PNG)": (f"{name}_restored.png", partial(mask_png, prediction.restored.mask)),
            "Download network input (PNG)": (f"{name}_input.png", None if image is None else partial(mask_png, image)),
        }
    )
