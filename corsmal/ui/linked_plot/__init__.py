"""A Plotly figure that reports clicks, keys and range inputs while they move, and keeps its camera."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
