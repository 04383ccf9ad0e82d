"""The built-in demo: ready-made synthetic recordings with their truth and two runs, and networks for them."""

from corsmal.weights import bundled_path

FILLING_WEIGHTS = bundled_path("filling")
"""The demo's network for filling type and level, for scripts that name it."""
