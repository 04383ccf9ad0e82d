"""Pieces of the Mass page: the pictures, the numbers that the masses hang on, and what may be wrong."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import streamlit as st
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.estimation import Fit
from corsmal.figures.report import Pin
from corsmal.figures.restoration import mask_png, restoration_figure
from corsmal.figures.sensitivity import sensitivity_figure
from corsmal.mass import AxisRule
from corsmal.mass.axis import AXIS_RULES
from corsmal.ui import data, mass_network
from corsmal.ui.linked_plot import Slider, linked_plot
from corsmal.ui.mass_network import MASS_VIEW, Weighed
from corsmal.ui.pins import pin_button
from corsmal.ui.shape.measures import guarded, plain
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.mass import MassModel

INPUTS = {
    "width_top_mm": ("w_t", "width at the top (mm)"),
    "width_bottom_mm": ("w_b", "width at the bottom (mm)"),
    "height_mm": ("h", "height (mm)"),
    "mm_per_px": ("s", "scale (mm per pixel)"),
    "capacity_ml": ("C", "capacity (mL), for the filling"),
}
RULES = {"base": "base (paper)", "whole": "whole outline"}
LOW, HIGH = 0.01, 20_000.0


def about_weights(recording: Recording, network: "MassModel | None") -> None:
    """On real recordings, what the demo's weights are worth."""
    if network is not None and find_weights("mass").is_bundled and not recording.is_synthetic:
        st.info(
            "The network that came along learnt from **synthetic** containers alone: on a real recording its mass is a "
            "guess. Train your own with `python -m corsmal train mass ROOT RUN`, and name its weights in the "
            "environment as `CORSMAL_MASS_WEIGHTS`.",
            icon=":material/science:",
        )


def axis_control(learnt: AxisRule) -> AxisRule:
    """Choose how the axis is found; at first the way that the network learnt with."""
    state = st.session_state
    rule: AxisRule = state.get(mass_network.AXIS) or learnt
    state["mass_axis"] = rule
    st.segmented_control(
        "Axis from",
        AXIS_RULES,
        key="mass_axis",
        required=True,
        format_func=RULES.__getitem__,
        on_change=lambda: state.update({mass_network.AXIS: state["mass_axis"]}),
        help="`base`: perpendicular to the lower edge, in its middle. `whole`: where most of the outline is symmetric, "
        f"which does without the base. The network learnt with `{learnt}`.",
    )
    return rule


def shows_container(mask: NDArray[np.bool_] | None, *, frame: int) -> bool:
    """Whether there is anything to weigh; if not, the page says why."""
    if mask is not None and mask.any():
        return True
    problem = f"was not inspected in frame {frame}" if mask is None else f"shows no container in frame {frame}"
    st.info(
        f"{MASS_VIEW} {problem}: there is no mask to weigh. Choose another frame; the *Frames* page shows what was "
        "detected where.",
        icon=":material/search_off:",
    )
    return False


def problems(fit: Fit, weighed: Weighed, network: "MassModel | None") -> None:
    """Why a mass is missing, and what can be done about it."""
    if not fit.ok:
        st.warning(
            plain(f"The fit of {' + '.join(fit.pair)} in frame {fit.frame} failed: {fit.dimensions.reason}.")
            + " Type the dimensions below, try another frame or the other pair.",
            icon=":material/straighten:",
        )
    elif weighed.reason and network is not None:
        st.warning(plain(f"No container mass: {weighed.reason}."), icon=":material/warning:")
    if not weighed.restored.ok:
        st.warning(plain(f"Nothing was restored: {weighed.restored.reason}."), icon=":material/warning:")


def pictures(recording: Recording, mask: NDArray[np.bool_], weighed: Weighed, *, frame: int) -> None:
    """The mask before and after, against the truth, and as the network sees it; padding is dragged below."""
    amodal = None
    with guarded():
        amodal = mass_network.amodal_mask(recording, frame=frame)
    figure = restoration_figure(
        data.frame_image(recording, view=MASS_VIEW, frame=frame),
        mask,
        weighed.restored,
        network_input=weighed.network_input,
        resize=weighed.resize,
        amodal=amodal,
    )
    linked_plot(
        figure,
        key="restoration",
        label=f"The mask of {MASS_VIEW}, frame {frame}, before and after restoration",
        sliders=[
            Slider(
                "padding_px",
                "Padding around the mask's box: nothing is added outside it",
                0,
                mass_network.PADDING_MAX_PX,
                1,
                mass_network.padding_px(),
                "px",
            )
        ],
        height_px=400,
        revision=f"{recording.id} {frame} {weighed.restored.crop}",
    )
    if weighed.restored.notes:
        st.caption(f":material/info: {plain('; '.join(weighed.restored.notes))}.")
    pin_button("the masks", lambda: Pin(f"Mask of {recording.id}, {MASS_VIEW}, frame {frame}", figure), key="masks")


def number_inputs(recording: Recording, fit: Fit, numbers: mass_network.Numbers, *, with_scale: bool) -> None:
    """The numbers that the masses hang on, to be typed over."""
    st.markdown("**What the masses hang on**")
    for name, (symbol, label) in INPUTS.items():
        if name == "mm_per_px" and not with_scale:
            continue
        key = f"mass_{name}"
        value = numbers[name]
        st.session_state[key] = None if value is None else min(max(float(value), LOW), HIGH)
        st.number_input(
            f"{symbol}, {label}",
            LOW,
            HIGH,
            value=None,
            step=0.01 if name == "mm_per_px" else 1.0,
            format="%.2f" if name == "mm_per_px" else "%.1f",
            key=key,
            placeholder="missing: the fit failed",
            on_change=_typed,
            args=(name,),
        )
    source = f"the fit of {' + '.join(fit.pair)} in frame {fit.frame}"
    st.button(
        f"Back to {source}",
        icon=":material/undo:",
        disabled=numbers == mass_network.fitted_numbers(recording, fit),
        on_click=mass_network.forget_numbers,
        width="stretch",
    )


def sensitivity(recording: Recording, weighed: Weighed, numbers: mass_network.Numbers) -> None:
    """The mass as each number changes."""
    if not weighed.curves_g:
        st.caption("What a change of each number does to the mass is drawn here once there is a mass.")
        return
    linked_plot(
        sensitivity_figure(
            mass_network.CHANGES,
            {INPUTS[name][0]: curve for name, curve in weighed.curves_g.items()},
            values={INPUTS[name][0]: float(numbers[name] or 0) for name in weighed.curves_g},
            true_g=getattr(recording.annotation, "container_mass_g", None),
        ),
        key="mass_sensitivity",
        label="Container mass as one of the network's numbers changes",
        height_px=420,
        revision=recording.id,
    )


def downloads(recording: Recording, weighed: Weighed, *, frame: int) -> None:
    """Buttons for the restored mask and the network's input as pictures."""
    name = f"{recording.id}_{MASS_VIEW}_frame{frame}"
    images: dict[str, tuple[str, NDArray[np.bool_] | NDArray[np.float32]]] = {
        "Restored mask as PNG": ("restored", weighed.restored.mask),
        "Network's input as PNG": ("input", weighed.network_input),
    }
    for column, (label, (ending, image)) in zip(st.columns(2), images.items(), strict=True):
        column.download_button(
            label,
            partial(mask_png, image),
            f"{name}_{ending}.png",
            icon=":material/download:",
            on_click="ignore",
            width="stretch",
        )


def _typed(name: str) -> None:
    mass_network.choose_numbers(**{name: st.session_state[f"mass_{name}"]})
