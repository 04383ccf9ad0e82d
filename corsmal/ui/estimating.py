"""The estimate over the whole recording, as a run makes it: the shape first, because the networks take longer."""

from typing import Any

import streamlit as st

from corsmal.dataset import Dataset
from corsmal.digests import file_fingerprint
from corsmal.errors import CorsmalError
from corsmal.estimation import Estimate
from corsmal.parameters import SHAPE_PRESETS
from corsmal.stages.estimates import Predictors, estimate_row
from corsmal.stages.moments import kept_estimate, moments_s
from corsmal.stages.settings import EstimateSettings, default_settings
from corsmal.ui import session, shared
from corsmal.ui.caching import cached
from corsmal.ui.messages import plain
from corsmal.ui.opened import OpenedRecording, by_detections

ESTIMATE = "tuned"
"""The preset of the estimate unless another one is chosen: the one that gives intervals."""


def estimate_control() -> str:
    """Choose the preset of the estimate over the whole recording."""
    st.session_state["estimate_control"] = session.choice().estimate or ESTIMATE
    st.segmented_control(
        "Estimate over the whole recording",
        list(SHAPE_PRESETS),
        key="estimate_control",
        required=True,
        on_change=_estimate_chosen,
        help="`tuned`: several frames together, with 90 % intervals. `paper`: the published method, from the best "
        "frame. `lode`: the method that it is based on.",
    )
    return str(st.session_state["estimate_control"])


def _estimate_chosen() -> None:
    name = st.session_state["estimate_control"]
    session.choose(estimate=None if name == ESTIMATE else name)


def estimate_settings(dataset: Dataset, preset: str) -> EstimateSettings:
    """What a run of a preset is made with; without networks, and with the reason on the page, if one cannot be read."""
    try:
        return default_settings(dataset, shape=SHAPE_PRESETS[preset])
    except CorsmalError as error:
        st.error(plain(str(error)), icon=":material/error:")
        return EstimateSettings(SHAPE_PRESETS[preset])


def _by_weights(settings: EstimateSettings) -> tuple[object, ...]:
    paths = [file.path for file in (settings.filling, settings.mass) if file is not None]
    return settings, [file_fingerprint(path) for path in paths]


@cached(4, key=_by_weights)
def predictors(settings: EstimateSettings) -> Predictors:
    """The networks of settings, open."""
    return settings.open()


def _by_estimate(opened: OpenedRecording, settings: EstimateSettings) -> tuple[object, ...]:
    return by_detections(opened, _by_weights(settings))


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
