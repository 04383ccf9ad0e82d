"""Every number of the method, with named presets.

The numbers are those of the paper's Table 1 and section 3.1; where the paper is silent, the docstring says what was
chosen and why.
"""

from corsmal.parameters.presets import (
    SELECTION_PRESETS,
    SHAPE_PRESETS,
    FillingPreset,
    NetworkPreset,
    NetworkPresets,
    own_selection,
    selection_of,
)
from corsmal.parameters.selection import CENTRE_RULES, LADDER, CentreRule, SelectionParameters
from corsmal.parameters.shape import (
    WALL_MAX_MM,
    AngleRule,
    HeightRange,
    HeightReference,
    PixelRule,
    ShapeMethod,
    ShapeParameters,
)
from corsmal.parameters.views import (
    CONTAINER_CLASSES,
    FRONTAL_VIEW,
    METHOD_VIEWS,
    PAIRS,
    Pair,
    all_pairs,
    read_pair,
)

__all__ = [
    "CENTRE_RULES",
    "CONTAINER_CLASSES",
    "FRONTAL_VIEW",
    "LADDER",
    "METHOD_VIEWS",
    "PAIRS",
    "SELECTION_PRESETS",
    "SHAPE_PRESETS",
    "WALL_MAX_MM",
    "AngleRule",
    "CentreRule",
    "FillingPreset",
    "HeightRange",
    "HeightReference",
    "NetworkPreset",
    "NetworkPresets",
    "Pair",
    "PixelRule",
    "SelectionParameters",
    "ShapeMethod",
    "ShapeParameters",
    "all_pairs",
    "own_selection",
    "read_pair",
    "selection_of",
]
