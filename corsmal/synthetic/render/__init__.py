"""Frames of a synthetic scene, with the truth about what is seen of the container."""
