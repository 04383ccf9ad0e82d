"""The person: body, head and arms, made of limbs that follow the hands."""

import numpy as np

from corsmal.geometry import Floats
from corsmal.synthetic.scene.hand import Grip, container_outline, hand_limbs, round_outline, wrist_m
from corsmal.synthetic.scene.limbs import Limb
from corsmal.synthetic.scene.looks import Colour, Look
from corsmal.synthetic.scene.motion import CENTRE_X_M, JUG_HEIGHT_M, JUG_RADIUS_M
from corsmal.synthetic.scene.scene import Scene

SEAT_Y_M = -0.37
UPPER_ARM_M, FOREARM_M = 0.29, 0.26
_TROUSERS: Colour = (46, 48, 58)
_HANDLE_M = np.array([-JUG_RADIUS_M - 0.034, 0.0, 0.0])
_OPENING_M = 0.024
_SMALL_MM = 90.0


def person_limbs(scene: Scene, frame: int) -> list[Limb]:
    """The person in one frame, both hands included."""
    motion, look = scene.motion, scene.look
    origin = np.array([CENTRE_X_M, SEAT_Y_M, 0.0]) + motion.body_m[frame]
    right, left = right_grip(scene, frame), left_grip(scene, frame)
    lean = _lean(origin, [right, left])
    limbs = _body(origin, lean, look) + _head(origin + lean, look)
    for grip, side in ((right, 1.0), (left, -1.0)):
        shoulder = origin + lean + np.array([0.175 * side, 0.0, 0.27])
        limbs += _arm(grip, shoulder, side, look)
        limbs += hand_limbs(grip, look.skin)
    return limbs


def chair_limbs(look: Look) -> list[Limb]:
    """The chair, which stays where it is."""
    x, y = CENTRE_X_M, SEAT_Y_M - 0.16
    limbs = [Limb((x - 0.13, y, 0.1), (x + 0.13, y, 0.1), 0.11, 0.11, look.chair, flat=0.3)]
    for side in (-0.27, 0.27):
        limbs.append(Limb((x + side, y + 0.05, 0.01), (x + side, y + 0.3, 0.02), 0.02, 0.024, look.chair))
        limbs.append(Limb((x + side, y + 0.12, 0.0), (x + side, y + 0.08, -0.3), 0.017, 0.02, look.chair))
    return limbs


def right_grip(scene: Scene, frame: int) -> Grip:
    """The hand that takes the container, or is on its way to it."""
    motion, container = scene.motion, scene.container
    reach, height = motion.reach[frame], container.grip_mm / 1000
    rest = np.array([CENTRE_X_M + 0.26, -0.07, scene.furniture.table_m[4] + 0.042 - height]) + motion.body_m[frame]
    return Grip(
        outline=container_outline(container, motion.grip_deg),
        height_m=height,
        base_m=rest + (motion.base_m[frame] - rest) * reach,
        rotation=_without_yaw(motion.rotation[frame], scene),
        opening_m=_OPENING_M * motion.opening[frame],
        fingers=3 if container.height_mm < _SMALL_MM else 4,
    )


def left_grip(scene: Scene, frame: int) -> Grip:
    """The hand at the jug's handle, or at rest."""
    motion = scene.motion
    reach = motion.jug_reach[frame]
    rest = np.array([CENTRE_X_M - 0.27, -0.08, scene.furniture.table_m[4] + 0.045 - 0.55 * JUG_HEIGHT_M])
    rest = rest + motion.body_m[frame]
    base, rotation = rest, np.eye(3)
    if reach > 0:
        handle = motion.jug_base_m[frame] + motion.jug_rotation[frame] @ _HANDLE_M
        base, rotation = rest + (handle - rest) * reach, motion.jug_rotation[frame]
    outline = round_outline(lambda _height: 0.011, 200.0, turn=-1)
    return Grip(outline=outline, height_m=0.55 * JUG_HEIGHT_M, base_m=base, rotation=rotation)


def jug_handle(scene: Scene, frame: int) -> list[Limb]:
    """The jug's handle."""
    base, rotation = scene.motion.jug_base_m[frame], scene.motion.jug_rotation[frame]
    local = np.array(
        [
            [-JUG_RADIUS_M, 0, 0.88 * JUG_HEIGHT_M],
            [-JUG_RADIUS_M - 0.034, 0, 0.84 * JUG_HEIGHT_M],
            [-JUG_RADIUS_M - 0.034, 0, 0.32 * JUG_HEIGHT_M],
            [-JUG_RADIUS_M, 0, 0.22 * JUG_HEIGHT_M],
        ]
    )
    points = base + local @ rotation.T
    return [Limb(points[k], points[k + 1], 0.008, 0.008, scene.look.jug) for k in range(3)]


def _without_yaw(rotation: Floats, scene: Scene) -> Floats:
    """A round container may be turned in the hand; the hand stays where it is."""
    if not scene.container.is_round:
        return rotation
    up = rotation[:, 2]
    x = np.array([1.0, 0.0, 0.0]) - up[0] * up
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(up, x), up])


