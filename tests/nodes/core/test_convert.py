"""Claims: what becomes a message is on the wire what it was, whole numbers too."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from geometry_msgs.msg import Pose, TransformStamped
from rclpy.serialization import deserialize_message, serialize_message

from arjuna_core.ros.convert import pose_msg, se2_from_pose, se2_from_transform, transform_msg
from arjuna_core.se2 import SE2

pytestmark = pytest.mark.ros


def sent(message: Any, kind: type) -> Any:
    """Return a message as another process gets it."""
    return deserialize_message(serialize_message(message), kind)


@pytest.mark.parametrize("pose", [SE2(2, -1, 0), SE2(2.5, -1.25, 0.5)])
def test_a_pose_and_a_transform_arrive_as_they_were(pose: SE2) -> None:
    found = se2_from_pose(sent(pose_msg(pose), Pose))
    told = sent(transform_msg(pose, "map", "odom", 1.0), TransformStamped)
    for one in (found, se2_from_transform(told.transform)):
        assert one.array() == pytest.approx(pose.array())
