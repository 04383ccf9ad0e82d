"""The Mass page's network: which it is, how masks are restored for it, and where the page differs from its training."""

from typing import TYPE_CHECKING

import streamlit as st

from corsmal.dataset import Recording
from corsmal.digests import file_fingerprint
from corsmal.mass import AxisRule
from corsmal.mass.restoration import PADDING_PX
from corsmal.stages.training_facts import shape_name, trained_shape
from corsmal.ui import session
from corsmal.ui.caching import cached
from corsmal.ui.controls import PADDING_MAX_PX
from corsmal.ui.linked_plot import PlotEvent
from corsmal.ui.messages import guarded, plain
from corsmal.ui.one_of import one_of
from corsmal.weights import WeightsFile, find_weights

if TYPE_CHECKING:
    from corsmal.mass import MassPredictor

RULES: dict[AxisRule, str] = {"base": "base (paper)", "whole": "whole outline", "top": "top row (released)"}


def open_network(recording: Recording) -> "MassPredictor | None":
    """The network, with a note on what the bundled one is worth on a real recording; None where it cannot be read."""
    file = find_weights("mass")
    with guarded():
        network = _network(file, file_fingerprint(file.path) if file.path.is_file() else "absent")
        if file.is_bundled and not recording.is_synthetic:
            st.info(
                "The bundled network was trained on **synthetic** containers only: on a real recording its mass is a "
                "guess. Train your own with `python -m corsmal train mass ROOT RUN`.",
                icon=":material/science:",
            )
        return network
    return None


@cached(4, key=lambda *file_and_fingerprint: file_and_fingerprint, spinner="Reading the mass network")
def _network(file: WeightsFile, fingerprint: str) -> "MassPredictor":
    del fingerprint
    from corsmal.mass import MassPredictor  # noqa: PLC0415 - loads PyTorch, which takes seconds

    return MassPredictor(file.path)


def axis_control(network: "MassPredictor | None") -> AxisRule:
    """Choose how the axis is found; at first as for the network's training."""
    trained: AxisRule = "base" if network is None else network.config.axis
    text = (
        "`base`: perpendicular to the lower edge, through its middle. `whole`: the axis about which most of the "
        "outline is symmetric, whatever the base. `top`: vertical through the middle of the topmost row; rows below it "
        f"are widened and filled, as in the authors' program. The network was trained with `{trained}`."
    )
    return one_of("Axis from", RULES, key="mass_axis", default=trained, help_text=text, field="axis")


def dragged_padding_px(event: PlotEvent, network: "MassPredictor | None") -> int:
    """The padding around the mask's box after what the user dragged, within the limits; at first the network's."""
    first = PADDING_PX if network is None else network.config.padding_px
    if "padding_px" in event.values:
        dragged = int(min(max(round(event.values["padding_px"]), 0), PADDING_MAX_PX))
        session.choose(settled=event.settled, padding_px=None if dragged == first else dragged)
    chosen = session.choice().padding_px
    return first if chosen is None else chosen


def trained_otherwise(network: "MassPredictor", *, axis: AxisRule, padding_px: int) -> None:
    """Say where the choices on the page are not those that the network was trained with."""
    shape, trained_with = session.choice().estimated_shape, trained_shape(network.trained_on)
    trained, config = [], network.config
    if axis != config.axis:
        trained.append(f"the axis from `{config.axis}`")
    if padding_px != config.padding_px:
        trained.append(f"a padding of {config.padding_px} px")
    if trained_with is not None and trained_with != shape_name(shape):
        trained.append(f"dimensions of the preset `{plain(trained_with)}`")
    if trained:
        text = f"The network was trained with {' and '.join(trained)}: with other choices its mass means less."
        st.caption(f":material/model_training: {text}")
