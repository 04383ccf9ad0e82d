"""The built-in demo: synthetic recordings in the dataset's own layout, with their truth, and a detector for them."""

from pathlib import Path

DETECTOR_WEIGHTS = Path(__file__).parent / "weights" / "detector.safetensors"
"""The detector's weights; ``detector.md`` beside them is their card."""

MASS_WEIGHTS = Path(__file__).parent / "weights" / "mass.safetensors"
"""The mass network's weights; ``mass.md`` beside them is their card."""

FILLING_WEIGHTS = Path(__file__).parent / "weights" / "filling.safetensors"
"""The filling networks' weights; ``filling.md`` beside them is their card."""
