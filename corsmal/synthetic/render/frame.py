"""One frame of one view of a scene, with the truth about what is seen of the container."""

from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from corsmal.errors import ArgumentError, NotFoundError
from corsmal.geometry import Floats
from corsmal.synthetic.render.boxes import draw_box
from corsmal.synthetic.render.limbs import PackedLimbs, draw_limbs, pack_limbs
from corsmal.synthetic.render.room import Body, draw_room, draw_shadows
from corsmal.synthetic.render.shading import (
    Depth,
    Image,
    Mask,
    Rays,
    gleam,
    light_values,
    paint_filling,
    ray,
    solid_pose,
    surface_of_filling,
)
from corsmal.synthetic.render.tracing import profile_crossings
from corsmal.synthetic.render.vessels import FILLING_COLOURS, Vessel, draw_vessel
from corsmal.synthetic.scene.cameras import DEMO_SIZE
from corsmal.synthetic.scene.containers import demo_container
from corsmal.synthetic.scene.limbs import Limb
from corsmal.synthetic.scene.looks import Colour
from corsmal.synthetic.scene.motion import JUG_HEIGHT_M, JUG_RADIUS_M
from corsmal.synthetic.scene.person import chair_limbs, jug_handle, person_limbs
from corsmal.synthetic.scene.profiles import Profile
from corsmal.synthetic.scene.scene import Scene, make_scene

BLUR_SIGMA_PX, NOISE_SIGMA = 0.62, 1.8
_MARGIN_PX = 64
_INSIDE_WHITE: Colour = (240, 240, 236)
_RIDGES_M = {1: 0.0135, 2: 0.006, 11: 0.008}
_TINTS = {2: 0.78, 3: 0.14, 4: 0.42, 10: 0.16}
_STREAM_RADIUS_M = (0.0, 0.005, 0.002, 0.0035)


@dataclass(frozen=True, eq=False)
class FrameTruth:
    """A frame and its truth.

    Args:
        image: (H, W, 3) uint8 RGB.
        visible: (H, W) bool, the container's pixels that nothing hides.
        amodal: (H, W) bool, all pixels of its silhouette.
        jug: (H, W) bool, the pixels of the jug (without its handle) that nothing hides.
    """

    image: Image
    visible: Mask
    amodal: Mask
    jug: Mask


def render_frame(scene: Scene, view: str, frame: int, *, size: tuple[int, int] = DEMO_SIZE) -> FrameTruth:
    """Draw one frame, from 0, of one view, in an image of ``size`` (width, height) of the calibration's proportions.

    A pixel belongs to a mask when its centre's ray meets the drawn solid; colours are blurred and noisy, masks are not.

    Raises:
        NotFoundError: the scene has no such frame.
        ArgumentError: ``size`` has other proportions than 16 to 9.
    """
    if not 0 <= frame < scene.frames:
        raise NotFoundError(f"the scene has {scene.frames} frames (0 to {scene.frames - 1}), there is no frame {frame}")
    if min(size) < 16 or abs(size[0] * 9 - size[1] * 16) > 16:
        raise ArgumentError(f"size must be (width, height) in the proportions 16 to 9, got {size}")
    room, room_depth, is_table, rays = _room(scene, view, size)
    image, depth = room.copy(), room_depth.copy()
    table_z_m = scene.furniture.table_m[4]
    draw_shadows(image, is_table, _bodies(scene, frame), table_z_m=table_z_m, rays=rays, light=scene.light)
    draw_limbs(image, depth, _limbs(scene, frame), rays=rays, light=scene.light)
    light = light_values(scene.light)
    jug = np.zeros_like(is_table)
    if np.isfinite(scene.motion.jug_base_m[frame]).all():
        pose = {"base_m": scene.motion.jug_base_m[frame], "rotation": scene.motion.jug_rotation[frame]}
        jug, _ = draw_vessel(image, depth, _jug(scene.look.jug), **pose, rays=rays, light=light)
    visible, amodal = _draw_container(scene, frame, (image, depth), rays=rays, light=light)
    return FrameTruth(_photographed(image, scene, view, frame), visible, amodal, jug & ~visible)


def compile_kernels(first: Literal["vessels", "limbs"]) -> None:
    """Compile the slowest kernels of one kind by drawing something small; what both kinds need is compiled by one."""
    scene = make_scene(0, container=1)
    rays = Rays.of(scene.camera("view3", (32, 18)))
    picture = np.zeros((18, 32, 3), np.uint8), np.full((18, 32), np.inf, np.float32)
    light, point, profile = light_values(scene.light), (0.0, 0.0, 1.0), np.array([[0.0, 1.0], [1.0, 1.0]])
    pose = {"base_m": scene.motion.base_m[0], "rotation": scene.motion.rotation[0]}
    if first == "limbs":
        profile_crossings(point, point, profile, 1.0)
        draw_limbs(*picture, pack_limbs(chair_limbs(scene.look)), rays=rays, light=scene.light)
    else:
        shade = solid_pose(**pose, rays=rays), np.ones(14), light
        paint_filling(picture[0], (0, 0), point, gleam(point, point, shade[0], light, 1.0), shade)
        surface_of_filling(point, ray(shade[0], (0, 0)), profile)
        draw_vessel(*picture, _jug(scene.look.jug), **pose, rays=rays, light=light)


@lru_cache(maxsize=6)
def _room(scene: Scene, view: str, size: tuple[int, int]) -> tuple[Image, Depth, Mask, Rays]:
    rays = Rays.of(scene.camera(view, size))
    image, depth, is_table = draw_room(scene.furniture, scene.look, scene.light, rays)
    draw_limbs(image, depth, pack_limbs(chair_limbs(scene.look)), rays=rays, light=scene.light)
    for array in (image, depth, is_table):
        array.flags.writeable = False
    return image, depth, is_table, rays


