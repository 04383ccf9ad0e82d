"""The filling network's prediction beside the truth."""

import streamlit as st

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.figures.answer import Head, answer_figure
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction, FusedPrediction
from corsmal.ui.filling import fused, sound
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.messages import show_problem
from corsmal.ui.opened import OpenedRecording
from corsmal.weights import find_weights

HEADS: dict[Head, tuple[str, ...]] = {"type": TYPE_NAMES, "level": LEVEL_NAMES}


def weights_note(recording: Recording) -> None:
    """Say so where a network that was trained on synthetic sound predicts from a real one."""
    if find_weights("filling").is_bundled and not recording.is_synthetic:
        st.warning(
            "The bundled network was trained on **synthetic sound** only, never on a real recording: expect wrong "
            "predictions. Train your own with `python -m corsmal train filling ROOT RUN`, then start the app with "
            "`CORSMAL_FILLING_WEIGHTS=RUN/filling.safetensors`.",
            icon=":material/science:",
        )


def predicted(opened: OpenedRecording, crop_s: sound.Seconds | None) -> FillingPrediction | None:
    """The prediction for a crop; None, with the reason on the page, where there can be none."""
    try:
        return sound.prediction(opened, crop_s)
    except CorsmalError as error:
        show_problem(error, before="No prediction: ")
        return None


def answer(opened: OpenedRecording, prediction: FillingPrediction, *, crop_s: sound.Seconds | None) -> None:
    """Type and level beside the truth, each with the probabilities and logits of its head."""
    known = opened.recording.annotation
    truth: dict[Head, str | None] = {
        "type": None if known is None else known.filling,
        "level": None if known is None else known.level,
    }
    beside = {} if crop_s is None else {"whole recording": sound.prediction(opened, None)}
    if isinstance(prediction, FusedPrediction) and prediction.sound is not None and prediction.sight is not None:
        beside |= {"sound": prediction.sound, "sight": prediction.sight}
    for head in HEADS:
        _verdict(head, prediction, truth[head])
        figure = answer_figure.parts(prediction, head=head, beside=beside, true=truth[head])
        linked_plot(
            figure,
            key=f"answer_{head}",
            label=f"Probabilities and logits of the {head}",
            height_px=figure["layout"]["height"],
        )
    marks = {"whole recording": "Grey line: the whole recording.", "sound": "● sound only.", "sight": "■ sight only."}
    if isinstance(prediction, FusedPrediction):
        fused.verdict(opened, prediction)
    st.caption(" ".join(["◆ annotated; logits in brackets.", *(marks[name] for name in beside)]))


def _verdict(head: Head, prediction: FillingPrediction, true: str | None) -> None:
    number = prediction.filling_type if head == "type" else prediction.filling_level
    name = HEADS[head][number or 0]
    right = name == true
    st.metric(
        f"Filling {head}",
        f"{name}, {100 * prediction.probabilities[name]:.0f} %",
        "no annotation" if true is None else f"{'✓' if right else '✗'} annotated: {true}",
        delta_color="off" if true is None else "normal" if right else "inverse",
        delta_arrow="off",
    )
