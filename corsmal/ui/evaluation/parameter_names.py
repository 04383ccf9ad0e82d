"""The parameters of the fit as people read them."""

from corsmal.evaluation.exporting import heading
from corsmal.ui.controls import PARAMETERS, Number, Options

OTHERS = {"method": "Method", "frames": "Frames fitted"}
"""Those that no page changes."""


def parameter_label(name: str) -> str:
    """A field of ``ShapeParameters`` with its unit, for people."""
    parameter = PARAMETERS.get(name)
    if parameter is None:
        return OTHERS.get(name, heading(name))
    label = parameter.label if "_" in parameter.label else parameter.label[:1].upper() + parameter.label[1:]
    unit = parameter.unit if isinstance(parameter, Number) else ""
    return f"{label} ({unit})" if unit else label


def option_label(name: str, value: str) -> str:
    """A value of a field of ``ShapeParameters``, for people."""
    parameter = PARAMETERS.get(name)
    return parameter.options.get(value, value) if isinstance(parameter, Options) else value
