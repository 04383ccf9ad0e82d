"""Records in, Plotly figures and annotated pictures out. Nothing here knows Streamlit."""

from corsmal.figures.hull import hull_figure
from corsmal.figures.overlay import draw_detections, jpeg
from corsmal.figures.profile import profile_figure
from corsmal.figures.reprojection import reprojection_figure
from corsmal.figures.scores import score_figure

__all__ = [
    "draw_detections",
    "hull_figure",
    "jpeg",
    "profile_figure",
    "reprojection_figure",
    "score_figure",
]
