"""The jug: where it stands, and how it is tilted over the container."""

import numpy as np

from corsmal.synthetic.render.kernels import Floats
from corsmal.synthetic.scene.containers import DemoContainer
from corsmal.synthetic.scene.paths import CENTRE_X_M, axis_rotation, ramp
from corsmal.synthetic.scene.timing import JUG_MOVE_S, Timing

JUG_HEIGHT_M, JUG_RADIUS_M = 0.165, 0.046


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

    Args:
        container: what is poured into.
        timing: when.
        base_m: (F, 3) the container's base.
        rotation: (F, 3, 3) container to world.
        share: (F,) from ``jug_share``.
        times_s: (F,) the frames' times.
        table_z_m: height of the table.
        rng: draws where it stands, how high it is held, and whether it is there when nothing is poured.

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
