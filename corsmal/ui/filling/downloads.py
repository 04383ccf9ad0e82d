"""What can be downloaded or pinned on the Filling page: the sound and the sliding window."""

from collections.abc import Sequence

import pandas as pd
import streamlit as st

from corsmal.figures.pins import Pin
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.ui import media, session
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.filling import sound
from corsmal.ui.filling.answer import HEADS
from corsmal.ui.filling.network import fused_network, network
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.pins import pin_button


def downloads(opened: OpenedRecording, *, crop_s: sound.Seconds | None, has_answer: bool) -> None:
    """Buttons for the crop as a WAV and for the sliding window as a table."""
    channel = session.choice().channel
    microphone = "mean" if channel is None else f"microphone{channel + 1}"
    clip = "whole" if crop_s is None else "{:.2f}-{:.2f}s".format(*crop_s)
    left, right = st.columns([2, 1])
    with left:
        is_fused = fused_network() is not None
        table = lambda: windows_table(sound.windows(opened)).to_csv(index=False).encode()  # noqa: E731
        windows = {"Download sliding window (CSV)": (f"{opened.id}_windows.csv", table if has_answer else None)}
        download_buttons(
            {
                "Download crop (WAV)": (
                    f"{opened.id}_{microphone}_{clip}.wav",
                    lambda: sound.wav(opened, channel, crop_s),
                ),
                **({} if is_fused else windows),
            }
        )
    with right:
        pin_button("the sound", lambda: [_clip(opened, crop_s, has_answer=has_answer)], key="sound")


def _clip(opened: OpenedRecording, crop_s: sound.Seconds | None, *, has_answer: bool) -> Pin:
    """The crop, as it is pinned for a report."""
    channel = session.choice().channel
    part = "whole recording" if crop_s is None else "{:.2f} to {:.2f} s".format(*crop_s)
    title = f"Sound of {opened.id}, {media.channel_name(channel)}, {part}"
    numbers, parameters = {}, {"heard": media.channel_name(channel), "crop": part}
    if has_answer:
        prediction = sound.prediction(opened, crop_s)
        kind, level = prediction.pair or (0, 0)
        answers = {"Filling type": TYPE_NAMES[kind], "Filling level": LEVEL_NAMES[level]}
        shares = prediction.probabilities
        numbers = {label: f"{answer}, {100 * shares[answer]:.0f} %" for label, answer in answers.items()}
        parameters["filling network"] = network().digest.rsplit(maxsplit=1)[-1][:8]
    return Pin(
        title,
        content=sound.wav(opened, channel, crop_s),
        medium="audio/wav",
        numbers=numbers,
        parameters=parameters,
        recording=opened.id,
    )


def windows_table(windows: Sequence[FillingPrediction]) -> pd.DataFrame:
    """A row per window: its ends, s, the predicted classes, and the probabilities and logits of both heads."""
    return pd.DataFrame([_window_row(window) for window in windows])


def _window_row(window: FillingPrediction) -> dict[str, float | str]:
    start, end = window.rows or (0, 0)
    step_s = window.steps_s or 0.0
    kind, level = window.pair or (0, 0)
    row: dict[str, float | str] = {"start_s": start * step_s, "end_s": end * step_s}
    row |= {"type": TYPE_NAMES[kind], "level": LEVEL_NAMES[level]}
    row |= {f"probability_{name}": share for name, share in window.probabilities.items()}
    for head, names in HEADS.items():
        row |= {f"logit_{name}": value for name, value in zip(names, getattr(window, f"{head}_logits"), strict=True)}
    return row
