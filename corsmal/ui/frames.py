"""Stepping through the frames of a recording."""

from math import isfinite

import pandas as pd
import streamlit as st

from corsmal.detection import Detections, filter_detections
from corsmal.figures import score_figure
from corsmal.figures.overlay import class_name
from corsmal.figures.report import Pin
from corsmal.parameters import CentreRule
from corsmal.selection import BestFrame
from corsmal.ui.amounts import measure
from corsmal.ui.linked_plot import PlotEvent, linked_plot
from corsmal.ui.messages import guarded
from corsmal.ui.opened import OpenedRecording

STEPS = {"ArrowLeft": -1, "ArrowRight": 1, "PageUp": -10, "PageDown": 10}
KEYS = (*STEPS, "Home", "End")
RULES = {
    "both thirds": "the paper's: middle third of width and height",
    "horizontal third": "middle third of the width only: no frame passed the paper's",
    "none": "no rule: no frame passed a stricter one",
}


def stepped(frame: int, event: PlotEvent, *, frames: int) -> int:
    """The frame after a click on a frame's score or a press of a key, within the video."""
    if event.click is not None and isinstance(event.click.x, int | float) and isfinite(event.click.x):
        frame = round(event.click.x)
    if event.key is not None:
        key, count = event.key
        frame = {"Home": 0, "End": frames - 1}.get(key, frame + STEPS.get(key, 0) * count)
    return min(max(frame, 0), frames - 1)


def score_plot(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """Every frame's score; a click or a key goes to another frame, see ``stepped``."""
    linked_plot(
        score_figure.parts(best, frame=frame),
        key="scores",
        label=f"Scores of the frames of recording {opened.id}",
        keys=KEYS,
        height_px=320,
        revision=opened.id,
    )
    st.caption("Click a frame, or step with ← → (one), Page Up and Page Down (ten), Home and End.")


def score_line(best: BestFrame, frame: int, *, frames: int) -> None:
    """Where the best frame is and by which rule, and the score of the chosen frame."""
    left, middle, right = st.columns(3)
    pair = " + ".join(best.pair)
    inspected = f"{len(best.scores)} of {frames} frames inspected"
    if best.score is None:
        left.info(f"{pair}: {best.reason}; {inspected}.", icon=":material/search_off:")
    else:
        measure(left, f"Best frame of {pair}", best.frame, f"score {best.score.total:,} px, {inspected}")
    measure(middle, "Centre rule", best.centre_rule, RULES[best.centre_rule])
    score = next((item for item in best.scores if item.frame == frame), None)
    if score is None or score.total is None:
        note = "not inspected in both views" if score is None else "no container in both views"
        measure(right, f"Frame {frame}", "no score", note)
    else:
        parts = " + ".join(f"N {pixels:,}" for pixels in score.mask_pixels)
        note = f"{parts} − penalties {2 * sum(score.penalties):,}"
        measure(right, f"Frame {frame}", f"{score.total:,} px", note)


def view_pictures(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """The views side by side with their detections, and under each what was found and why it was dropped."""
    names = [name for name in ("view1", "view3", "view2") if name in opened.recording.views]
    if not names:
        st.warning(f"Missing: {', '.join(opened.recording.missing)}.", icon=":material/inventory_2:")
    for column, name in zip(st.columns(max(1, len(names))), names, strict=False):
        with column, guarded():
            star = " :material/star: best frame" if name in best.pair and frame == best.frame else ""
            st.markdown(f"**{name}**, frame {frame}{star}")
            st.image(opened.picture(name, frame, best.centre_rule), width="stretch")
            detections = opened.detections.views.get(name)
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


def detections_table(detections: Detections, *, centre_rule: CentreRule) -> pd.DataFrame:
    """The detections of one frame of one view: what each is, and why it was dropped."""
    filtered = filter_detections(detections, centre_rule=centre_rule)
    verdicts = [
        reason or ("the container" if index == filtered.container else "kept")
        for index, reason in enumerate(filtered.reasons)
    ]
    return pd.DataFrame(
        {
            "verdict": verdicts,
            "class": [class_name(int(label)) for label in detections.labels],
            "score": detections.scores,
            "mask (px)": detections.mask_areas,
        },
        index=pd.RangeIndex(1, len(detections) + 1, name="no."),
    )


def picture_pins(opened: OpenedRecording, best: BestFrame, frame: int) -> list[Pin]:
    """The frame of both views with their masks, to be pinned for a report."""
    return [
        Pin(
            f"{opened.id}, {view}, frame {frame}",
            content=opened.picture(view, frame, best.centre_rule),
            medium="image/jpeg",
        )
        for view in best.pair
    ]
