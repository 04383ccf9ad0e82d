"""The estimate over the whole recording, as a run makes it: the shape first, because the networks take longer."""

import sys
from contextlib import suppress
from typing import Any

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.digests import file_fingerprint
from corsmal.errors import CorsmalError
from corsmal.estimation import Estimate
from corsmal.parameters import SHAPE_PRESETS
from corsmal.stages.estimates import KIND, Predictors, estimate_key, estimate_row
from corsmal.stages.moments import kept_estimate, moments_s
from corsmal.stages.settings import EstimateSettings, default_settings
from corsmal.ui import session, shared
from corsmal.ui.caching import cached
from corsmal.ui.choice import ESTIMATE, SHOWN
from corsmal.ui.drawing import let_draw
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording, by_detections


def estimate_control() -> None:
    """Choose the preset of the estimate over the whole recording."""
    current = session.choice().estimate
    st.session_state["estimate_control"] = current or ESTIMATE
    st.segmented_control(
        "Estimate over the whole recording",
        [*SHAPE_PRESETS, *([SHOWN] if current == SHOWN else [])],
        key="estimate_control",
        required=True,
        format_func=lambda name: "own values" if name == SHOWN else name,
        on_change=_estimate_chosen,
        help="`tuned`: several frames together, with 90 % intervals. `paper`: the published method, from the best "
        "frame. `released`: the authors' program. `lode`: the method that they are based on.",
    )


def _estimate_chosen() -> None:
    name = st.session_state["estimate_control"]
    session.choose(estimate=None if name == ESTIMATE else name)


def estimate_settings(dataset: Dataset) -> EstimateSettings:
    """What a run with the estimate's parameters is made with.

    Where a network cannot be read it is left out, with the reason on the page.
    """
    shape, selection = session.choice().estimated_shape, session.choice().selected_by
    try:
        return default_settings(dataset, shape=shape, selection=selection)
    except CorsmalError as error:
        st.error(plain(str(error)), icon=":material/error:")
        return EstimateSettings(shape, selection=selection)


def shape_estimate(opened: OpenedRecording) -> Estimate:
    """The geometry over the whole recording, the same on every page."""
    shape, means = session.choice().estimated_shape, None
    with suppress(CorsmalError):  # a network that cannot be read is reported where it is used
        means = default_settings(session.opened()[0], shape=shape).means
    return opened.estimate(shape, means)


def _by_weights(settings: EstimateSettings) -> tuple[object, ...]:
    paths = [file.path for file in (settings.filling, settings.mass) if file is not None]
    return settings, [file_fingerprint(path) for path in paths]


def let_draw_before_networks() -> None:
    """Before PyTorch is loaded, which takes the cores, let the browser draw what it was sent."""
    if "torch" not in sys.modules:
        let_draw("rest")


@cached(4, key=_by_weights)
def predictors(settings: EstimateSettings) -> Predictors:
    """The networks of settings, open."""
    return settings.open()


def _by_estimate(opened: OpenedRecording, settings: EstimateSettings) -> tuple[object, ...]:
    return by_detections(opened, _by_weights(settings))


@cached(32, key=_by_estimate)
def _row_key(opened: OpenedRecording, settings: EstimateSettings) -> str:
    return estimate_key(opened.recording, settings, opened.detections.key)


def kept_numbers(opened: OpenedRecording, settings: EstimateSettings) -> dict[str, Any] | None:
    """The row of a run that estimated the recording like this, if there is one by now: without opening the networks."""
    return shared.store().json(KIND, _row_key(opened, settings))


@cached(16, key=_by_estimate)
def whole_estimate(opened: OpenedRecording, settings: EstimateSettings) -> tuple[Estimate, dict[str, Any]]:
    """The estimate, and its row as a run has it."""
    networks = predictors(settings)
    found = kept_estimate(opened.recording, opened.detections, networks, store=shared.store())
    return found, estimate_row(found, opened.recording, opened.detections, networks)


@cached(64)
def times_s(opened: OpenedRecording) -> tuple[float, ...]:
    """The times at which it is asked what was known."""
    return moments_s(opened.recording)
