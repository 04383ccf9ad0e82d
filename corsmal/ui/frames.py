"""Stepping through the frames of a recording."""

from contextlib import suppress
from math import isfinite

import streamlit as st

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.selection import BestFrame
from corsmal.ui import data
from corsmal.ui.linked_plot import PlotEvent
from corsmal.ui.recordings import detections_table
from corsmal.ui.shape.measures import guarded

STEPS = {"ArrowLeft": -1, "ArrowRight": 1, "PageUp": -10, "PageDown": 10}
KEYS = (*STEPS, "Home", "End")
RULES = {
    "both thirds": "the paper's: middle third of width and height",
    "horizontal third": "middle third of the width alone: nothing passed the paper's",
    "none": "none: nothing passed a stricter one",
}


def stepped(frame: int, event: PlotEvent, *, frames: int) -> int:
    """The frame after a click on a frame's score or a press of a key, within the video."""
    if event.click is not None and isinstance(event.click.x, int | float) and isfinite(event.click.x):
        frame = round(event.click.x)
    if event.key is not None:
        key, count = event.key
        frame = {"Home": 0, "End": frames - 1}.get(key, frame + STEPS.get(key, 0) * count)
    return min(max(frame, 0), frames - 1)


def longest_view(recording: Recording) -> int:
    """The number of frames of the longest readable view, at least 1; what cannot be read is said where it is shown."""
    counts = [1]
    for name in recording.views:
        with suppress(CorsmalError):
            counts.append(data.frame_count(recording, view=name))
    return max(counts)


def score_line(best: BestFrame, frame: int, *, frames: int) -> None:
    """Where the best frame is and by which rule, and what the frame that is looked at scores."""
    left, middle, right = st.columns(3)
    pair = " + ".join(best.pair)
    inspected = f"{len(best.scores)} of {frames} frames inspected"
    if best.score is None:
        left.error(f"{pair}: {best.reason}; {inspected}.", icon=":material/error:")
    else:
        left.metric(
            f"Best frame of {pair}",
            best.frame,
            f"score {best.score.total:,} px, {inspected}",
            delta_color="off",
            delta_arrow="off",
        )
    middle.metric("Centre rule", best.centre_rule, RULES[best.centre_rule], delta_color="off", delta_arrow="off")
    score = next((item for item in best.scores if item.frame == frame), None)
    if score is None or score.total is None:
        note = "not inspected in both views" if score is None else "no container in both views"
        right.metric(f"Frame {frame}", "no score", note, delta_color="off", delta_arrow="off")
    else:
        parts = " + ".join(f"N {pixels:,}" for pixels in score.mask_pixels)
        right.metric(
            f"Frame {frame}",
            f"{score.total:,} px",
            f"{parts} less {2 * sum(score.penalties):,} of penalties",
            delta_color="off",
            delta_arrow="off",
        )


def view_pictures(recording: Recording, *, frame: int, best: BestFrame) -> None:
    """The views side by side with their detections, and under each what was found and why it was dropped."""
    names = [name for name in ("view1", "view3", "view2") if name in recording.views]
    if not names:
        st.warning(f"Missing: {', '.join(recording.missing)}.", icon=":material/inventory_2:")
    found = data.detections(recording)
    for column, name in zip(st.columns(max(1, len(names))), names, strict=False):
        with column, guarded():
            star = " :material/star: best frame" if name in best.pair and frame == best.frame else ""
            st.markdown(f"**{name}**, frame {frame}{star}")
            picture = data.frame_picture(recording, view=name, frame=frame, centre_rule=best.centre_rule)
            st.image(picture, width="stretch")
            detections = found.views.get(name)
            if detections is None:
                st.caption("no detections")
            elif frame not in detections:
                st.caption("this frame was not inspected")
            elif len(detections[frame]) == 0:
                st.caption("nothing was detected in this frame")
            else:
                st.dataframe(
                    detections_table(detections[frame], centre_rule=best.centre_rule),
                    column_config={
                        "score": st.column_config.NumberColumn(format="%.2f"),
                        "verdict": st.column_config.TextColumn(width="medium"),
                    },
                )
