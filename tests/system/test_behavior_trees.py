"""A whole robot driven by Nav2's default tree, in lock-step: the same every time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from nav2_msgs.action import NavigateToPose

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(1.5, 0.8, 0.5)
TREE = "navigate_to_pose_w_replanning_and_recovery.xml"
PARAMETERS = {
    "map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))},
    "amcl": {"set_initial_pose": True},
}


def driven(stack: Callable[..., LockStep]) -> list[SE2]:
    """Drive to the goal; return the true pose of every tick."""
    robot = stack(LOCALIZATION_GROUP, NAVIGATION_GROUP, seed=3, parameters=PARAMETERS)
    robot.run(1.0)
    poses: list[SE2] = []
    robot.on_tick = lambda: poses.append(robot.sim.last.truth.pose)
    client = action_client(robot.client, NavigateToPose, "navigate_to_pose")
    robot.process.drain()
    goal = NavigateToPose.Goal(pose=pose_stamped(GOAL, "map", 0.0), behavior_tree=TREE)
    sent = client.send_goal_async(goal)
    robot.run_until(sent.done, 1.0, "an answer")
    ended = sent.result().get_result_async()
    robot.run_until(ended.done, 60.0, "the end of the goal")
    assert ended.result().result.error_msg == ""
    client.destroy()
    return poses


def test_the_default_tree_drives_the_same_every_time(stack: Callable[..., LockStep]) -> None:
    first, second = driven(stack), driven(stack)
    assert first[-1].distance(GOAL) < 0.25
    assert first == second
