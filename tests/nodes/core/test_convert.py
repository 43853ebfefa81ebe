"""Claims: what becomes a message is on the wire what it was, whole numbers too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Pose, TransformStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message

from arjuna_core.ros.convert import (
    header,
    path_msg,
    pose_msg,
    pose_stamped,
    se2_from_pose,
    se2_from_transform,
    transform_msg,
)
from arjuna_core.se2 import SE2


def sent(message: Any, kind: type) -> Any:
    """Return a message as another process gets it."""
    return deserialize_message(serialize_message(message), kind)


@pytest.mark.parametrize("pose", [SE2(2, -1, 0), SE2(2.5, -1.25, 0.5)])
def test_a_pose_and_a_transform_arrive_as_they_were(pose: SE2) -> None:
    found = se2_from_pose(sent(pose_msg(pose), Pose))
    transform = sent(transform_msg(pose, "map", "odom", 1.0), TransformStamped)
    for one in (found, se2_from_transform(transform.transform)):
        assert one.array() == pytest.approx(pose.array())


@pytest.mark.parametrize("count", [0, 1, 40])
@pytest.mark.parametrize("kind", [float, int])
def test_a_path_is_what_rclpy_makes_of_its_poses(count: int, kind: type) -> None:
    poses: NDArray[Any] = np.random.default_rng(1).uniform(-9.0, 9.0, (count, 3)).astype(kind)
    stamped = [pose_stamped(SE2.from_array(pose), "map", 7.25) for pose in poses]
    plain = Path(header=header("map", 7.25), poses=stamped)
    made = path_msg(poses, "map", 7.25)
    assert made == plain
    assert sent(made, Path) == plain


def test_each_pose_of_a_path_is_its_own() -> None:
    made = path_msg(np.zeros((2, 3)), "map", 1.0)
    made.poses[0].header.stamp.sec = 5
    made.poses[0].header.frame_id = "odom"
    made.poses[0].pose.position.x = 3.0
    assert made.poses[1] == pose_stamped(SE2(), "map", 1.0)
    assert made.header == header("map", 1.0)
