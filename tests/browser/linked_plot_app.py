"""A small app around the linked plot: a surface with a range input, and points that one can click."""

import numpy as np
import plotly.graph_objects as go
import streamlit as st

from corsmal.ui.linked_plot import Slider, linked_plot, plot_event, plotly_route


@st.fragment
def surface() -> None:
    state = st.session_state.setdefault("surface_state", {"height": 60.0, "runs": 0, "first": None})
    event = plot_event("surface")
    state.update(event.values)
    if event.values and state["first"] is None:
        state["first"] = event.settled
    state["runs"] += 1
    if st.button("Preset"):
        state["height"] = 100.0
    angles, heights = np.meshgrid(np.linspace(0, 2 * np.pi, 40), np.linspace(0, 1, 145))
    radii = 30 + state["height"] / 10 * np.sin(6 * heights)
    figure = go.Figure(
        go.Surface(x=radii * np.cos(angles), y=radii * np.sin(angles), z=heights * state["height"], showscale=False)
    )
    figure.update_layout(scene_aspectmode="data", margin={"l": 0, "r": 0, "t": 0, "b": 0})
    slider = Slider("height", "Height", min=20, max=140, step=1, value=state["height"], unit="mm")
    linked_plot(figure, key="surface", label="Surface", sliders=[slider], height_px=320)
    st.text(f"height {state['height']:g} first settled {state['first']} settled {event.settled}")


@st.fragment
def points() -> None:
    state = st.session_state.setdefault("points_state", {"index": 0, "clicks": 0})
    event = plot_event("points")
    if event.click:
        state["index"] = event.click.customdata
        state["clicks"] += 1
    numbers = np.arange(10)
    figure = go.Figure(go.Scatter(x=numbers, y=numbers**2, mode="markers", marker_size=20, customdata=7 * numbers))
    linked_plot(figure, key="points", label="Points", height_px=240)
    st.text(f"index {state['index']} clicks {state['clicks']}")


def main() -> None:
    st.session_state["app_runs"] = st.session_state.get("app_runs", 0) + 1
    surface()
    points()
    st.text(f"app runs {st.session_state['app_runs']}")
    st.text_input("Name", key="name")


if __name__ == "__main__":
    main()
else:
    app = st.App(__file__, routes=[plotly_route()])
