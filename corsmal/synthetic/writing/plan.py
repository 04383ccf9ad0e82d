"""Which recordings the demo has, and what its annotation says about them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from corsmal.dataset.annotation import DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.errors import ArgumentError
from corsmal.synthetic.scene.containers import CONTAINER_IDS, DemoContainer, demo_container
from corsmal.synthetic.scene.looks import DEMO_LOOKS
from corsmal.synthetic.scene.scene import BOX_FILLINGS, ROUND_FILLINGS, Scene, make_scene
from corsmal.synthetic.scene.timing import FILLING_NAMES
from corsmal.synthetic.sound.events import Level

_TYPES = {"cup": "cup", "glass": "drinking glass", "box": "food box"}
_SHARES = ("0%", "50%", "90%")


@dataclass(frozen=True)
class PlannedRecording:
    """One recording that is to be made.

    Args:
        recording_id: six digits.
        seed: of its scene.
        container_id: 1 to 15.
        scenario: 0 to 2.
        background: 0 or 1.
        illumination: 0 or 1.
        filling: type and level.
        look: number of its look.
    """

    recording_id: str
    seed: int
    container_id: int
    scenario: int
    background: int
    illumination: int
    filling: tuple[int, Level]
    look: int

    def scene(self) -> Scene:
        """The recording in full."""
        return make_scene(
            self.seed,
            container=self.container_id,
            scenario=self.scenario,
            background=self.background,
            illumination=self.illumination,
            filling=self.filling,
            look=self.look,
        )


def demo_plan(
    *, seed: int = 0, recordings_per_container: int = 2, containers: Sequence[int] = CONTAINER_IDS
) -> tuple[PlannedRecording, ...]:
    """The demo's recordings: every container in turn, then every container again.

    Scenarios, backgrounds, lights and looks take turns; a container's recordings have different fillings. The first
    recording is a short one, of something that is only handled, so that there is soon something to see.

    Args:
        seed: a whole number, not negative.
        recordings_per_container: at least 1.
        containers: numbers of the containers.

    Raises:
        ArgumentError: a number is out of its range.
        NotFoundError: there is no such container.
    """
    if seed < 0 or recordings_per_container < 1 or not containers:
        raise ArgumentError(
            "seed must not be negative, recordings_per_container must be at least 1 and containers not empty, "
            f"got {seed}, {recordings_per_container} and {tuple(containers)}"
        )
    rng = np.random.default_rng([seed, 11])
    shifts = {number: int(rng.integers(60)) for number in containers}
    looks = rng.permutation(len(DEMO_LOOKS))
    plan = []
    for index in range(recordings_per_container * len(containers)):
        turn, place = divmod(index, len(containers))
        number = containers[place]
        feasible = ROUND_FILLINGS if demo_container(number).is_round else BOX_FILLINGS
        step = 3 if len(feasible) == len(ROUND_FILLINGS) else 2
        plan.append(
            PlannedRecording(
                recording_id=f"{index:06d}",
                seed=int(np.random.SeedSequence([seed, index]).generate_state(1)[0]),
                container_id=number,
                scenario=0 if index == 0 else (place + turn) % 3,
                background=0 if index == 0 else (place // 3 + turn) % 2,
                illumination=0 if index == 0 else (place // 2 + turn) % 2,
                filling=(0, 0) if index == 0 else feasible[(shifts[number] + turn * step) % len(feasible)],
                look=int(looks[(place + 5 * turn) % len(looks)]),
            )
        )
    return tuple(plan)


def annotation_of(scenes: Iterable[tuple[str, Scene]]) -> dict[str, Any]:
    """The annotation of recordings, with the keys of the dataset's own.

    Args:
        scenes: ids and scenes.
    """
    return {
        "info": {"description": "Synthetic recordings in the layout of CORSMAL Containers Manipulation", "set": "demo"},
        "annotations": [_row(int(name), scene) for name, scene in scenes],
        "containers": [_described(demo_container(number)) for number in CONTAINER_IDS],
        "filling_type": [{"id": number, "name": name} for number, name in enumerate(FILLING_NAMES)],
        "filling_level": [
            {"id": number, "name": name, "percentage": share}
            for number, (name, share) in enumerate(zip(("empty", "half-full", "full"), _SHARES, strict=True))
        ],
        "views": [
            {"id": number, "name": name, "type": "fixed"}
            for number, name in enumerate(("left_side_view", "right_side_view", "robot_view"), start=1)
        ],
    }


def _row(number: int, scene: Scene) -> dict[str, float]:
    container, density = scene.container, DENSITIES_G_PER_ML[scene.filling_type]
    filling_mass = round(container.capacity_ml * LEVEL_FRACTIONS[scene.filling_level] * density)
    return {
        "id": number,
        "container id": container.container_id,
        "scenario": scene.scenario,
        "background": scene.background,
        "illumination": scene.illumination,
        "width at the top": container.width_top_mm,
        "width at the bottom": container.width_bottom_mm,
        "height": container.height_mm,
        "depth": container.depth_mm,
        "container capacity": container.capacity_ml,
        "container mass": container.mass_g,
        "filling type": scene.filling_type,
        "filling level": scene.filling_level,
        "filling density": density,
        "filling mass": float(filling_mass),
        "object mass": container.mass_g + filling_mass,
        "handover starting frame": round(scene.timing.handover_start_s * scene.fps),
        "handover start timestamp": -1,
        "handover hand": 1,
    }


def _described(container: DemoContainer) -> dict[str, Any]:
    return {
        "id": container.container_id,
        "name": container.name,
        "material": "cardboard" if container.kind == "box" else "plastic",
        "transparency": container.transparency,
        "type": _TYPES[container.kind],
    }
