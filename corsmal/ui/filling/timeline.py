"""The sound on a time axis: the crop that the network hears, the frame that is shown, the microphone that is played."""

import streamlit as st

from corsmal.figures.sound import SoundPicture
from corsmal.figures.timeline import timeline_figure
from corsmal.filling import FillingPrediction
from corsmal.ui import media, session
from corsmal.ui.filling import sound
from corsmal.ui.filling.microphone import microphone_control
from corsmal.ui.linked_plot import PlotEvent, Span, linked_plot
from corsmal.ui.opened import OpenedRecording

TIMELINE = "timeline"
STEP_S = 0.05
CROP_MIN_S = 0.25
"""Less than this is a click."""

PLAYED = "played_crop"


def followed_crop(event: PlotEvent, picture: SoundPicture) -> sound.Seconds | None:
    """The chosen crop within the recording, after what the user dragged; None for the whole."""
    end_s = _end_s(picture)
    start_s, stop_s = session.choice().crop_s or (0.0, end_s)
    if start_s > end_s - CROP_MIN_S:
        st.warning(
            f"The crop from {start_s:.2f} to {stop_s:.2f} s was ignored: the recording ends at {end_s:.2f} s.",
            icon=":material/content_cut:",
        )
        start_s, stop_s = 0.0, end_s
    dragged = dict(event.values)
    stop_s = min(max(dragged.get("crop_to", stop_s), CROP_MIN_S), end_s)
    start_s = dragged.get("crop_from", start_s)
    start_s = max(0.0, min(start_s, stop_s - CROP_MIN_S))
    crop_s = None if (start_s, stop_s) == (0.0, end_s) else (round(start_s, 2), round(stop_s, 2))
    is_new = crop_s != session.choice().crop_s
    session.choose(settled=event.settled, **({"crop_s": crop_s} if is_new else {}))
    return crop_s


def timeline(
    picture: SoundPicture,
    *,
    opened: OpenedRecording,
    prediction: FillingPrediction | None,
    crop_s: sound.Seconds | None,
) -> None:
    """The sound, the attention and the sliding window on one axis, with the handles of the crop."""
    figure = timeline_figure.parts(
        picture,
        channel=media.channel_name(session.choice().channel),
        prediction=prediction,
        windows=[] if prediction is None else sound.windows(opened),
    )
    end_s, cropped = _end_s(picture), figure["layout"]["meta"]["cropped"]
    linked_plot(
        figure,
        key=TIMELINE,
        label=f"Sound of recording {opened.id}",
        height_px=figure["layout"]["height"],
        span=Span(
            names=("crop_from", "crop_to"),
            labels=("Start of the crop", "End of the crop"),
            min=0.0,
            max=end_s,
            step=STEP_S,
            values=crop_s or (0.0, end_s),
            gap=min(CROP_MIN_S, end_s),
            unit="s",
            domain=(cropped[-1][0], 1.0),
            faded=cropped,
        ),
        frame_on_x=opened.seconds_per_frame,
        revision=opened.id,
    )
    st.caption(
        "Drag the handles or the bar between them: the prediction follows. Click to choose the frame. Every clip is "
        f"played {media.GAIN:g} times as loud as recorded. In training, crops for the type begin and end in the grey "
        "ranges."
    )


def controls(opened: OpenedRecording, *, crop_s: sound.Seconds | None, settled: bool) -> None:
    """The microphone, the player of the crop, and the way back to the whole recording."""
    left, middle, right = st.columns([5, 6, 4], vertical_alignment="bottom")
    channel = microphone_control(
        left,
        "Channel shown and played (does not change the prediction)",
        help_text="The prediction always uses all eight microphones.",
    )
    if settled:
        st.session_state[PLAYED] = crop_s
    middle.audio(sound.wav(opened, channel, st.session_state.get(PLAYED)))
    right.button(
        "Whole recording",
        icon=":material/undo:",
        disabled=crop_s is None,
        on_click=lambda: session.choose(crop_s=None),
        width="stretch",
    )


def _end_s(picture: SoundPicture) -> float:
    """The recording's end in hundredths of a second, at least the shortest crop."""
    return max(CROP_MIN_S, int(100 * picture.duration_s) / 100)
