"""The room that does not move: where its surfaces are."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Furniture:
    """Where the room's surfaces are, in metres.

    Args:
        wall_y_m: the wall behind the person.
        side_x_m: the wall at the person's left.
        floor_z_m: the floor.
        table_m: x from, x to, y from, y to, and height of the table's top.
        background: 0 a bare wall with a window sill, 1 a curtain and pictures.
        pictures_m: (x from, x to, z from, z to) on the wall behind.
        phase: shifts grain and folds.
    """

    wall_y_m: float
    side_x_m: float
    floor_z_m: float
    table_m: tuple[float, float, float, float, float]
    background: int
    pictures_m: tuple[tuple[float, float, float, float], ...]
    phase: float

    @classmethod
    def at_random(
        cls, rng: np.random.Generator, *, background: int, table_z_m: float, centre_x_m: float
    ) -> "Furniture":
        """Furniture much like in the real room."""
        middle = centre_x_m - rng.uniform(-0.03, 0.08)
        half = rng.uniform(0.36, 0.46)
        pictures = []
        for _ in range(int(rng.integers(1, 4)) if background else 0):
            x, z, width = centre_x_m + rng.uniform(-1.1, 1.3), rng.uniform(0.3, 0.75), rng.uniform(0.2, 0.45)
            pictures.append((x, x + width, z, z + width * rng.uniform(0.7, 1.4)))
        return cls(
            wall_y_m=rng.uniform(-1.0, -0.8),
            side_x_m=centre_x_m - rng.uniform(0.95, 1.25),
            floor_z_m=-0.74,
            table_m=(middle - half, middle + half, rng.uniform(-0.16, -0.1), 0.72, table_z_m),
            background=background,
            pictures_m=tuple(pictures),
            phase=float(rng.uniform(0, 10)),
        )
