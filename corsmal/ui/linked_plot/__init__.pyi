from .assets import plotly_route as plotly_route
from .component import linked_plot as linked_plot
from .component import plot_event as plot_event
from .events import Click as Click
from .events import PlotEvent as PlotEvent
from .events import Slider as Slider
from .events import Span as Span
