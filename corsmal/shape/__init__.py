"""The hull: a solid of revolution or a box fitted to masks, its measures and its mesh (paper 3.2)."""

from corsmal.shape.exporting import MESH_FORMATS, export_mesh, hull_mesh, profile_table
from corsmal.shape.fitting import fit_hull, on_mask
from corsmal.shape.measuring import measure_hull
from corsmal.shape.records import Dimensions, Hull
from corsmal.shape.sections import circumference_points, silhouettes

__all__ = [
    "MESH_FORMATS",
    "Dimensions",
    "Hull",
    "circumference_points",
    "export_mesh",
    "fit_hull",
    "hull_mesh",
    "measure_hull",
    "on_mask",
    "profile_table",
    "silhouettes",
]
