"""The Mass page."""
