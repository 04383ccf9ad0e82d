"""Which recordings a synthetic dataset has, and what its annotation says about them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from corsmal.dataset.annotation import DENSITIES_G_PER_ML, LEVEL_FRACTIONS
from corsmal.dataset.annotation_file import SYNTHETIC
from corsmal.errors import ArgumentError
from corsmal.synthetic.scene.containers import ANNOTATED_IDS, CONTAINER_IDS, DemoContainer, demo_container
from corsmal.synthetic.scene.looks import DEMO_LOOKS
from corsmal.synthetic.scene.scene import FPS, Scene, make_scene, training_scene
from corsmal.synthetic.scene.timing import FILLING_NAMES
from corsmal.synthetic.sound.events import Level

_TYPES = {"cup": "cup", "glass": "drinking glass", "box": "food box"}
_SHARES = ("0%", "50%", "90%")


@dataclass(frozen=True)
class PlannedRecording:
    """One recording that is to be made.

    Args:
        seed: of its scene.
        container_id: 1 to 15.
        filling: type and level.
        scenario: 0 to 2; None, like what follows, in a recording to train on, where the seed decides.
    """

    recording_id: str
    seed: int
    container_id: int
    filling: tuple[int, Level]
    scenario: int | None = None
    background: int | None = None
    illumination: int | None = None
    look: int | None = None

    def scene(self) -> Scene:
        """The recording in full."""
        if self.look is None:
            return training_scene(self.seed, containers=[self.container_id], filling=self.filling)
        return make_scene(
            self.seed,
            container=self.container_id,
            scenario=self.scenario,
            background=self.background,
            illumination=self.illumination,
            filling=self.filling,
            look=self.look,
        )

    def annotation(self, *, frame_step: int = 1) -> dict[str, float]:
        """Its row of the annotation, when every ``frame_step``-th frame is kept."""
        scene = self.scene()
        container, density = scene.container, DENSITIES_G_PER_ML[scene.filling_type]
        filling_mass = round(container.capacity_ml * LEVEL_FRACTIONS[scene.filling_level] * density)
        return {
            "id": int(self.recording_id),
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
            "handover starting frame": round(scene.timing.handover_start_s * FPS / frame_step),
            "handover start timestamp": -1,
            "handover hand": 1,
        }


def plan_recordings(
    *,
    seed: int = 0,
    recordings_per_container: int = 2,
    containers: Sequence[int] | None = None,
    training: bool = False,
) -> tuple[PlannedRecording, ...]:
    """A dataset's recordings: every container in turn, then every container again; arguments as in ``write_demo``.

    A container's recordings take turns with its fillings; in the demo also scenarios, backgrounds, lights and looks
    take turns. The demo's first recording is a short one, of something that is only handled, so that there is soon
    something to see.

    Raises:
        ArgumentError: a number is out of its range.
        NotFoundError: there is no such container.
    """
    if containers is None:
        containers = ANNOTATED_IDS if training else CONTAINER_IDS
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
        feasible = demo_container(number).fillings
        step = 3 if demo_container(number).is_round else 2
        filling = feasible[(shifts[number] + turn * step) % len(feasible)]
        name, drawn = f"{index:06d}", int(np.random.SeedSequence([seed, index]).generate_state(1)[0])
        look = int(looks[(place + 5 * turn) % len(looks)])
        if training:
            plan.append(PlannedRecording(name, drawn, number, filling))
        elif index == 0:
            plan.append(PlannedRecording(name, drawn, number, (0, 0), 0, 0, 0, look))
        else:
            turns = (place + turn) % 3, (place // 3 + turn) % 2, (place // 2 + turn) % 2
            plan.append(PlannedRecording(name, drawn, number, filling, *turns, look))
    return tuple(plan)


def annotation_of(rows: Sequence[dict[str, float]]) -> dict[str, Any]:
    """The annotation of recordings, with the dataset's own keys, from rows of ``PlannedRecording.annotation``."""
    return {
        "info": {"description": f"{SYNTHETIC} in the layout of CORSMAL Containers Manipulation", "set": "demo"},
        "annotations": list(rows),
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


def _described(container: DemoContainer) -> dict[str, Any]:
    return {
        "id": container.container_id,
        "name": container.name,
        "material": "cardboard" if container.kind == "box" else "plastic",
        "transparency": container.transparency,
        "type": _TYPES[container.kind],
    }
