"""The built-in demo: synthetic recordings in the dataset's own layout, with their truth, and a detector for them."""

from pathlib import Path

DETECTOR_WEIGHTS = Path(__file__).parent / "weights" / "detector.safetensors"
"""The detector's weights; ``detector.md`` beside them is their card."""
