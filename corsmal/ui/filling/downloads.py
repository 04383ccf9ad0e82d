"""What one may take along from the Filling page: the sound, the sliding window, and a pin for the report."""

from collections.abc import Sequence

import pandas as pd
import streamlit as st

from corsmal.dataset import Recording
from corsmal.figures.report import Pin
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.ui import media, session
from corsmal.ui.filling import sound
from corsmal.ui.filling.timeline import HEADS
from corsmal.ui.pins import pin_button


def downloads(recording: Recording, *, crop_s: sound.Seconds | None, has_answer: bool) -> None:
    """Buttons for what is heard as a WAV and for the sliding window as a table."""
    left, middle, right = st.columns(3)
    channel = session.choice().channel
    microphone = "mean" if channel is None else f"microphone{channel + 1}"
    clip = "whole" if crop_s is None else "{:.2f}-{:.2f}s".format(*crop_s)
    left.download_button(
        "What is heard as WAV",
        lambda: sound.wav(recording, channel=channel, crop_s=crop_s),
        f"{recording.id}_{microphone}_{clip}.wav",
        icon=":material/download:",
        on_click="ignore",
        width="stretch",
    )
    with right:
        pin_button("the sound", lambda: _clip(recording, crop_s), key="sound")
    middle.download_button(
        "Sliding window as CSV",
        lambda: windows_table(sound.windows(recording)).to_csv(index=False).encode(),
        f"{recording.id}_windows.csv",
        icon=":material/download:",
        on_click="ignore",
        disabled=not has_answer,
        width="stretch",
    )


def _clip(recording: Recording, crop_s: sound.Seconds | None) -> Pin:
    """What is heard, as it is pinned for a report."""
    channel = session.choice().channel
    part = "all of it" if crop_s is None else "{:.2f} to {:.2f} s".format(*crop_s)
    title = f"Sound of {recording.id}, {media.channel_name(channel)}, {part}"
    return Pin(title, content=sound.wav(recording, channel=channel, crop_s=crop_s), medium="audio/wav")


def windows_table(windows: Sequence[FillingPrediction]) -> pd.DataFrame:
    """A row per window: where it is, s, what it says, and the probabilities and logits of both heads."""
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
