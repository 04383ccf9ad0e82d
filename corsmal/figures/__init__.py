"""Records in, Plotly figures and annotated pictures out. Nothing here knows Streamlit."""

from corsmal.figures.data import figure_data
from corsmal.figures.export import export_figure
from corsmal.figures.hull import hull_figure
from corsmal.figures.overlay import draw_detections, jpeg
from corsmal.figures.profile import profile_figure
from corsmal.figures.reprojection import reprojection_figure
from corsmal.figures.scores import score_figure

__all__ = [
    "draw_detections",
    "export_figure",
    "figure_data",
    "hull_figure",
    "jpeg",
    "profile_figure",
    "reprojection_figure",
    "score_figure",
]
