"""How far the probabilities of fillings can be trusted, and what is gained by not answering where they are low."""

import numpy as np
import streamlit as st

from corsmal.evaluation import calibration_error, judged_confidences, reliability_table, risk_coverage_table
from corsmal.figures.calibration import calibration_figure
from corsmal.figures.style import run_colour
from corsmal.ui import session
from corsmal.ui.evaluation.downloads import downloads, pin_figure
from corsmal.ui.evaluation.errors import CLASSES
from corsmal.ui.evaluation.judged import Judged
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.one_of import one_of


def confidence_section(judged: Judged) -> None:
    """The reliability plot with its error, and the risk–coverage curve with a threshold for "don't know"."""
    run = judged.run
    left, right = st.columns([2, 5], gap="medium")
    with left:
        quantity = one_of("Classes", CLASSES, key="confidence_quantity", field="classes")
    confidence, is_right = judged_confidences(judged.errors(), quantity)
    if not len(confidence):
        st.info(
            "No probability can be compared here: fillings were not estimated, do not count, are not annotated, or "
            "their table has no columns `type_p0` to `level_p2`.",
            icon=":material/graphic_eq:",
        )
        return
    with right:
        threshold = _threshold()
    is_answered = confidence >= threshold
    numbers = {
        "Expected calibration error": f"{calibration_error(confidence, is_right):.1f} %",
        "Answered": f"{np.count_nonzero(is_answered)} of {len(confidence)}",
        "Wrong among these": f"{100 * np.mean(~is_right[is_answered]):.1f} %" if is_answered.any() else "–",
        "Wrong if all are answered": f"{100 * np.mean(~is_right):.1f} %",
    }
    for place, (label, text) in zip(st.columns(len(numbers)), numbers.items(), strict=True):
        place.metric(label, text)
    curve = risk_coverage_table(confidence, is_right)
    figure = calibration_figure(
        reliability_table(confidence, is_right), curve, threshold=threshold, colour=run_colour(run.preset)
    )
    linked_plot(
        figure,
        key="confidence",
        label=f"Reliability and risk of the {CLASSES[quantity].lower()}",
        height_px=400,
        revision=f"{run.name} {quantity}",
    )
    st.caption(
        "Left: answers in bins of their probability; below the dashed line they are given with too much confidence. "
        "Right: what is wrong when only the surest answers are given, and the others are left at “don't know”."
    )
    pin_figure(
        judged, figure, title=f"Confidence of the {CLASSES[quantity].lower()}", key="confidence", numbers=numbers
    )
    downloads(curve, name=f"{run.name}_{quantity}_risk")


def _threshold() -> float:
    """The probability below which nothing is answered, 0..1."""
    state, key = st.session_state, "confidence_threshold"
    state[key] = session.choice().sure_percent or 0.0
    st.slider(
        "“Don't know” below a probability of",
        0.0,
        100.0,
        step=1.0,
        format="%.0f %%",
        key=key,
        on_change=lambda: session.choose(sure_percent=state[key] or None),
    )
    return float(state[key]) / 100
