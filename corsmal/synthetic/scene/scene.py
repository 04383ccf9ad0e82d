"""One synthetic recording, described in full: what is drawn and what is heard follow from it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from corsmal.geometry import Camera
from corsmal.synthetic.scene.cameras import draw_cameras
from corsmal.synthetic.scene.containers import CONTAINER_IDS, DemoContainer, demo_container
from corsmal.synthetic.scene.furniture import Furniture
from corsmal.synthetic.scene.looks import DEMO_LIGHTS, DEMO_LOOKS, Light, Look, random_light, random_look
from corsmal.synthetic.scene.motion import CENTRE_X_M, Motion, draw_motion
from corsmal.synthetic.scene.timing import FILLING_NAMES, Timing, draw_timing
from corsmal.synthetic.sound.events import Level, Material, SoundEvents

FPS = 30
_TRAINING_STREAM = 7919
_DEMO_STREAM = 104_729


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything about one recording.

    Args:
        seed: what it was drawn from.
        scenario: 0 on the table, 1 held from the start, 2 brought in.
        background: 0 bare wall, 1 curtain and pictures.
        illumination: 0 from above, 1 from the side.
        filling_type: 0 to 3: none, pasta, rice, water.
        filling_level: 0 to 2: empty, half, full.
        cameras: by view, for images of 1280×720 pixels.
    """

    seed: int
    container: DemoContainer
    scenario: int
    background: int
    illumination: int
    filling_type: int
    filling_level: Level
    look: Look
    light: Light
    cameras: Mapping[str, Camera]
    furniture: Furniture
    timing: Timing
    motion: Motion

    @property
    def frames(self) -> int:
        """F, the number of frames."""
        return len(self.motion.fill)

    @property
    def duration_s(self) -> float:
        """Length of video and sound in seconds."""
        return self.frames / FPS

    def camera(self, view: str, size: tuple[int, int]) -> Camera:
        """A view's camera for images of ``size`` (width, height)."""
        return self.cameras[view].scaled(size)


def make_scene(
    seed: int,
    *,
    container: int,
    scenario: int | None = None,
    background: int | None = None,
    illumination: int | None = None,
    filling: tuple[int, Level] | None = None,
    look: int | None = None,
) -> Scene:
    """A scene of the demo, see ``Scene``; what is not given is drawn, and the same arguments give the same scene.

    Raises:
        NotFoundError: there is no such container.
    """
    rng = np.random.default_rng([_DEMO_STREAM, seed])
    chosen = demo_container(container)
    drawn = [int(rng.integers(high)) for high in (3, 2, 2, len(chosen.fillings), len(DEMO_LOOKS))]
    illumination = drawn[2] if illumination is None else illumination
    return _scene(
        seed,
        rng,
        chosen,
        chosen.fillings[drawn[3]] if filling is None else filling,
        scenario=drawn[0] if scenario is None else scenario,
        background=drawn[1] if background is None else background,
        illumination=illumination,
        look=DEMO_LOOKS[drawn[4] if look is None else look],
        light=DEMO_LIGHTS[illumination],
    )


def training_scene(
    seed: int, *, containers: Sequence[int] = CONTAINER_IDS, filling: tuple[int, Level] | None = None
) -> Scene:
    """A scene for training: everything at random, with looks, lights and cameras that the demo does not have.

    Args:
        seed: a whole number, not negative; no seed gives one of the demo's scenes.
        containers: one of these is drawn.
        filling: type and level, one of the ``fillings`` of each of them; default: drawn.
    """
    rng = np.random.default_rng([_TRAINING_STREAM, seed])
    chosen = demo_container(int(rng.choice(np.asarray(containers))))
    drawn = [int(rng.integers(high)) for high in (3, 2, 2, len(chosen.fillings))]
    return _scene(
        seed,
        rng,
        chosen,
        chosen.fillings[drawn[3]] if filling is None else filling,
        scenario=drawn[0],
        background=drawn[1],
        illumination=drawn[2],
        look=random_look(rng),
        light=random_light(rng),
        camera_spread=1.6,
    )


def sound_events(scene: Scene) -> SoundEvents:
    """What can be heard of a scene."""
    container, timing = scene.container, scene.timing
    material: Material = "cardboard" if container.kind == "box" else "glass" if container.mass_g > 50 else "plastic"
    inner_mm = container.width_top_mm if container.inner is None else 2 * float(container.inner.radii_mm[-1])
    contacts = [time for time in (timing.grasp_s, timing.lift_s) if 0 < time <= scene.duration_s]
    return SoundEvents(
        material=material,
        capacity_ml=container.capacity_ml,
        height_mm=container.height_mm,
        opening_mm=inner_mm,
        filling=FILLING_NAMES[scene.filling_type],
        level=scene.filling_level,
        duration_s=scene.duration_s,
        action=timing.action,
        start_s=timing.action_start_s,
        end_s=min(timing.action_end_s, scene.duration_s),
        source_path_m=scene.motion.base_m,
        contacts_s=tuple(contacts),
        times_s=np.arange(scene.frames) / FPS,
    )


def _scene(
    seed: int,
    rng: np.random.Generator,
    container: DemoContainer,
    filling: tuple[int, Level],
    *,
    camera_spread: float = 1.0,
    **chosen: Any,
) -> Scene:
    """Draw what is left of a scene: all but its container, its filling and what is ``chosen``."""
    scenario, (filling_type, filling_level) = chosen["scenario"], filling
    cameras = draw_cameras(rng, spread=camera_spread)
    table_z_m = float(rng.uniform(-0.03, 0.0))
    timing = draw_timing(container, scenario=scenario, filling_type=filling_type, filling_level=filling_level, rng=rng)
    motion = draw_motion(
        container,
        timing,
        scenario=scenario,
        filling_level=filling_level,
        table_z_m=table_z_m,
        times_s=np.arange(round(timing.end_s * FPS)) / FPS,
        rng=rng,
    )
    return Scene(
        seed=seed,
        container=container,
        filling_type=filling_type,
        filling_level=filling_level,
        cameras=cameras,
        furniture=Furniture.at_random(rng, background=chosen["background"], table_z_m=table_z_m, centre_x_m=CENTRE_X_M),
        timing=timing,
        motion=motion,
        **chosen,
    )
