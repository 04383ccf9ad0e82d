"""Views that were pinned for the report: kept for the session, shown and removed on the Evaluation page."""

from collections.abc import Callable, Mapping

import pandas as pd
import streamlit as st

from corsmal.dataset import Recording
from corsmal.errors import CorsmalError
from corsmal.estimation import Fit
from corsmal.figures import hull_figure
from corsmal.figures.report import Pin, report_html
from corsmal.parameters import CentreRule
from corsmal.selection import Pair
from corsmal.ui import data
from corsmal.ui.shape.measures import plain, say_later, say_what_waits

KEY = "pins"


def pins() -> list[Pin]:
    """What this session has pinned, in order."""
    found: list[Pin] = st.session_state.setdefault(KEY, [])
    return found


def pin_button(label: str, make: Callable[[], Pin | list[Pin]], *, key: str) -> None:
    """A button that pins a view for the report.

    Args:
        label: what is pinned.
        make: called when the button is pressed; gives one view or several.
        key: of the button, one per place.
    """
    st.button(
        f"Pin {label}",
        key=f"pin_{key}",
        icon=":material/push_pin:",
        help="Goes into the report that the Evaluation page makes.",
        on_click=_pin,  # first of all, whatever else makes the page run again in the meantime
        args=(make,),
    )
    say_what_waits()


def pin_hull(recording: Recording, fit: Fit) -> None:
    """The button that pins a hull, which can be turned in the report."""
    if not fit.hull.ok:
        return
    title = f"Hull of {recording.id}, {' + '.join(fit.pair)}, frame {fit.frame}"
    pin_button(
        "the hull",
        lambda: Pin(title, hull_figure(fit.hull, fit.dimensions, cameras=data.cameras(recording))),
        key="hull",
    )


def pin_frames(recording: Recording, *, pair: Pair, frame: int, centre_rule: CentreRule) -> None:
    """The button that pins a frame of both views with their masks."""

    def pictures() -> list[Pin]:
        return [
            Pin(
                f"{recording.id}, {view}, frame {frame}",
                content=data.frame_picture(recording, view=view, frame=frame, centre_rule=centre_rule),
                medium="image/jpeg",
            )
            for view in pair
        ]

    pin_button("the pictures", pictures, key="frames")


def report_panel(
    title: str, tables: Mapping[str, pd.DataFrame], parameters: Mapping[str, object], *, banner: str
) -> None:
    """The pinned views, and the button that downloads the report.

    Args:
        title: of the report.
        tables: by heading.
        parameters: what the numbers were computed with.
        banner: sentence below the title.
    """
    if not pins():
        st.info(
            "Nothing is pinned yet: the pages have a *Pin* button under what they show.", icon=":material/push_pin:"
        )
    for index, pin in enumerate(pins()):
        left, right = st.columns([8, 1], vertical_alignment="center")
        left.markdown(f":material/push_pin: {plain(pin.title)}")
        right.button("Remove", key=f"unpin_{index}", on_click=_unpin, args=(index,), icon=":material/close:")
    chosen = list(pins())
    st.download_button(
        "Report as HTML",
        lambda: report_html(title, banner=banner, tables=tables, pins=chosen, parameters=parameters).encode(),
        "report.html",
        "text/html",
        icon=":material/download:",
        on_click="ignore",
    )


def _pin(make: Callable[[], Pin | list[Pin]]) -> None:
    try:
        made = make()
    except CorsmalError as error:
        say_later(plain(str(error)))
        return
    more = made if isinstance(made, list) else [made]
    pins().extend(more)
    say_later(f"Pinned: {plain('; '.join(pin.title for pin in more))}")


def _unpin(index: int) -> None:
    del pins()[index]
