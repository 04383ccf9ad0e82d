"""The component in which masks are drawn: what it is given, and what it reports."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import streamlit as st

from corsmal.detection.rle import mask_box
from corsmal.errors import CorsmalError
from corsmal.estimation import Fit
from corsmal.parameters import METHOD_VIEWS
from corsmal.quantities import BY_NAME, GEOMETRY
from corsmal.ui.amounts import amount
from corsmal.ui.folders import is_read_only
from corsmal.ui.linked_plot.assets import read_asset
from corsmal.ui.linked_plot.component import acknowledged, no_callback
from corsmal.ui.mask_editor.edited import EditedFrame
from corsmal.ui.mask_editor.fits import detected_outlines, hull_outlines, plain_runs
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.playback import Playback
from corsmal.ui.routes import playback_url
from corsmal.ui.time_line.component import VIEWS

EDITOR = "mask_editor"
HERE = Path(__file__).parent

_component = st.components.v2.component(
    "corsmal.mask_editor",
    css=read_asset("mask_editor.css", folder=HERE),
    js=read_asset("reports.js")
    + "".join(read_asset(f"{name}.js", folder=HERE) for name in ("mask_editor", "canvas", "tools", "editor_bar")),
    isolate_styles=False,
)


def editor_component(
    opened: OpenedRecording,
    frame: int,
    edited: Mapping[str, EditedFrame],
    *,
    active: str,
    fits: tuple[Fit, Fit],
    truth: Mapping[str, float],
    said: list[str],
) -> None:
    """Show the views of a frame with their masks, one of them to be edited.

    Args:
        opened: the recording with its detected masks.
        frame: of the recording.
        edited: the frame in all views, by view.
        active: the view that is edited.
        fits: with the detected masks, and with those by hand, whose hull's outline is drawn as a hint.
        truth: the annotated quantities.
        said: sentences below the pictures.
    """
    hull = hull_outlines(opened, fits[1])
    videos = {}
    for name in METHOD_VIEWS:
        try:
            videos[name] = opened.video(name)
        except CorsmalError as error:
            said = [*said, str(error)]
    url = playback_url(Playback(opened.recording, videos, {}, "none", opened.selection), (opened.key, EDITOR))
    shown = [name for name in VIEWS if name in videos]
    _component(
        key=EDITOR,
        data={
            "label": f"Masks by hand of recording {opened.id}, frame {frame}",
            "recording": opened.key,
            "frame": frame,
            "active": active,
            "is_read_only": is_read_only(),
            "said": said,
            "numbers": _numbers(fits, truth),
            "views": [_view(edited[name], url, hull.get(name, [])) for name in shown],
            "acknowledged": acknowledged(EDITOR),
        },
        on_report_change=no_callback,
    )


def _numbers(fits: tuple[Fit, Fit], truth: Mapping[str, float]) -> dict[str, Any]:
    """The quantities with the detected masks and with those by hand, beside the annotation."""
    rows = []
    for name in GEOMETRY:
        detected, hand = (getattr(fit.dimensions, name) for fit in fits)
        texts = ["–" if value is None else amount(name, value) for value in (detected, hand, truth.get(name))]
        rows.append([BY_NAME[name].label, *texts])
    return {"head": ["This frame", "Detected", "By hand", "Annotated"], "rows": rows}


def _view(edited: EditedFrame, url: str, hull: Any) -> dict[str, Any]:
    """One view as the browser shows it."""
    history, detected, shown = edited.history, edited.detected, edited.shown
    drawn, size = history.mask, shown.size
    box = mask_box(detected.counts, size) if detected is not None else None
    return {
        "name": edited.view,
        "title": VIEWS[edited.view],
        "url": f"{url}original/{edited.view}/{edited.frame}.jpg",
        "size": [size[1], size[0]],
        "source": _source(edited),
        "mask": plain_runs(shown.counts, size) if drawn is not None or detected is not None else None,
        "amodal": None if drawn is None or drawn.amodal is None else plain_runs(drawn.amodal, size),
        "detected": detected_outlines(detected.counts, size) if drawn is not None and detected is not None else [],
        "around": None if box is None else [box[0], box[1], box[0] + box[2], box[1] + box[3]],
        "hull": hull,
        "version": history.version,
        "can_undo": history.can_undo,
        "can_redo": history.can_redo,
        "is_by_hand": drawn is not None,
        "is_open": drawn is not None and not drawn.is_accepted,
    }


def _source(edited: EditedFrame) -> str:
    mask = edited.history.mask
    if mask is None:
        return "no mask" if edited.detected is None else "detected"
    if not mask.is_accepted:
        return "propagated, not accepted"
    return f"by hand, {mask.who}" if mask.who else "by hand"
