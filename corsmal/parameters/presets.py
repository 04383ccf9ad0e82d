"""The named presets, and which of them belong together."""

from typing import Literal, Self, get_args

from corsmal.errors import check_choice
from corsmal.parameters.selection import SelectionParameters
from corsmal.parameters.shape import ShapeParameters

SHAPE_PRESETS = {
    "paper": ShapeParameters.paper(),
    "released": ShapeParameters.released(),
    "lode": ShapeParameters.lode(),
    "tuned": ShapeParameters.tuned(),
}

SELECTION_PRESETS = {"paper": SelectionParameters.paper(), "released": SelectionParameters.released()}

NetworkPreset = Literal["paper", "released", "tuned"]
"""Of a network and its training."""


FillingPreset = Literal["paper", "released", "tuned", "fused"]
"""Of the filling networks and their training; ``fused``: networks of sound and of sight."""


class NetworkPresets:
    """For settings that have a class method named after each ``NetworkPreset``."""

    @classmethod
    def of(cls, preset: NetworkPreset) -> Self:
        """The preset of a name.

        Raises:
            ArgumentError: there is no such preset.
        """
        check_choice("preset", preset, get_args(NetworkPreset))
        found: Self = getattr(cls, preset)()
        return found


def own_selection(shape_preset: str) -> str:
    """The preset of selection that belongs to a preset of the shape: that of its name, else the paper's."""
    return shape_preset if shape_preset in SELECTION_PRESETS else "paper"


def selection_of(shape: ShapeParameters) -> SelectionParameters:
    """The selection that belongs to parameters of the shape: that of the preset that they are, else the paper's."""
    name = next((name for name, preset in SHAPE_PRESETS.items() if preset == shape), "paper")
    return SELECTION_PRESETS[own_selection(name)]
