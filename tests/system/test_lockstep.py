"""Lock-step: the whole robot runs the same every time, and a goal is reached."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.stack import NAVIGATION_GROUP, SLAM_GROUP

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(1.5, 1.0, 0.5)


def drive(robot: LockStep) -> tuple[bool, list[tuple[SE2, SE2 | None]]]:
    """Send a goal while mapping; return whether it succeeded, and truth and estimate a tick."""
    samples: list[tuple[SE2, SE2 | None]] = []
    robot.on_tick = lambda: samples.append(
        (
            robot.sim.last.truth.pose,
            robot.process.transforms.try_lookup("map", "base_footprint"),
        )
    )
    robot.run(1.0)
    return Goals(robot).navigate(GOAL, 40.0).succeeded, samples


def test_a_goal_is_reached_and_one_seed_gives_one_run(stack: Callable[..., LockStep]) -> None:
    succeeded, first = drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=3))
    assert succeeded
    assert first[-1][0].distance(GOAL) < 0.25
    assert drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=3)) == (True, first)
    assert drive(stack(SLAM_GROUP, NAVIGATION_GROUP, seed=4))[1] != first
