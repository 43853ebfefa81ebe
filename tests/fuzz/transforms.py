"""Sessions of hostile transforms on /tf and /tf_static, and a goal after each."""

from __future__ import annotations

import math
from contextlib import closing
from typing import Any

import numpy as np
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import transform_msg
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.helpers.robots import ON_MAP, REACHED, truth

CHAIN = ("map", "odom", "base_footprint", "base_link", "lidar_link")
MOVING = 2  # of these move, the rest is static
KINDS = ("loop", "second parent", "no number", "future", "past")
GOALS = (SE2(1.0, 0.0, 0.5), SE2(1.2, 0.7, 2.5), SE2(0.3, 0.5, -1.5))
TICKS = 10
"""Of a session, with up to six transforms in each."""
_PAUSE = 0.5  # until all frames have been published again [s]
_NO_NUMBERS = (math.nan, math.inf, -math.inf, 1e300)
_OFF = (2.0, 5.0, 30.0, 1e4, 1e9)  # [s]; a robot's own transform of about now is believed


def hostile(kind: str, now: float, rng: np.random.Generator) -> Any:
    """Return a stamped transform of a kind of attack, between frames of the robot."""
    above, below = sorted(rng.choice(len(CHAIN), 2, replace=False))
    parent, child, stamp = CHAIN[above], CHAIN[below], now
    if kind == "loop":
        parent, child = child, parent
    elif kind == "second parent":
        parent = str(rng.choice([*CHAIN[: below - 1], f"foreign_{rng.integers(3)}"]))
    elif kind in ("future", "past"):  # in the right parent
        below = int(rng.integers(MOVING))
        parent, child = CHAIN[below], CHAIN[below + 1]
        stamp += float(rng.choice(_OFF)) * (1.0 if kind == "future" else -1.0)
        stamp = min(max(stamp, 0.0), 2.0**31 - 1.0)
    message = transform_msg(SE2(*rng.uniform(-9.0, 9.0, 3)), parent, child, stamp)
    if kind == "no number":
        part = getattr(message.transform, str(rng.choice(["translation", "rotation"])))
        setattr(part, str(rng.choice(["x", "y", "z"])), float(rng.choice(_NO_NUMBERS)))
    return message


class Sessions:
    """A robot under hostile transforms; a new one where a goal was missed.

    Attributes:
        refused: Transforms that the robots have refused.
    """

    def __init__(self) -> None:
        self.refused = 0

    def run(self, seeds: range) -> list[str]:
        """Run a session a seed; return those whose goal was missed, with the reason."""
        missed: list[str] = []
        waiting = list(seeds)
        while waiting:
            parameters = merged(shipped_parameters(), ON_MAP, {"sim": {"seed": waiting[0]}})
            with closing(LockStep(parameters)) as robot:
                self._run_until_missed(robot, waiting, missed)
        return missed

    def _run_until_missed(self, robot: LockStep, waiting: list[int], missed: list[str]) -> None:
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)
        goals, profiles = Goals(robot), {"tf": qos.TF, "tf_static": qos.TF_STATIC}
        publishers = [
            robot.client.create_publisher(TFMessage, topic, profile)
            for topic, profile in profiles.items()
        ]
        reason = ""
        while waiting and not reason:
            seed = waiting.pop(0)
            self._attack(robot, publishers, np.random.default_rng(seed))
            robot.run(_PAUSE)
            goal = GOALS[seed % len(GOALS)]
            end = goals.navigate(goal, 60.0)
            off = truth(robot).distance(goal)
            reason = end.reason or ("" if off < REACHED else f"{off:.2f} m off")
            if reason:
                missed.append(f"seed {seed}: {reason}")
        tallies = robot.process.guard.tallies.items()
        self.refused += sum(t.count for (_, source), t in tallies if source == "a transform")

    @staticmethod
    def _attack(robot: LockStep, publishers: list[Any], rng: np.random.Generator) -> None:
        for _ in range(TICKS):
            kinds = rng.choice(KINDS, int(rng.integers(1, 7)))
            message = TFMessage(transforms=[hostile(str(k), robot.now, rng) for k in kinds])
            timed = {"future", "past"}.intersection(kinds)  # of static ones no stamp counts
            publishers[0 if timed else int(rng.integers(2))].publish(message)
            robot.step()
