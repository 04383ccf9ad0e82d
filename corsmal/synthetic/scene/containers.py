"""The demo's fifteen containers: the dataset's nine with their annotated sizes, and six that training never shows."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Literal

from corsmal.errors import NotFoundError
from corsmal.synthetic.scene.profiles import Profile, Walls, cup, double_bowl, solved, stemmed, trumpet, tulip
from corsmal.synthetic.sound.events import Level

Kind = Literal["cup", "glass", "box"]
Colour = tuple[int, int, int]

CUP_LABEL, STEMMED_LABEL, BOX_LABEL = 47, 46, 84
"""COCO category numbers: cup, wine glass, book (the one that flat boxes are taken for)."""

ROUND_FILLINGS: tuple[tuple[int, Level], ...] = ((0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
BOX_FILLINGS = ROUND_FILLINGS[:5]
"""Pairs of filling type and level that can be."""

ANNOTATED_IDS = tuple(range(1, 10))
CONTAINER_IDS = tuple(range(1, 16))


@dataclass(frozen=True, eq=False)
class DemoContainer:
    """One container.

    Args:
        container_id: 1 to 15, as in the annotation.
        kind: cups and glasses are poured into, boxes are shaken.
        label: the COCO category number that a detector should give it.
        width_top_mm: outer, like the other sizes.
        depth_mm: of a box; -1 for what is round.
        capacity_ml: inner volume up to the brim.
        transparency: 0 transparent, 1 semi-transparent, 2 opaque.
        colour: RGB of the outside.
        outer: the outer wall; None for boxes, whose walls have no thickness.
        inner: the cavity; None for boxes.
        grip_mm: height at which a hand takes it.
    """

    container_id: int
    name: str
    kind: Kind
    label: int
    width_top_mm: float
    width_bottom_mm: float
    height_mm: float
    depth_mm: float
    capacity_ml: float
    mass_g: float
    transparency: Literal[0, 1, 2]
    colour: Colour
    outer: Profile | None
    inner: Profile | None
    grip_mm: float

    @property
    def is_round(self) -> bool:
        """Whether it is a solid of revolution."""
        return self.outer is not None

    @property
    def fillings(self) -> tuple[tuple[int, Level], ...]:
        """Pairs of filling type and level that it can hold."""
        return ROUND_FILLINGS if self.is_round else BOX_FILLINGS

    @property
    def radius_max_mm(self) -> float:
        """The largest distance of its surface from the vertical axis."""
        if self.outer is not None:
            return float(self.outer.radii_mm.max())
        return math.hypot(self.width_top_mm, self.depth_mm) / 2

    def fill_height_mm(self, fraction: float) -> float:
        """How high a share (0..1) of the capacity stands above the base."""
        if self.inner is None:
            return fraction * self.height_mm
        return self.inner.height_holding(fraction * self.capacity_ml)


@cache
def demo_container(container_id: int) -> DemoContainer:
    """The container of that number.

    Raises:
        NotFoundError: there is none.
    """
    if container_id in _BOXES:
        return _box(container_id)
    if container_id in _VESSELS:
        return _vessel(container_id)
    raise NotFoundError(f"there is no demo container {container_id!r}; there are 1 to {len(CONTAINER_IDS)}")


def _box(container_id: int) -> DemoContainer:
    name, (width, depth, height), mass, colour = _BOXES[container_id]
    capacity = round(width * depth * height / 1000, 3)
    sizes = (width, width, height, depth, capacity)
    return DemoContainer(container_id, name, "box", BOX_LABEL, *sizes, mass, 2, colour, None, None, 0.55 * height)


def _vessel(container_id: int) -> DemoContainer:
    name, kind, label, (top, bottom, height), capacity, mass, transparency, colour = _VESSELS[container_id]
    outer, inner = _walls(container_id, top, bottom, height, capacity)
    held = capacity if capacity is not None else round(inner.volume_ml, 3)
    grip = _GRIPS_MM.get(container_id, 0.5 * height)
    sizes = (top, bottom, height, -1.0, held)
    return DemoContainer(container_id, name, kind, label, *sizes, mass, transparency, colour, outer, inner, grip)


def _walls(container_id: int, top: float, bottom: float, height: float, capacity: float | None) -> Walls:
    """The walls with which the cavity holds the capacity; of a given shape where none is annotated."""
    if container_id in _STEMMED:
        bowl, start, wall, limits = _STEMMED[container_id]

        def shape(free: float) -> Walls:
            return stemmed(bowl(free, start_mm=start, height_mm=height, top_mm=top), foot_mm=bottom, wall_mm=wall)

    else:
        wall, floor, limits = _CUPS[container_id]

        def shape(free: float) -> Walls:
            return cup(free, top_mm=top, bottom_mm=bottom, height_mm=height, wall_mm=wall, floor_mm=floor)

    return shape(limits[0]) if capacity is None else solved(shape, capacity_ml=capacity, limits=limits)


_STEMMED = {
    5: (tulip, 58, 1.2, (81.0, 131.0)),
    6: (trumpet, 56, 1.0, (0.05, 1.5)),
    12: (trumpet, 84, 1.3, (0.9, 0.9)),
    13: (double_bowl, 66, 1.3, (56.0, 56.0)),
}
"""Family of the bowl, where it starts (mm), its wall (mm), and between which values its free number lies."""

_CUPS = {
    1: (0.8, 4.0, (0.3, 4.0)),
    2: (0.5, 1.2, (0.3, 4.0)),
    3: (0.5, 1.5, (0.3, 4.0)),
    4: (3.0, 7.0, (0.3, 4.0)),
    10: (0.8, 3.0, (1.0, 1.0)),
    11: (0.7, 2.0, (1.0, 1.0)),
}
"""Wall and floor of the cups (mm), and between which powers the shape of their wall lies."""

_GRIPS_MM = {5: 88.0, 6: 112.0, 12: 66.0, 13: 74.0, 10: 70.0}

_VESSELS: dict[
    int,
    tuple[str, Kind, int, tuple[float, float, float], float | None, float, Literal[0, 1, 2], Colour],
] = {
    1: ("red cup", "cup", CUP_LABEL, (98.0, 61.0, 119.0), 520.0, 10.0, 2, (196, 26, 34)),
    2: ("small white cup", "cup", CUP_LABEL, (69.0, 42.0, 72.0), 185.0, 2.0, 1, (236, 236, 232)),
    3: ("small transparent cup", "cup", CUP_LABEL, (69.0, 39.0, 85.0), 202.0, 3.0, 0, (232, 240, 242)),
    4: ("green glass", "glass", CUP_LABEL, (88.0, 56.0, 91.0), 296.0, 86.0, 0, (96, 190, 112)),
    5: ("wine glass", "glass", STEMMED_LABEL, (81.0, 67.0, 136.0), 363.0, 134.0, 0, (228, 236, 238)),
    6: ("champagne flute", "glass", STEMMED_LABEL, (49.0, 59.0, 175.0), 128.0, 15.0, 0, (226, 234, 238)),
    10: ("beer cup", "cup", CUP_LABEL, (95.0, 62.0, 148.0), None, 12.0, 0, (236, 238, 232)),
    11: ("medium white cup", "cup", CUP_LABEL, (80.0, 55.0, 96.0), None, 5.0, 2, (238, 238, 236)),
    12: ("cocktail glass", "glass", STEMMED_LABEL, (112.0, 74.0, 158.0), None, 172.0, 0, (226, 234, 238)),
    13: ("margarita glass", "glass", STEMMED_LABEL, (110.0, 72.0, 150.0), None, 205.0, 0, (224, 236, 234)),
}
_BOXES = {
    7: ("cereal box", (193.0, 69.0, 241.0), 59.0, (228, 176, 40)),
    8: ("biscuit box", (135.0, 56.0, 164.0), 31.0, (44, 84, 160)),
    9: ("tea box", (80.0, 45.0, 131.0), 15.0, (60, 128, 78)),
    14: ("fusilli box", (95.0, 60.0, 190.0), 24.0, (30, 62, 132)),
    15: ("spaghetti box", (72.0, 38.0, 262.0), 22.0, (26, 92, 150)),
}
