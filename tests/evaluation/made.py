"""Annotations and submissions made for tests."""

import numpy as np
import pandas as pd

CONTAINERS = {
    1: (98.0, 61.0, 119.0, 520.0, 10.0),
    4: (75.0, 56.0, 88.0, 300.0, 130.0),
    7: (193.0, 193.0, 241.0, 3209.4, 59.0),
}
"""Top width, bottom width, height, capacity and mass, by container id."""

FILLINGS = ((0, 0), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""Type and level."""

DENSITIES = (0.0, 0.34, 0.82, 1.0)
FRACTIONS = (0.0, 0.5, 0.9)

SCORED = {
    "Filling level": "filling level",
    "Filling type": "filling type",
    "Container capacity": "container capacity",
    "Width at the top": "width at the top",
    "Width at the bottom": "width at the bottom",
    "Height": "height",
    "Container mass": "container mass",
}
"""Scored columns of a submission, and the annotation file's columns."""


def made_annotation(recordings: int = 42) -> pd.DataFrame:
    """An annotation in the file's columns: every container with every filling in turn."""
    rows = []
    for number in range(recordings):
        container = list(CONTAINERS)[number % len(CONTAINERS)]
        filling_type, level = FILLINGS[(number // len(CONTAINERS)) % len(FILLINGS)]
        top, bottom, height, capacity, mass = CONTAINERS[container]
        rows.append(
            {
                "id": number,
                "container id": container,
                "width at the top": top,
                "width at the bottom": bottom,
                "height": height,
                "container capacity": capacity,
                "container mass": mass,
                "filling type": filling_type,
                "filling level": level,
                "filling density": DENSITIES[filling_type],
                "filling mass": FRACTIONS[level] * capacity * DENSITIES[filling_type],
            }
        )
    return pd.DataFrame(rows)


def perfect_submission(annotation: pd.DataFrame) -> pd.DataFrame:
    """The truth as a submission."""
    columns = {shown: annotation[name] for shown, name in SCORED.items()}
    return pd.DataFrame({"Configuration ID": annotation["id"], **columns})


def random_submission(annotation: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Numbers around the truth and far from it, zeros and gaps."""
    n = len(annotation)
    submission = perfect_submission(annotation).astype(float)
    submission["Filling type"] = rng.integers(-1, 4, n)
    submission["Filling level"] = rng.integers(-1, 3, n)
    for name in list(SCORED)[2:]:
        submission[name] *= rng.choice([0.0, 0.4, 0.9, 1.0, 1.1, 1.99, 2.0, 5.0], n)
        submission.loc[rng.random(n) < 0.2, name] = -1
    return submission


def perfect_estimates(annotation: pd.DataFrame) -> pd.DataFrame:
    """The truth as an estimates table."""
    n = len(annotation)
    types, levels = annotation["filling type"].to_numpy(), annotation["filling level"].to_numpy()
    columns = {
        "recording_id": [f"{number:06d}" for number in annotation["id"]],
        "status": ["fitted"] * n,
        "capacity_ml": annotation["container capacity"],
        "width_top_mm": annotation["width at the top"],
        "width_bottom_mm": annotation["width at the bottom"],
        "height_mm": annotation["height"],
        "container_mass_g": annotation["container mass"],
        "filling_type": types,
        "filling_level": levels,
        "filling_mass_g": annotation["filling mass"],
        "object_mass_g": annotation["filling mass"] + annotation["container mass"],
        **{f"type_p{number}": (types == number) * 1.0 for number in range(4)},
        **{f"level_p{number}": (levels == number) * 1.0 for number in range(3)},
        "best_frame": range(n),
        "pair": ["view3 + view1"] * n,
        "filling_held_out": [True] * n,
        "mass_held_out": [True] * n,
        "notes": [""] * n,
    }
    return pd.DataFrame(columns)
