"""Physical properties of containers and fillings, from recordings of human-to-robot handovers."""

__version__ = "0.1.0"
