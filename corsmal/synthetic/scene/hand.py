"""Hands: fingers that follow a container's outline, so that they hide a part of it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from corsmal.geometry import Floats
from corsmal.synthetic.scene.containers import DemoContainer
from corsmal.synthetic.scene.limbs import Limb
from corsmal.synthetic.scene.looks import Colour

Outline = Callable[[float, float], tuple[Floats, Floats]]
"""From a length along a solid's outline (m, 0 at the palm, positive towards the fingers) and a height (m) to the point
of the surface and the normal there, both (3,) in the solid's frame."""

ANGLE_MAX_RAD = 2.5
# height above the grip, length along the outline, radius at the tip (m)
_FINGERS = ((0.029, 0.062, 0.0078), (0.0097, 0.07, 0.0082), (-0.0097, 0.066, 0.008), (-0.028, 0.052, 0.0072))
_KNUCKLE_M, _PALM_OUT_M, _WRIST_M = 0.0105, 0.026, 0.068
_ROW_LEAST_M = 0.008


@dataclass(frozen=True, eq=False)
class Grip:
    """How a hand takes something.

    Args:
        outline: of what is taken.
        height_m: height of the middle of the palm in its frame.
        base_m: (3,) its origin in the world.
        rotation: (3, 3) its frame to the world.
        opening_m: how far the fingers are from the surface.
        fingers: how many find room on it, 1 to 4, from the top.
    """

    outline: Outline
    height_m: float
    base_m: Floats
    rotation: Floats
    opening_m: float = 0.0
    fingers: int = 4

    def point(self, length_m: float, height_m: float, out_m: float) -> Floats:
        """A point of the world at a length along the outline, a height, and a distance from the surface."""
        surface, normal = self.outline(length_m, height_m)
        return self.base_m + self.rotation @ (surface + (out_m + self.opening_m) * normal)

    def outward(self) -> Floats:
        """The normal at the palm, (3,) in the world."""
        return self.rotation @ self.outline(0.0, self.height_m)[1]


def container_outline(container: DemoContainer, grip_deg: float) -> Outline:
    """The outline of a container, the palm being in the direction ``grip_deg`` from its axis."""
    if container.outer is None:
        return _box_outline(container.width_top_mm / 2000, container.depth_mm / 2000)
    heights, radii = container.outer.heights_mm / 1000, container.outer.radii_mm / 1000
    return round_outline(lambda height: float(np.interp(height, heights, radii)), grip_deg, turn=1)


def round_outline(radius_m: Callable[[float], float], grip_deg: float, *, turn: int) -> Outline:
    """The outline of a solid of revolution; ``turn`` is 1 where fingers go counter-clockwise, else -1."""
    start = np.radians(grip_deg)

    def outline(length_m: float, height_m: float) -> tuple[Floats, Floats]:
        radius = radius_m(height_m)
        # the joints lie outside the surface, where the same angle is a longer way
        angle = start + turn * np.clip(length_m / (radius + 0.009), -ANGLE_MAX_RAD, ANGLE_MAX_RAD)
        normal = np.array([np.cos(angle), np.sin(angle), 0.0])
        return radius * normal + np.array([0.0, 0.0, height_m]), normal

    return outline


def _box_outline(half_width_m: float, half_depth_m: float) -> Outline:
    def outline(length_m: float, height_m: float) -> tuple[Floats, Floats]:
        side, beyond = np.sign(length_m), abs(length_m) - half_depth_m
        if beyond <= 0:
            return np.array([half_width_m, length_m, height_m]), np.array([1.0, 0.0, 0.0])
        turned = min(beyond / 0.012, 1.0) * np.pi / 2
        point = np.array([half_width_m - beyond, side * half_depth_m, height_m])
        return point, np.array([np.cos(turned), side * np.sin(turned), 0.0])

    return outline


def hand_limbs(grip: Grip, skin: Colour) -> list[Limb]:
    """Fingers and a thumb around what is taken, and the palm."""
    limbs = []
    for rise, length, tip in _FINGERS[: grip.fingers]:
        height = max(grip.height_m + rise, _ROW_LEAST_M)
        joints = [
            grip.point(0.004, height, _KNUCKLE_M + 0.008),
            grip.point(0.45 * length, height + 0.001, _KNUCKLE_M),
            grip.point(0.75 * length, height - 0.001, 0.0095),
            grip.point(length, height - 0.003, 0.0075),
        ]
        radii = (0.0105, 0.0094, 0.0087, tip)
        limbs += [Limb(joints[k], joints[k + 1], radii[k], radii[k + 1], skin) for k in range(3)]
    height = grip.height_m + 0.012
    thumb = [
        grip.point(-0.004, height - 0.022, 0.024),
        grip.point(-0.026, height, 0.014),
        grip.point(-0.054, height + 0.012, 0.0095),
    ]
    limbs += [Limb(thumb[0], thumb[1], 0.0155, 0.012, skin), Limb(thumb[1], thumb[2], 0.012, 0.0095, skin)]
    upper = grip.point(0.0, max(grip.height_m + 0.024, 0.03), _PALM_OUT_M)
    lower = grip.point(-0.006, max(grip.height_m - 0.022, 0.02), _PALM_OUT_M)
    return [*limbs, Limb(upper, lower, 0.0165, 0.0175, skin)]


def wrist_m(grip: Grip, shoulder_m: Floats) -> Floats:
    """Where the wrist is, (3,) in the world: behind the palm, on the way to the shoulder."""
    palm = grip.point(-0.004, max(grip.height_m, 0.025), _PALM_OUT_M + 0.004)
    direction = 0.7 * grip.outward() + (shoulder_m - palm) / np.linalg.norm(shoulder_m - palm)
    return np.asarray(palm + _WRIST_M * direction / np.linalg.norm(direction))
