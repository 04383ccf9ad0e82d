"""A hull as a closed triangle mesh, as a mesh file and as a table."""

from typing import Literal, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from corsmal.errors import ArgumentError, check_choice
from corsmal.shape.records import Dimensions, Hull
from corsmal.shape.sections import circumference_points

MeshFormat = Literal["obj", "ply", "stl"]
MESH_FORMATS: tuple[MeshFormat, ...] = get_args(MeshFormat)


def hull_mesh(hull: Hull, *, sides: int = 96) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Closed mesh of the frusta between a hull's converged circumferences, normals outwards.

    Returns:
        (n, 3) vertices in world millimetres, ``sides`` (3 or more) to a circumference, and (m, 3) triangles; both empty
        where fewer than two circumferences converged.
    """
    if sides < 3:
        raise ArgumentError(f"sides must be at least 3, got {sides}")
    rings = int(hull.converged.sum())
    if rings < 2 or hull.centroid_m is None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    around = 1000 * circumference_points(hull, points=sides)[hull.converged]
    walls, caps = around.reshape(-1, 3), around[[0, -1]].mean(axis=1)
    here = np.arange(sides)
    following = (here + 1) % sides
    lower = (np.arange(rings - 1) * sides)[:, None]
    quads = np.stack([lower + here, lower + following, lower + sides + following, lower + sides + here], axis=-1)
    quads = quads.reshape(-1, 4)
    base, rim = len(walls), len(walls) + 1
    last = (rings - 1) * sides
    faces = [
        quads[:, [0, 1, 2]],
        quads[:, [0, 2, 3]],
        np.column_stack([np.full(sides, base), following, here]),
        np.column_stack([np.full(sides, rim), last + here, last + following]),
    ]
    return np.vstack([walls, caps]), np.vstack(faces).astype(np.int64)


def export_mesh(hull: Hull, *, file_format: MeshFormat) -> bytes:
    """A hull as the bytes of a mesh file, in world millimetres.

    Raises:
        ArgumentError: the format is none of ``MESH_FORMATS``, or the hull has no two converged circumferences.
    """
    import trimesh  # noqa: PLC0415 - slow to import, needed for export only

    check_choice("file_format", file_format, MESH_FORMATS)
    vertices, faces = hull_mesh(hull)
    if len(faces) == 0:
        raise ArgumentError("the hull has fewer than two converged circumferences: there is no mesh to export")
    content = trimesh.Trimesh(vertices, faces, process=False).export(file_type=file_format)
    return content if isinstance(content, bytes) else str(content).encode()


def profile_table(hull: Hull, dimensions: Dimensions) -> pd.DataFrame:
    """The radii profile, a row per circumference from the lowest to the highest.

    Returns:
        Columns ``height_mm`` (world z), ``radius_mm``, ``converged``, ``kept`` (by smoothing) and ``end`` (``bottom``,
        ``top`` or empty).
    """
    ends = np.full(len(hull.heights_mm), "", dtype=object)
    for index, name in ((dimensions.bottom, "bottom"), (dimensions.top, "top")):
        if index is not None:
            ends[index] = name
    return pd.DataFrame(
        {
            "height_mm": hull.heights_mm,
            "radius_mm": hull.radii_mm,
            "converged": hull.converged,
            "kept": np.isin(np.arange(len(ends)), dimensions.kept),
            "end": ends,
        }
    )
