"""Limbs: cones with a sphere at each end, of which persons, hands, chairs and streams are made."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from corsmal.synthetic.scene.looks import Colour


@dataclass(frozen=True)
class Limb:
    """One limb.

    Args:
        start_m: (3,) centre of the first sphere.
        end_m: (3,) centre of the second.
        radius_start_m: of the first.
        radius_end_m: of the second.
        colour: RGB 0..255.
        flat: how thick it is in the direction ``flat_axis`` relative to the others; 1 is round.
        flat_axis: (3,) a direction across the limb.
        stripe: a second colour in rings along the limb; the same as ``colour`` where it is plain.
    """

    start_m: ArrayLike
    end_m: ArrayLike
    radius_start_m: float
    radius_end_m: float
    colour: Colour
    flat: float = 1.0
    flat_axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    stripe: Colour | None = None
