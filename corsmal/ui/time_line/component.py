"""The component behind the time line.

As in a linked plot, the page owns the frame and the browser reports what the user does. Playing, stepping and dragging
run in the browser: it fetches the pictures, shows all views of a frame in one redraw, moves the cursors of linked plots
in the same one, and tells the server when the playhead comes to rest.
"""

from pathlib import Path
from typing import Any

import streamlit as st

from corsmal.dataset import Video
from corsmal.errors import CorsmalError
from corsmal.parameters import FRONTAL_VIEW
from corsmal.selection import BestFrame
from corsmal.ui import session
from corsmal.ui.detecting import inspect_frame, is_detecting, open_views
from corsmal.ui.folders import is_read_only
from corsmal.ui.linked_plot import PlotEvent, plot_event
from corsmal.ui.linked_plot.assets import read_asset
from corsmal.ui.linked_plot.component import acknowledged, no_callback
from corsmal.ui.messages import show_problem
from corsmal.ui.opened import OpenedRecording
from corsmal.ui.playback import Playback
from corsmal.ui.routes import playback_url
from corsmal.ui.time_line.marks import marks

TIME_LINE = "time_line"
STEP_KEYS = ("ArrowLeft", "ArrowRight")
ALL_KEYS = (*STEP_KEYS, "PageUp", "PageDown", "Home", "End")
"""One frame, ten frames, to the ends."""
PLAYED_BESIDE_SEARCH_PER_S = 10.0
"""Redraws per second while a search runs, which needs the cores; fewer where no graphics card draws."""
EMPTY = ":material/inventory_2:"
VIEWS = {"view1": "left of the robot", FRONTAL_VIEW: "frontal", "view2": "right of the robot"}

HERE = Path(__file__).parent

_component = st.components.v2.component(
    "corsmal.time_line",
    css=read_asset("time_line.css", folder=HERE),
    js=read_asset("reports.js")
    + "".join(read_asset(f"{name}.js", folder=HERE) for name in ("time_line", "pictures", "bar", "track", "player")),
    isolate_styles=False,
)


def time_line(
    opened: OpenedRecording,
    best: BestFrame,
    *,
    keys: tuple[str, ...] = STEP_KEYS,
    is_large: bool = False,
) -> int:
    """Show the time line, one on a page.

    Args:
        opened: the recording.
        best: where the star is, which frames were inspected, and by which rule detections are dropped.
        keys: keys that move the playhead wherever they are pressed on the page except in an input. On the time line
            itself all of ``ALL_KEYS`` do.
        is_large: whether the pictures are as wide as the page; else they are a strip beside the controls.

    Returns:
        The frame at which the playhead stands; at first the best one.
    """
    videos, problems = _videos(opened)
    frames = max((video.frame_count for video in videos.values()), default=1)
    event = plot_event(TIME_LINE)
    frame = _followed(event, best, frames=frames)
    if "inspect" in event.values and not is_read_only():
        inspect_frame(opened, _within(event.values["inspect"], frames))
        st.rerun()  # the page shows how far that is
    for problem in problems:
        show_problem(problem)
    if not videos:
        if not problems:
            st.info(f"There is nothing to play. Missing: {', '.join(opened.recording.missing)}.", icon=EMPTY)
        return frame
    playback = Playback(opened.recording, videos, opened.detections.views, best.centre_rule, opened.selection)
    url = playback_url(playback, (opened.key, best.centre_rule, opened.selection))
    channel = session.choice().channel
    _component(
        key=TIME_LINE,
        data={
            "label": f"Time line of recording {opened.id}",
            "recording": opened.key,
            "frame": frame,
            "frames": frames,
            "fps": opened.fps,
            "most_per_s": PLAYED_BESIDE_SEARCH_PER_S if is_detecting(opened) else None,
            "views": [_view(name, videos, best) for name in VIEWS if name in opened.recording.views],
            "url": url,
            "version": opened.detections.key,
            "sound": None
            if opened.recording.audio_path is None
            else f"{url}sound/{0 if channel is None else channel + 1}.wav",
            "is_large": is_large,
            "keys": list(keys),
            "can_inspect": not is_read_only() and bool(open_views(opened)),
            "acknowledged": acknowledged(TIME_LINE),
            **marks(best, crop_s=session.choice().crop_s, fps=opened.fps, frames=frames),
        },
        on_report_change=no_callback,
    )
    return frame


def _videos(opened: OpenedRecording) -> tuple[dict[str, Video], list[CorsmalError]]:
    """The views that can be read, and what is wrong with the others."""
    videos, problems = {}, []
    for name in VIEWS:
        if name in opened.recording.views:
            try:
                videos[name] = opened.video(name)
            except CorsmalError as error:
                problems.append(error)
    return videos, problems


def _view(name: str, videos: dict[str, Video], best: BestFrame) -> dict[str, Any]:
    frames = videos[name].frame_count if name in videos else 0
    return {"name": name, "title": VIEWS[name], "frames": frames, "is_of_pair": name in best.pair}


def _followed(event: PlotEvent, best: BestFrame, *, frames: int) -> int:
    """The frame after what the user did."""
    if "best" in event.values:
        session.choose(frame=None)
    elif "frame" in event.values:
        session.choose(frame=_within(event.values["frame"], frames))
    chosen = session.choice().frame
    return _within((best.frame or 0) if chosen is None else chosen, frames)


def _within(frame: float, frames: int) -> int:
    return int(min(max(frame, 0), frames - 1))
