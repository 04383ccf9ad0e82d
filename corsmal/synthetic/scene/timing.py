"""When things happen in a recording."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from corsmal.synthetic.scene.containers import DemoContainer
from corsmal.synthetic.sound.events import Filling, Level, pour_duration_s

Action = Literal["pour", "shake", "handle"]
FILLING_NAMES: tuple[Filling, ...] = ("none", "pasta", "rice", "water")

POUR_PACE = 5.0
"""How many times faster than in the real recordings people pour, so that a recording lasts a few seconds."""

JUG_MOVE_S, REACH_S, WALK_S = 0.7, 0.55, 1.3
_HANDOVER_S, _LENGTH_LEAST_S = 1.0, 4.5


@dataclass(frozen=True)
class Timing:
    """When things happen, in seconds.

    Args:
        action: pouring in, shaking, or handling only.
        action_start_s: when it begins.
        grasp_s: when the hand closes on the container; 0 where it is held from the start.
        lift_s: when the container leaves the table; 0 where it never stands there.
        handover_start_s: when it begins to move towards the robot.
        end_s: length of the recording.
    """

    action: Action
    action_start_s: float
    action_end_s: float
    grasp_s: float
    lift_s: float
    handover_start_s: float
    handover_s: float
    end_s: float


def draw_timing(
    container: DemoContainer, *, scenario: int, filling_type: int, filling_level: Level, rng: np.random.Generator
) -> Timing:
    """When what happens in a recording."""
    filling = FILLING_NAMES[filling_type]
    begin_s = rng.uniform(0.25, 0.5) + (WALK_S if scenario == 2 else 0.0)
    action: Action = "handle"
    if container.is_round and filling_level:
        action = "pour"
    elif not container.is_round and (filling_level or rng.random() < 0.5):
        action = "shake"
    length_s = rng.uniform(1.2, 2.4)
    if action == "pour":
        length_s = pour_duration_s(filling, filling_level, container.capacity_ml, rng=rng, pace=POUR_PACE)
    pause_s = rng.uniform(0.1, 0.4)
    if action == "shake":
        grasp_s = begin_s + REACH_S if scenario == 0 else 0.0
        lift_s = grasp_s + 0.1 if scenario == 0 else 0.0
        start_s = max(lift_s + 0.45, begin_s)
        end_s = start_s + length_s
        handover_start_s = end_s + pause_s
    else:
        start_s = begin_s + (JUG_MOVE_S if action == "pour" else 0.0)
        end_s = start_s + length_s
        grasp_s = end_s + 0.2 if scenario == 0 else 0.0
        lift_s = grasp_s + 0.1 if scenario == 0 else 0.0
        handover_start_s = max(lift_s, end_s) + (0.35 if scenario == 0 else 0.2) + pause_s
    handover_s = handover_start_s + _HANDOVER_S * rng.uniform(0.85, 1.2)
    end_s = max(handover_s + rng.uniform(0.35, 0.7), _LENGTH_LEAST_S)
    return Timing(action, start_s, start_s + length_s, grasp_s, lift_s, handover_start_s, handover_s, end_s)
