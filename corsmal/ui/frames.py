"""The frames of a recording: their scores, and what was detected in one."""

import pandas as pd
import streamlit as st

from corsmal.detection import Detections, filter_detections
from corsmal.figures import score_figure
from corsmal.figures.overlay import class_name
from corsmal.figures.pins import Pin
from corsmal.parameters import SELECTION_PRESETS, CentreRule, SelectionParameters, own_selection
from corsmal.selection import BestFrame, frame_verdicts
from corsmal.ui import session
from corsmal.ui.amounts import measure
from corsmal.ui.linked_plot import linked_plot
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.time_line import VIEWS

RULES = {
    "both thirds": "the paper's: middle third of width and height",
    "horizontal third": "middle third of the width only: no frame passed the paper's",
    "none": "no rule: no frame passed a stricter one",
    "middle half": "the authors' program's: from one to three quarters of the width",
}

PASSED = {True: ("✓", "passed"), False: ("✗", "failed"), None: ("", "counted")}
"""A rule's verdict on a frame: its sign, and what stands behind it where the rule says nothing else."""


def selection_control() -> None:
    """Choose the preset of the rules for the best frame."""
    own = own_selection(session.choice().estimate_preset)
    st.session_state["selection_control"] = session.choice().selection_name
    st.segmented_control(
        "Rules for the best frame",
        list(SELECTION_PRESETS),
        key="selection_control",
        required=True,
        on_change=lambda: _selection_chosen(own),
        help="`paper`: equations 3 to 5 over every inspected frame. `released`: the authors' program, a frame per "
        "second, with its own container and score.",
    )


def _selection_chosen(own: str) -> None:
    name = st.session_state["selection_control"]
    session.choose(selection=None if name == own else name)


def score_plot(opened: OpenedRecording, best: BestFrame) -> None:
    """Every frame's score; a click goes to its frame."""
    linked_plot(
        score_figure.parts(best),
        key="scores",
        label=f"Scores of the frames of recording {opened.id}",
        frame_on_x=1,
        height_px=320,
        revision=opened.id,
    )
    st.caption("Click a frame, or step with ← → (one), Page Up and Page Down (ten), Home and End.")


def score_line(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """Where the best frame is and by which rule, and the score of the chosen frame."""
    left, middle, right = st.columns(3)
    pair = " + ".join(best.pair)
    inspected = f"{len(best.scores)} of {opened.frames} frames inspected"
    if best.is_fallback:
        measure(left, f"Best frame of {pair}", best.frame, "fallback: no frame passed the rules")
    elif best.score is None or best.score.total is None:
        left.info(f"{pair}: {best.reason}; {inspected}.", icon=":material/search_off:")
    else:
        measure(left, f"Best frame of {pair}", best.frame, f"score {best.score.total:,.0f} px, {inspected}")
    measure(middle, "Centre rule", best.centre_rule, RULES[best.centre_rule])
    score = next((item for item in best.scores if item.frame == frame), None)
    if score is None or score.total is None:
        obstacles = [] if score is None else sorted({each for each in score.obstacles if each})
        is_inspected = opened.is_inspected(best.pair, frame)
        absent = "not among the frames that count" if is_inspected else "not inspected in both views"
        note = ", ".join(obstacles) or (absent if score is None else "no container in both views")
        measure(right, f"Frame {frame}", "no score", note)
    else:
        parts = " + ".join(f"N {pixels or 0:,}" for pixels in score.mask_pixels)
        note = f"{parts} − penalties {score.total_penalty:,.0f}"
        measure(right, f"Frame {frame}", f"{score.total:,.0f} px", note)


def rules_table(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """What each rule says about the shown frame."""
    verdicts = frame_verdicts(opened.detections.views, best, frame, parameters=opened.selection, frames=opened.counted)
    rows = [
        {
            "rule": verdict.rule,
            "verdict": f"{PASSED[verdict.passed][0]} {verdict.of_pair or PASSED[verdict.passed][1]}".strip(),
            **dict(zip(best.pair, verdict.of_views or ("", ""), strict=True)),
        }
        for verdict in verdicts
    ]
    st.caption(f"Rules for the best frame, `{session.choice().selection_name}`: frame {frame}")
    st.dataframe(
        pd.DataFrame(rows),
        hide_index=True,
        height="content",
        column_config={name: st.column_config.TextColumn(width=140) for name in best.pair},
    )


def detections_tables(opened: OpenedRecording, best: BestFrame, frame: int) -> None:
    """What was found in the frame of each view, and why it was dropped."""
    names = [name for name in VIEWS if name in opened.recording.views]
    for column, name in zip(st.columns(max(1, len(names))), names, strict=False):
        with column:
            found = opened.detections.views.get(name)
            if found is None:
                st.caption(f"{name}: no detections")
            elif frame not in found:
                st.caption(f"{name}: frame {frame} was not inspected")
            elif len(found[frame]) == 0:
                st.caption(f"{name}: nothing was detected in frame {frame}")
            else:
                st.caption(f"{name}, frame {frame}: detections")
                st.dataframe(
                    detections_table(found[frame], centre_rule=best.centre_rule, parameters=opened.selection),
                    column_config={
                        "class": st.column_config.TextColumn(width=76),
                        "score": st.column_config.NumberColumn(format="%.2f", width=54),
                        "by place": st.column_config.NumberColumn(format="%.2f", width=66),
                        "verdict": st.column_config.TextColumn(width="medium"),
                    },
                )


def detections_table(
    detections: Detections, *, centre_rule: CentreRule, parameters: SelectionParameters | None = None
) -> pd.DataFrame:
    """The detections of one frame of one view: what each is, and why it was dropped; default: by the paper's rules."""
    parameters = parameters or SelectionParameters()
    filtered = filter_detections(detections, centre_rule=centre_rule, parameters=parameters)
    verdicts = [
        reason or ("the container" if index == filtered.container else "kept")
        for index, reason in enumerate(filtered.reasons)
    ]
    return pd.DataFrame(
        {
            "class": [class_name(int(label)) for label in detections.labels],
            "score": detections.scores,
            **({"by place": filtered.scores} if parameters.place_weights else {}),
            "verdict": verdicts,
            "mask (px)": detections.mask_areas,
        },
        index=pd.RangeIndex(1, len(detections) + 1, name="no."),
    )


def picture_pins(opened: OpenedRecording, best: BestFrame, frame: int) -> list[Pin]:
    """The frame of both views with their masks, to be pinned for a report."""
    score = next((item for item in best.scores if item.frame == frame), None)
    found = {view: opened.detections.views.get(view) for view in best.pair}
    numbers = {} if score is None or score.total is None else {"View Scores of the pair": f"{score.total:,.0f} px"}
    if best.score is not None and best.score.total is not None:
        numbers["Best frame"] = f"{best.frame}, {best.score.total:,.0f} px"
    return [
        Pin(
            f"{opened.id}, {view}, frame {frame}",
            content=opened.picture(view, frame, best.centre_rule),
            medium="image/jpeg",
            numbers=numbers,
            parameters={
                "pair of views": " + ".join(best.pair),
                "selection": session.choice().selection_name,
                "centre rule": best.centre_rule,
                "detections": "none" if detections is None else detections.source,
                "views matched": str(opened.recording.matching),
            },
            recording=opened.id,
            frame=frame,
        )
        for view, detections in found.items()
    ]
