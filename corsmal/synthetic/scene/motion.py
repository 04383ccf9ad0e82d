"""What happens in a recording, and where everything is in each frame.

World coordinates as everywhere: metres, z up, the table near z = 0. The person sits at negative y, the robot's camera
is at positive y, and the person's right is at positive x.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corsmal.dataset.annotation import LEVEL_FRACTIONS
from corsmal.geometry import Floats
from corsmal.synthetic.scene.containers import DemoContainer
from corsmal.synthetic.scene.timing import JUG_MOVE_S, REACH_S, WALK_S, Timing
from corsmal.synthetic.sound.events import Level

CENTRE_X_M = 0.27
"""Where the person sits and the container stands, along the table."""

JUG_HEIGHT_M, JUG_RADIUS_M = 0.165, 0.046


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses, one row per frame.

    Args:
        base_m: (F, 3) the point of the container's axis at its base.
        rotation: (F, 3, 3) container to world.
        fill: (F,) share of the capacity that is filled.
        reach: (F,) 0 the right hand rests, 1 it is at the container.
        opening: (F,) 0 the right hand is closed, 1 open.
        grip_deg: direction from the container's axis to the palm, in the container's frame.
        jug_base_m: (F, 3) the jug, NaN where there is none.
        jug_rotation: (F, 3, 3) jug to world.
        jug_reach: (F,) 0 the left hand rests, 1 it is at the jug.
        stream: (F,) bool, whether something falls from the jug.
        body_m: (F, 3) how far the person is from the seat.
    """

    base_m: Floats
    rotation: Floats
    fill: Floats
    reach: Floats
    opening: Floats
    grip_deg: float
    jug_base_m: Floats
    jug_rotation: Floats
    jug_reach: Floats
    stream: NDArray[np.bool_]
    body_m: Floats


def draw_motion(
    container: DemoContainer,
    timing: Timing,
    *,
    scenario: int,
    filling_level: Level,
    table_z_m: float,
    times_s: Floats,
    rng: np.random.Generator,
) -> Motion:
    """Where everything is at the times ``times_s`` (F,)."""
    body = _body_path(scenario, times_s, rng)
    base = _container_path(timing, scenario=scenario, table_z_m=table_z_m, times_s=times_s, rng=rng) + body * (
        scenario == 2
    )
    held = ramp(times_s, timing.lift_s, timing.lift_s + 0.3) if timing.lift_s else np.ones(len(times_s))
    base += held[:, None] * _wobble(times_s, rng)
    rotation = _container_rotation(container, timing, times_s=times_s, held=held, rng=rng)
    shaken = _shake(timing, times_s)
    base[:, 2] += 0.03 * shaken
    poured = ramp(times_s, timing.action_start_s, timing.action_end_s, is_smooth=False)
    fraction = LEVEL_FRACTIONS[filling_level]
    fill = fraction * poured if timing.action == "pour" else np.full(len(times_s), fraction)
    reach, opening = np.ones(len(times_s)), np.zeros(len(times_s))
    if scenario == 0:
        reach = ramp(times_s, timing.grasp_s - REACH_S, timing.grasp_s - 0.05)
        opening = 1 - ramp(times_s, timing.grasp_s - 0.15, timing.grasp_s + 0.05)
    jug_base, jug_rotation = jug_poses(
        container,
        timing,
        base_m=base,
        rotation=rotation,
        share=jug_share(timing, times_s),
        times_s=times_s,
        table_z_m=table_z_m,
        rng=rng,
    )
    is_pouring = (timing.action == "pour") & (times_s >= timing.action_start_s) & (times_s < timing.action_end_s)
    jug_reach = ramp(times_s, timing.action_start_s - 1.25, timing.action_start_s - JUG_MOVE_S) - ramp(
        times_s, timing.action_end_s + JUG_MOVE_S, timing.action_end_s + 1.3
    )
    return Motion(
        base_m=base,
        rotation=rotation,
        fill=fill,
        reach=reach,
        opening=opening,
        grip_deg=float(rng.uniform(-45, 5)) if container.is_round else 0.0,
        jug_base_m=jug_base,
        jug_rotation=jug_rotation,
        jug_reach=jug_reach if timing.action == "pour" else np.zeros(len(times_s)),
        stream=np.asarray(is_pouring, dtype=np.bool_),
        body_m=body,
    )


def ramp(times_s: Floats, start_s: float, end_s: float, *, is_smooth: bool = True) -> Floats:
    """From 0 at ``start_s`` to 1 at ``end_s``, (F,); smooth at both ends unless told otherwise."""
    share = np.clip((times_s - start_s) / max(end_s - start_s, 1e-6), 0, 1)
    return share * share * (3 - 2 * share) if is_smooth else share