@lru_cache(maxsize=512)
def _limbs(scene: Scene, frame: int) -> PackedLimbs:
    """All limbs of a frame, the same for its three views."""
    limbs = person_limbs(scene, frame)
    if np.isfinite(scene.motion.jug_base_m[frame]).all():
        limbs = limbs + jug_handle(scene, frame) + _stream(scene, frame)
    return pack_limbs(limbs)


def _bodies(scene: Scene, frame: int) -> list[Body]:
    """What throws a shadow on the table: the container, the hand and the jug."""
    bodies = [(scene.motion.base_m[frame], scene.container.radius_max_mm / 1000, 0.5)]
    if scene.motion.reach[frame] > 0.9:
        bodies.append((scene.motion.base_m[frame] + (0.06, -0.05, scene.container.grip_mm / 1000), 0.05, 0.3))
    if np.isfinite(scene.motion.jug_base_m[frame]).all():
        bodies.append((scene.motion.jug_base_m[frame], JUG_RADIUS_M, 0.5))
    return bodies


def _draw_container(
    scene: Scene, frame: int, picture: tuple[Image, Depth], *, rays: Rays, light: Floats
) -> tuple[Mask, Mask]:
    container = scene.container
    base, rotation = scene.motion.base_m[frame], scene.motion.rotation[frame]
    if container.outer is None or container.inner is None:
        return draw_box(*picture, container, base_m=base, rotation=rotation, rays=rays, light=light)
    permille = round(float(scene.motion.fill[frame]) * 1000)
    vessel = Vessel(
        outer=container.outer,
        inner=container.inner,
        colour=container.colour,
        inside=_INSIDE_WHITE,
        is_clear=container.transparency < 2,
        ridges_m=_RIDGES_M.get(container.container_id, 0.0),
        filling_type=scene.filling_type if permille else 0,
        fill_height_mm=_fill_height_mm(container.container_id, permille),
        tint=_TINTS.get(container.container_id, 0.1),
        veil=0.5 if container.transparency == 1 else 0.0,
    )
    return draw_vessel(*picture, vessel, base_m=base, rotation=rotation, rays=rays, light=light)


@lru_cache(maxsize=8192)
def _fill_height_mm(container_id: int, permille: int) -> float:
    return demo_container(container_id).fill_height_mm(permille / 1000)


@cache
def _jug(colour: Colour) -> Vessel:
    height, radius = JUG_HEIGHT_M * 1000, JUG_RADIUS_M * 1000
    heights = np.array([0.0, 0.06, 0.75, 1.0]) * height
    outer = Profile(heights, np.array([0.95, 1.0, 0.9, 1.0]) * radius)
    inner = Profile(heights + np.array([3.0, 0.5, 0, 0]), outer.radii_mm - 2)
    return Vessel(outer, inner, colour, colour, is_clear=False)


def _stream(scene: Scene, frame: int) -> list[Limb]:
    """What falls from the jug into the container: a jet of water, or grains."""
    motion, container = scene.motion, scene.container
    if not motion.stream[frame]:
        return []
    rng = np.random.default_rng([scene.seed, frame])
    lip = motion.jug_base_m[frame] + motion.jug_rotation[frame] @ np.array([JUG_RADIUS_M - 0.004, 0, JUG_HEIGHT_M])
    level = _fill_height_mm(container.container_id, round(float(motion.fill[frame]) * 1000)) / 1000
    end = motion.base_m[frame] + motion.rotation[frame] @ np.array([0, 0, level + 0.002])
    radius, colour = _STREAM_RADIUS_M[scene.filling_type], FILLING_COLOURS[scene.filling_type]
    if scene.filling_type == 3:
        middle = lip + (end - lip) * 0.4 + np.array([0.003, 0, 0.004])
        return [Limb(lip, middle, radius * 1.5, radius, colour), Limb(middle, end, radius, radius, colour)]
    count, length = (14, 0.014) if scene.filling_type == 1 else (46, 0.003)
    places = lip + (end - lip) * rng.random((count, 1)) + rng.normal(0, 0.0045, (count, 3)) * (1, 1, 0)
    ways = rng.normal(0, 1, (count, 3))
    ways *= length / np.linalg.norm(ways, axis=1, keepdims=True)
    return [Limb(place, place + way, radius, radius, colour) for place, way in zip(places, ways, strict=True)]


def _photographed(image: Image, scene: Scene, view: str, frame: int) -> Image:
    """The lens' blur and the sensor's noise."""
    height, width = image.shape[:2]
    blurred = cv2.GaussianBlur(image, (3, 3), BLUR_SIGMA_PX * max(width / DEMO_SIZE[0], 1.0))
    rng = np.random.default_rng([scene.seed, frame, int(view[-1])])
    row, column = rng.integers(_MARGIN_PX, size=2)
    brighter, darker = _noise((width, height))
    window = np.s_[row : row + height, column : column + width]
    return np.asarray(cv2.subtract(cv2.add(blurred, brighter[window]), darker[window]))


@lru_cache(maxsize=2)
def _noise(size: tuple[int, int]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Noise that is added and noise that is taken away, larger than the image so that frames take different parts."""
    shape = (size[1] + _MARGIN_PX, size[0] + _MARGIN_PX, 3)
    noise = np.round(np.random.default_rng(5).normal(0, NOISE_SIGMA, shape)).astype(np.int16)
    return np.clip(noise, 0, 255).astype(np.uint8), np.clip(-noise, 0, 255).astype(np.uint8)
