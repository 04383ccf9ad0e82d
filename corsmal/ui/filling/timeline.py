"""Pieces of the Filling page: the answer beside the truth, the controls, the timeline."""

from contextlib import suppress

import streamlit as st

from corsmal.dataset import Recording
from corsmal.dataset.audio import CHANNELS
from corsmal.errors import CorsmalError
from corsmal.figures import jpeg
from corsmal.figures.answer import Head, answer_figure
from corsmal.figures.sound import SoundPicture
from corsmal.figures.timeline import timeline_figure
from corsmal.filling import LEVEL_NAMES, TYPE_NAMES, FillingPrediction
from corsmal.parameters import PAIRS
from corsmal.ui import data, media, session
from corsmal.ui.filling import sound
from corsmal.ui.linked_plot import PlotEvent, Span, linked_plot
from corsmal.ui.shape.measures import plain
from corsmal.weights import find_weights

TIMELINE = "timeline"
STEP_S = 0.05
CROP_MIN_S = 0.25
"""Less than this is a click."""

FRONTAL = PAIRS[0][0]
FRAME_WIDTH_PX = 480

HEARD, CHANNEL = "heard_crop", "channel_control"
ALL = -1
HEADS: dict[Head, tuple[str, ...]] = {"type": TYPE_NAMES, "level": LEVEL_NAMES}
TRAINING = "`python -m corsmal train filling ROOT RUN`"


def weights_note(recording: Recording) -> None:
    """Say so where a network that learned from synthetic sound listens to a real one."""
    if find_weights("filling").is_bundled and not recording.is_synthetic:
        st.warning(
            "These weights learned from the **demo's synthetic sound** and have never heard a real recording: expect "
            f"wrong answers. Train on the real ones with {TRAINING}, then start the app with "
            "`CORSMAL_FILLING_WEIGHTS=RUN/filling.safetensors`.",
            icon=":material/science:",
        )


def predicted(recording: Recording, crop_s: sound.Seconds | None) -> FillingPrediction | None:
    """What the network says; None, with the reason on the page, where it can say nothing."""
    try:
        return sound.prediction(recording, crop_s=crop_s)
    except CorsmalError as error:
        st.error(f"No answer. {plain(str(error))}", icon=":material/error:")
        return None


def followed_crop(event: PlotEvent, picture: SoundPicture) -> sound.Seconds | None:
    """The chosen crop within the recording, after what the user dragged; None for the whole."""
    end_s = _end_s(picture)
    start_s, stop_s = session.choice().crop_s or (0.0, end_s)
    if start_s > end_s - CROP_MIN_S:
        st.warning(
            f"The crop from {start_s:.2f} to {stop_s:.2f} s was left out: the recording ends at {end_s:.2f} s.",
            icon=":material/content_cut:",
        )
        start_s, stop_s = 0.0, end_s
    dragged = dict(event.values)
    stop_s = min(max(dragged.get("crop_to", stop_s), CROP_MIN_S), end_s)
    start_s = dragged.get("crop_from", start_s)
    start_s = max(0.0, min(start_s, stop_s - CROP_MIN_S))
    crop_s = None if (start_s, stop_s) == (0.0, end_s) else (round(start_s, 2), round(stop_s, 2))
    if crop_s != session.choice().crop_s:
        session.choose(crop_s=crop_s, settled=event.settled)
    return crop_s


def followed_frame(event: PlotEvent, clock: tuple[int, float] | None) -> tuple[float, str] | None:
    """The moment of the chosen frame, s, and its name, after a click on the timeline; None where there is none."""
    if clock is None:
        return None
    frames, fps = clock
    if event.click is not None and isinstance(event.click.x, int | float):
        session.choose(frame=min(max(round(event.click.x * fps), 0), frames - 1))
    frame = session.choice().frame
    return None if frame is None else (frame / fps, f"frame {frame}")


def answer(recording: Recording, prediction: FillingPrediction, *, crop_s: sound.Seconds | None) -> None:
    """Type and level beside the truth, each with the probabilities and logits of its head."""
    truth = _truth(recording)
    whole = None if crop_s is None else sound.prediction(recording, crop_s=None)
    for head in HEADS:
        true = truth.get(head)
        _verdict(head, prediction, true)
        figure = answer_figure(prediction, head=head, whole=whole, true=true)
        linked_plot(
            figure,
            key=f"answer_{head}",
            label=f"Probabilities and logits of the {head}",
            height_px=figure.layout.height,
        )
    marks = "◆ annotated, in brackets: logits." + ("" if whole is None else " Grey mark: the whole recording.")
    st.caption(marks)


def frame_picture(recording: Recording, cursor: tuple[float, str] | None) -> None:
    """What the frontal view shows at the chosen moment."""
    frame = session.choice().frame
    if cursor is None or frame is None or FRONTAL not in recording.views:
        return
    with suppress(CorsmalError):  # the Frames page says what is wrong with a video
        st.image(jpeg(data.frame_image(recording, view=FRONTAL, frame=frame), width=FRAME_WIDTH_PX))
        st.caption(f"{FRONTAL}, {cursor[1]}, {cursor[0]:.2f} s")


def timeline(
    picture: SoundPicture,
    *,
    recording: Recording,
    prediction: FillingPrediction | None,
    crop_s: sound.Seconds | None,
    cursor: tuple[float, str] | None,
) -> None:
    """The sound, the attention and the sliding window on one axis, with the handles of the crop."""
    figure = timeline_figure(
        picture,
        channel=media.channel_name(session.choice().channel),
        prediction=prediction,
        windows=[] if prediction is None else sound.windows(recording),
        cursor=cursor,
    )
    end_s, cropped = _end_s(picture), figure.layout.meta["cropped"]
    linked_plot(
        figure,
        key=TIMELINE,
        label=f"Sound of recording {recording.id}",
        height_px=figure.layout.height,
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
        revision=recording.id,
    )
    st.caption(
        "Drag the handles or the bar between them: the answer follows. A click chooses the frame. Every clip is "
        f"played {media.GAIN:g} times as loud as it was recorded. In training, crops of the type pass begin and end "
        "in the grey ranges."
    )


def controls(recording: Recording, *, crop_s: sound.Seconds | None, settled: bool) -> None:
    """Which microphone, what is heard of it, and the way back to the whole recording."""
    left, middle, right = st.columns([4, 7, 4], vertical_alignment="bottom")
    channel = session.choice().channel
    st.session_state[CHANNEL] = ALL if channel is None else channel
    left.selectbox(
        "Draw and play",
        [ALL, *range(CHANNELS)],
        key=CHANNEL,
        format_func=lambda number: media.channel_name(None if number == ALL else number),
        on_change=_channel_chosen,
        help="The network always hears all eight microphones.",
    )
    if settled:
        st.session_state[HEARD] = crop_s
    middle.audio(sound.wav(recording, channel=channel, crop_s=st.session_state.get(HEARD)))
    right.button(
        "Whole recording",
        icon=":material/undo:",
        disabled=crop_s is None,
        on_click=lambda: session.choose(crop_s=None),
        width="stretch",
    )


def _channel_chosen() -> None:
    number = st.session_state[CHANNEL]
    session.choose(channel=None if number == ALL else number)


def _truth(recording: Recording) -> dict[str, str]:
    known = recording.annotation
    names = {"type": None, "level": None} if known is None else {"type": known.filling, "level": known.level}
    return {head: name for head, name in names.items() if name is not None}


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


def _end_s(picture: SoundPicture) -> float:
    """The recording's end in hundredths of a second, at least the shortest crop."""
    return max(CROP_MIN_S, int(100 * picture.duration_s) / 100)