def _lean(origin: Floats, grips: list[Grip]) -> Floats:
    """How far the upper body leans so that both arms are long enough."""
    lean = np.zeros(3)
    for grip, side in zip(grips, (1.0, -1.0), strict=True):
        shoulder = origin + np.array([0.175 * side, 0.0, 0.27])
        way = wrist_m(grip, shoulder) - shoulder
        surplus = np.linalg.norm(way) - 0.96 * (UPPER_ARM_M + FOREARM_M)
        if surplus > 0:
            lean = lean + way / np.linalg.norm(way) * surplus
    lean[2] = np.clip(lean[2], -0.08, 0.02)
    return lean


def _body(origin: Floats, lean: Floats, look: Look) -> list[Limb]:
    upper = origin + lean
    hips, chest = _moved(origin, 0, 0, -0.1), _moved(upper, 0, 0, 0.17)
    left, right = _moved(upper, -0.135, 0, 0.262), _moved(upper, 0.135, 0, 0.262)
    stripe = look.stripe
    torso = [
        Limb(hips, chest, 0.15, 0.165, look.shirt, flat=0.62, stripe=stripe),
        Limb(left, right, 0.058, 0.058, look.shirt, stripe=stripe),
        Limb(chest, _moved(chest, 0, -0.01, 0.07), 0.165, 0.11, look.shirt, flat=0.6, stripe=stripe),
    ]
    legs = [
        Limb(_moved(hips, side, 0, -0.05), _moved(hips, side, 0.02, -0.62), 0.09, 0.06, _TROUSERS)
        for side in (-0.085, 0.085)
    ]
    return torso + legs


def _moved(point: Floats, x: float, y: float, z: float) -> Floats:
    return np.asarray(point + np.array([x, y, z]))


def _head(origin: Floats, look: Look) -> list[Limb]:
    def at(x: float, y: float, z: float) -> Floats:
        return _moved(origin, x, y + 0.01, z)

    dark = (42, 32, 32)
    lips = (int(look.skin[0] * 0.8), int(look.skin[1] * 0.55), int(look.skin[2] * 0.55))
    face = [
        Limb(at(0, -0.01, 0.27), at(0, 0.0, 0.41), 0.052, 0.047, look.skin),
        Limb(at(0, 0.014, 0.43), at(0, 0.004, 0.492), 0.066, 0.078, look.skin, flat=0.86, flat_axis=(1, 0, 0)),
        Limb(at(0, -0.016, 0.515), at(0, -0.034, 0.47), 0.082, 0.078, look.hair, flat=0.9, flat_axis=(1, 0, 0)),
        Limb(at(0, 0.079, 0.472), at(0, 0.088, 0.448), 0.007, 0.0105, look.skin),
        Limb(at(-0.018, 0.0735, 0.417), at(0.018, 0.0735, 0.417), 0.0055, 0.0055, lips),
    ]
    for side in (-1.0, 1.0):
        face.append(Limb(at(0.029 * side, 0.071, 0.474), at(0.029 * side, 0.071, 0.474), 0.0085, 0.0085, dark))
        face.append(Limb(at(0.017 * side, 0.074, 0.491), at(0.042 * side, 0.066, 0.491), 0.0045, 0.0045, look.hair))
        face.append(Limb(at(0.068 * side, -0.005, 0.47), at(0.067 * side, -0.002, 0.45), 0.015, 0.011, look.skin))
    return face


def _arm(grip: Grip, shoulder: Floats, side: float, look: Look) -> list[Limb]:
    """Upper arm and forearm from the shoulder to the wrist, the elbow down and outwards."""
    wrist = wrist_m(grip, shoulder)
    way = wrist - shoulder
    distance = float(np.clip(np.linalg.norm(way), 0.08, 0.995 * (UPPER_ARM_M + FOREARM_M)))
    along = way / np.linalg.norm(way)
    near = (UPPER_ARM_M**2 - FOREARM_M**2 + distance**2) / (2 * distance)
    outwards = np.array([0.5 * side, -0.25, -1.0])
    outwards -= along * (outwards @ along)
    bulge = np.sqrt(max(UPPER_ARM_M**2 - near**2, 0.0))
    elbow = shoulder + near * along + bulge * outwards / np.linalg.norm(outwards)
    sleeve = look.shirt if look.is_long_sleeved else look.skin
    palm = grip.point(-0.004, max(grip.height_m, 0.025), 0.028)
    limbs = [
        Limb(shoulder, elbow, 0.056, 0.043, look.shirt, stripe=look.stripe),
        Limb(elbow, wrist, 0.041, 0.027, sleeve, stripe=look.stripe if look.is_long_sleeved else None),
        Limb(wrist, palm, 0.0235, 0.021, look.skin),
    ]
    if not look.is_long_sleeved:
        limbs[0] = Limb(shoulder, elbow, 0.05, 0.04, look.skin)
        limbs.append(Limb(shoulder, shoulder + 0.6 * (elbow - shoulder), 0.06, 0.053, look.shirt, stripe=look.stripe))
    return limbs
