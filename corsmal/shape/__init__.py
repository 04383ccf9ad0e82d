"""The hull: a solid of revolution or a box fitted to masks, its measures and its mesh (paper 3.2)."""

from corsmal.shape.agreeing import fit_agreeing
from corsmal.shape.circumferences import fit_hull, on_mask
from corsmal.shape.exporting import MESH_FORMATS, export_mesh, hull_mesh, profile_table
from corsmal.shape.known_profile import KnownProfile
from corsmal.shape.measuring import capacity_ml, measure_hull
from corsmal.shape.records import Dimensions, Hull
from corsmal.shape.sections import Agreement, agreement, circumference_points, silhouettes
from corsmal.shape.wall import learn_wall_mm, learn_walls_of_others

__all__ = [
    "MESH_FORMATS",
    "Agreement",
    "Dimensions",
    "Hull",
    "KnownProfile",
    "agreement",
    "capacity_ml",
    "circumference_points",
    "export_mesh",
    "fit_agreeing",
    "fit_hull",
    "hull_mesh",
    "learn_wall_mm",
    "learn_walls_of_others",
    "measure_hull",
    "on_mask",
    "profile_table",
    "silhouettes",
]
