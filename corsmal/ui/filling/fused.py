"""A network of sound and sight on the Filling page: what each sense said, the gate over time, and the clip."""

import numpy as np
import pandas as pd
import streamlit as st

from corsmal.errors import CorsmalError
from corsmal.figures.senses import Moments, senses_figure
from corsmal.figures.sound import SoundPicture
from corsmal.filling import LEVEL_NAMES, FusedPrediction
from corsmal.filling.records import KINDS
from corsmal.parameters import METHOD_VIEWS
from corsmal.ui import session
from corsmal.ui.download_buttons import download_buttons
from corsmal.ui.filling import senses, sound
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.messages import guarded, plain
from corsmal.ui.opened import OpenedRecording

CLIP = "senses"
SHOWN = (0, 5, 10, 15)
"""Frames of a clip that are shown, of sixteen."""


def picture_or_note(opened: OpenedRecording) -> SoundPicture | None:
    """The sound to be drawn; None where there is none, which the network may do without."""
    try:
        return sound.picture(opened, session.choice().channel)
    except CorsmalError as error:
        st.caption(f":material/volume_off: {plain(str(error))}.")
        return None


def verdict(opened: OpenedRecording, prediction: FusedPrediction) -> None:
    """Which senses answered, and how much of the level is sight's."""
    if prediction.sound is not None and prediction.sight is not None:
        share = f"{100 * prediction.sight_share:.0f} %"
        st.caption(f":material/visibility: Level from both: {share} sight{_kind(prediction)}. Type from the sound.")
        return
    missing = "sight" if prediction.sight is None else "sound"
    there = "sound" if missing == "sight" else "sight"
    why = "; ".join(note for note in senses.given(opened).notes if str(opened.id) in note or "named" in note)
    reason = f": {plain(why)}" if why else " in this crop"
    st.info(f"**No {missing}**{reason}. Type and level are from {there} only.", icon=":material/info:")


def _kind(prediction: FusedPrediction) -> str:
    """What kind of container sight recognises, on which its share rests."""
    shares = prediction.kind_probabilities
    if shares is None:
        return ""
    best = int(shares.argmax())
    return f", which recognises a {KINDS[best]} ({100 * shares[best]:.0f} %)"


@st.fragment
@guarded()
def over_time(opened: OpenedRecording) -> None:
    """What each sense said while the recording went on, and the gate."""
    moments = senses.moments(opened)
    if not moments:
        return
    seen_s = opened.frames * (opened.seconds_per_frame or 0.0)
    figure = senses_figure.parts(moments, duration_s=max(seen_s, senses.given(opened).duration_s))
    linked_plot(
        figure,
        key=CLIP,
        label=f"Sound and sight of recording {opened.id} over time",
        height_px=figure["layout"]["height"],
        frame_on_x=opened.seconds_per_frame,
        revision=opened.id,
    )
    st.caption("Each moment: what the network says of the recording until then. Click to choose the frame.")
    table = lambda: moments_table(moments).to_csv(index=False).encode()  # noqa: E731
    download_buttons({"Download both senses over time (CSV)": (f"{opened.id}_senses.csv", table)})


@guarded()
def clip(opened: OpenedRecording, frame: int) -> None:
    """The sixteen frames around the shown one as the network sees them, of which a row of features is made."""
    from corsmal.filling.clips import square_seen  # noqa: PLC0415 - PyTorch takes seconds to import
    from corsmal.filling.sight import CLIP_FRAMES  # noqa: PLC0415 - as above

    sight = senses.given(opened).sight
    if sight is None:
        return
    first = min(frame // CLIP_FRAMES, sight.shape[1] - 1) * CLIP_FRAMES  # what is left at the end is in no clip
    rows = []
    for view in sorted(name for name in METHOD_VIEWS if name in opened.recording.views):
        last = opened.video(view).frame_count - 1
        rows.append(np.hstack([square_seen(opened.image(view, min(first + number, last))) for number in SHOWN]))
    if rows:
        st.image(np.vstack(rows))
    st.caption(
        f"**Clip** of frames {first}–{first + CLIP_FRAMES - 1}, of which each view has a row of features. Shown is the "
        "middle of the picture; with `--around-container`, R(2+1)D was shown the container's square."
    )


def moments_table(moments: Moments) -> pd.DataFrame:
    """A row per moment: seconds, the share of sight, and the level's probabilities from both and from each sense."""
    rows = []
    for time_s, each in moments:
        row: dict[str, float] = {"time_s": time_s, "sight_share": each.sight_share}
        for name, own in (("both", each), ("sound", each.sound), ("sight", each.sight)):
            shares = None if own is None else own.level_probabilities
            if shares is not None:
                row |= {f"{name}_{level}": float(share) for level, share in zip(LEVEL_NAMES, shares, strict=True)}
        rows.append(row)
    return pd.DataFrame(rows)
