"""The container's mass as the Mass page asks for it: the mask, its restoration, the numbers, the network's answer."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import streamlit as st
from numpy.typing import NDArray

from corsmal.dataset import Recording
from corsmal.detection import ViewDetections
from corsmal.errors import ArgumentError, NotFoundError
from corsmal.estimation import Fit
from corsmal.mass import AxisRule, RestoredMask, mm_per_pixel
from corsmal.mass.restoration import PADDING_PX
from corsmal.parameters import PAIRS
from corsmal.stages import true_masks
from corsmal.store import file_fingerprint
from corsmal.ui import data, session
from corsmal.weights import find_weights

if TYPE_CHECKING:
    from corsmal.mass import MassModel

Mask = NDArray[np.bool_]
Numbers = Mapping[str, float | None]

MASS_VIEW = PAIRS[0][0]
"""The robot's view: the paper's View 1."""

CHANGES = np.linspace(-0.3, 0.3, 25)
"""Relative changes of the numbers whose effect is drawn; the one in the middle is none."""

PADDING, AXIS, NUMBERS = "mass_padding_px", "mass_axis_rule", "mass_numbers"
PADDING_MAX_PX = 80


@dataclass(frozen=True, eq=False)
class Weighed:
    """What the network says, and what it was given.

    Args:
        mass_g: grams; None where there is no answer.
        reason: why there is none.
        restored: the restored mask.
        network_input: (112, 112) float32, 0..1.
        resize: how it was made square.
        curves_g: for each number the masses (n,) as it changes by ``CHANGES``; empty without an answer.
    """

    mass_g: float | None
    reason: str
    restored: RestoredMask
    network_input: NDArray[np.float32]
    resize: str
    curves_g: Mapping[str, NDArray[np.float64]]


def model() -> "MassModel":
    """The network.

    Raises:
        FileError: its weights are missing or broken.
    """
    path = find_weights("mass").path
    return _model(str(path), file_fingerprint(path) if path.is_file() else "absent")


def padding_px() -> int:
    """The chosen padding around the mask's box; at first the paper's."""
    return int(st.session_state.get(PADDING, PADDING_PX))


def choose_padding(value: float | None) -> None:
    """Take over a padding that the user dragged, within the limits."""
    if value is not None:
        st.session_state[PADDING] = int(min(max(round(value), 0), PADDING_MAX_PX))


def fitted_numbers(recording: Recording, fit: Fit) -> dict[str, float | None]:
    """What the fit says about the numbers that the network and the filling are given; None where it failed."""
    names = ("width_top_mm", "width_bottom_mm", "height_mm", "capacity_ml")
    numbers: dict[str, float | None] = {name: getattr(fit.dimensions, name) for name in names}
    camera = data.cameras(recording).get(MASS_VIEW)
    numbers["mm_per_px"] = None
    if camera is not None and fit.hull.centroid_m is not None:
        with suppress(ArgumentError):  # it lies behind the camera
            numbers["mm_per_px"] = mm_per_pixel(camera, fit.hull.centroid_m)
    return numbers


def chosen_numbers(recording: Recording, fit: Fit) -> dict[str, float | None]:
    """The numbers as the user typed them over the fit's; those of another fit are forgotten."""
    fitted = fitted_numbers(recording, fit)
    identity = (recording.id, fit.pair, fit.frame, session.choice().shape, tuple(fitted.values()))
    if st.session_state.get(NUMBERS, (None,))[0] != identity:
        st.session_state[NUMBERS] = (identity, fitted)
    chosen: dict[str, float | None] = st.session_state[NUMBERS][1]
    return chosen


def choose_numbers(**numbers: float | None) -> None:
    """Type other numbers over the fit's."""
    identity, chosen = st.session_state[NUMBERS]
    st.session_state[NUMBERS] = (identity, chosen | numbers)


def forget_numbers() -> None:
    """Go back to the fit's numbers."""
    st.session_state.pop(NUMBERS, None)


def weigh_mask(mask: Mask, numbers: Numbers, *, network: "MassModel | None", axis: AxisRule, padding: int) -> Weighed:
    """Restore a mask and ask the network.

    Args:
        mask: (H, W) bool, not empty.
        numbers: width_top_mm, width_bottom_mm, height_mm and mm_per_px, None where they are not known.
        network: the network; without it the mask is restored all the same.
        axis: the rule for the axis.
        padding: pixels around the mask's box.
    """
    from corsmal.mass import MassConfig  # noqa: PLC0415 - loads PyTorch, which takes seconds
    from corsmal.mass.inputs import mass_input  # noqa: PLC0415
    from corsmal.mass.sensitivity import mass_sensitivity  # noqa: PLC0415

    config = replace(MassConfig.paper() if network is None else network.config, axis=axis)
    names = ["width_top_mm", "width_bottom_mm", "height_mm", "mm_per_px"]
    given = mass_input(mask, config=config, **{name: numbers[name] for name in names}, padding_px=padding)
    if given.image is None:
        raise ArgumentError("the mask is empty")
    if network is None or given.reason:
        reason = given.reason or "there are no weights"
        return Weighed(None, reason, given.restored, given.image, config.resize, {})
    curves = mass_sensitivity(network, given.image, given.numbers, changes=CHANGES)
    mass_g = float(curves[0, len(CHANGES) // 2])
    return Weighed(mass_g, "", given.restored, given.image, config.resize, dict(zip(names, curves, strict=False)))


def amodal_mask(recording: Recording, *, frame: int) -> Mask | None:
    """The container's whole silhouette in the robot's view; None where it is not known: only the demo has a truth.

    Raises:
        FileError: the truth is broken.
    """
    try:
        found = _amodal(data.recording_key(recording), _recording=recording)
        masks = found[frame]
    except (NotFoundError, KeyError):
        return None
    return masks.mask(0) if len(masks) else np.zeros(masks.size, dtype=bool)


@st.cache_resource(max_entries=4, show_spinner="Reading the mass network")
def _model(path: str, fingerprint: str) -> "MassModel":
    del fingerprint
    from corsmal.mass import read_mass  # noqa: PLC0415

    return read_mass(Path(path))


@st.cache_resource(max_entries=8, show_spinner=False)
def _amodal(key: str, *, _recording: Recording) -> ViewDetections:
    del key
    return true_masks(_recording, MASS_VIEW, kind="amodal")
