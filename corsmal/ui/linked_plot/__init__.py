"""A Plotly figure that reports clicks, keys and range inputs while they move, and keeps its camera."""

from corsmal.ui.linked_plot.assets import plotly_route
from corsmal.ui.linked_plot.component import linked_plot, plot_event
from corsmal.ui.linked_plot.events import Click, PlotEvent, Shape, Slider, Span

__all__ = ["Click", "PlotEvent", "Shape", "Slider", "Span", "linked_plot", "plot_event", "plotly_route"]
