"""The robot's frames, and transforms as scripts see them."""

from __future__ import annotations

import math
from typing import Any

import pytest
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import transform_msg
from arjuna_core.ros.tf import TransformBuffer, TransformListener
from arjuna_core.se2 import SE2
from bringup.client.robot import Robot
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SLAM_GROUP, Group
from tests.helpers.robots import Stack

WRONG: dict[str, dict[str, Any]] = {
    "slam_toolbox": {"base_frame": "chassis"},
    "amcl": {"base_frame_id": "chassis"},
    "local_costmap/local_costmap": {"robot_base_frame": "chassis"},
}


@pytest.mark.parametrize(
    ("group", "node", "parameter"),
    [
        (SLAM_GROUP, "slam_toolbox", "base_frame"),
        (LOCALIZATION_GROUP, "amcl", "base_frame_id"),
        (NAVIGATION_GROUP, "local_costmap", "robot_base_frame"),
    ],
    ids=["slam", "amcl", "costmap"],
)
def test_a_wrong_base_frame_is_said_with_its_remedy(
    stack: Stack,
    group: Group,
    node: str,
    parameter: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    robot = stack(group, parameters=WRONG)
    robot.run(4.0)
    said = [line for line in capfd.readouterr().err.splitlines() if "chassis" in line]
    lines = [line for line in said if f"[{node}" in line or f".{node}]" in line]
    assert f"set {parameter}: base_footprint" in lines[0]
    assert sum(f"set {parameter}" in line for line in lines) == 1


def test_a_right_one_is_not_spoken_of(stack: Stack, capfd: pytest.CaptureFixture[str]) -> None:
    stack(SLAM_GROUP, NAVIGATION_GROUP).run(3.0)
    assert "does not exist" not in capfd.readouterr().err


def test_a_script_finds_the_pose_in_a_robots_own_frames(stack: Stack) -> None:
    robot = stack()
    robot.run(1.0)
    with Robot(session=robot) as script:
        assert script.pose("odom").distance(SE2()) < 0.05


def test_a_client_s_plain_node_listens_and_refuses_too() -> None:
    context = new_context()
    node = Node("plain", context=context)
    buffer = TransformBuffer()
    listener = TransformListener(node, buffer)
    good, bad = (transform_msg(SE2(), "odom", child, 0.0) for child in ("base", "arm"))
    bad.transform.translation.x = math.nan
    listener._insert(TFMessage(transforms=[bad, good]), static=False, named="")
    node.destroy_node()
    context.shutdown()
    assert buffer.try_lookup("odom", "base") is not None
    assert buffer.try_lookup("odom", "arm") is None