def axis_rotation(axis: ArrayLike, angles_rad: ArrayLike) -> Floats:
    """(n, 3, 3) rotations about a unit axis (3,) by the angles (n,)."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    angles = np.atleast_1d(np.asarray(angles_rad, dtype=np.float64))[:, None, None]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angles) * cross + (1 - np.cos(angles)) * (cross @ cross)


def jug_share(timing: Timing, times_s: Floats) -> Floats:
    """0 the jug stands on the table, 1 it is over the container."""
    start, end = timing.action_start_s, timing.action_end_s
    return ramp(times_s, start - JUG_MOVE_S, start) - ramp(times_s, end, end + JUG_MOVE_S)


def jug_poses(
    container: DemoContainer,
    timing: Timing,
    *,
    base_m: Floats,
    rotation: Floats,
    share: Floats,
    times_s: Floats,
    table_z_m: float,
    rng: np.random.Generator,
) -> tuple[Floats, Floats]:
    """Where the jug is: on the table, and while it pours with its lip over the container's mouth.

    Arguments are as in ``Motion`` and ``draw_motion``; ``share`` (F,) comes from ``jug_share``.

    Returns:
        (F, 3) its base in metres, NaN where there is no jug; (F, 3, 3) jug to world.
    """
    rest = np.array([CENTRE_X_M - rng.uniform(0.24, 0.3), rng.uniform(0.0, 0.12), table_z_m])
    is_there = timing.action == "pour" or (container.is_round and rng.random() < 0.4)
    upright = np.repeat(np.eye(3)[None], len(times_s), axis=0)
    if not is_there:
        return np.full((len(times_s), 3), np.nan), upright
    if timing.action != "pour":
        return np.repeat(rest[None], len(times_s), axis=0), upright
    poured = ramp(times_s, timing.action_start_s - 0.25, timing.action_end_s, is_smooth=False)
    tilted = axis_rotation((0, 1, 0), np.radians(share * (50 + 45 * poured)))
    mouth = base_m + rotation[:, :, 2] * container.height_mm / 1000
    lip = mouth + np.array([-0.2 * container.width_top_mm / 1000, 0, rng.uniform(0.035, 0.06)])
    pouring = lip - tilted @ np.array([JUG_RADIUS_M, 0, JUG_HEIGHT_M])
    lifted = np.array([0, 0, 0.08]) * np.sin(np.pi * share)[:, None]
    return rest + (pouring - rest) * share[:, None] + lifted, tilted


def _body_path(scenario: int, times_s: Floats, rng: np.random.Generator) -> Floats:
    side, back, up = rng.choice([-1, 1]) * rng.uniform(0.6, 0.95), rng.uniform(-0.3, -0.1), rng.uniform(0.05, 0.13)
    path = np.zeros((len(times_s), 3))
    if scenario == 2:
        away = 1 - ramp(times_s, 0.0, WALK_S)
        steps = 0.012 * np.abs(np.sin(2 * np.pi * 1.8 * times_s)) * (away > 0)
        path = np.column_stack([side * away, back * away, up + steps])
    sway = rng.uniform(0, 2 * np.pi, 2)
    path[:, 0] += 0.006 * np.sin(2 * np.pi * 0.31 * times_s + sway[0])
    path[:, 1] += 0.006 * np.sin(2 * np.pi * 0.23 * times_s + sway[1])
    return path


def _container_path(
    timing: Timing, *, scenario: int, table_z_m: float, times_s: Floats, rng: np.random.Generator
) -> Floats:
    stands = np.array([CENTRE_X_M + rng.uniform(-0.09, 0.09), rng.uniform(0.0, 0.14), table_z_m])
    held = np.array(
        [CENTRE_X_M + rng.uniform(-0.06, 0.06), rng.uniform(0.0, 0.12), table_z_m + rng.uniform(0.06, 0.13)]
    )
    handed = np.array(
        [CENTRE_X_M + rng.uniform(-0.07, 0.08), rng.uniform(0.22, 0.36), table_z_m + rng.uniform(0.07, 0.16)]
    )
    path = np.repeat(held[None], len(times_s), axis=0)
    if scenario == 0:
        lifted = ramp(times_s, timing.lift_s, timing.lift_s + 0.45)[:, None]
        path = stands + (held - stands) * lifted
    return path + (handed - held) * ramp(times_s, timing.handover_start_s, timing.handover_s)[:, None]


def _wobble(times_s: Floats, rng: np.random.Generator) -> Floats:
    phases, rates = rng.uniform(0, 2 * np.pi, 3), rng.uniform(0.4, 1.2, 3)
    return 0.004 * np.sin(2 * np.pi * rates * times_s[:, None] + phases)


def _shake(timing: Timing, times_s: Floats) -> Floats:
    if timing.action != "shake":
        return np.zeros(len(times_s))
    start, end = timing.action_start_s, timing.action_end_s
    envelope = ramp(times_s, start, start + 0.2) - ramp(times_s, end - 0.2, end)
    return envelope * np.sin(2 * np.pi * 3.4 * (times_s - start))


def _container_rotation(
    container: DemoContainer, timing: Timing, *, times_s: Floats, held: Floats, rng: np.random.Generator
) -> Floats:
    yaw = np.radians(rng.uniform(-180, 180) if container.is_round else rng.uniform(-14, 14))
    phases, rates = rng.uniform(0, 2 * np.pi, 2), rng.uniform(0.3, 0.9, 2)
    handed = ramp(times_s, timing.handover_start_s, timing.handover_s)
    sideways = held * (2 * np.sin(rates[0] * times_s * 2 * np.pi + phases[0]) + rng.uniform(-3, 3))
    forwards = held * (2 * np.sin(rates[1] * times_s * 2 * np.pi + phases[1]) + rng.uniform(-3, 3))
    sideways += handed * rng.uniform(-6, 6) + 8 * _shake(timing, times_s)
    forwards += handed * rng.uniform(-8, 4)
    about_y = axis_rotation((0, 1, 0), np.radians(sideways))
    about_x = axis_rotation((1, 0, 0), np.radians(forwards))
    return about_y @ about_x @ axis_rotation((0, 0, 1), yaw)
