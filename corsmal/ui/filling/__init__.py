"""The Filling page."""
