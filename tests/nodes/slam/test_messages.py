"""Claim: messages as the middleware serialises them are read without it."""

from __future__ import annotations

import numpy as np
import pytest
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from tf2_msgs.msg import TFMessage

from arjuna_core.ros.convert import header, pose_msg, scan_msg, transform_msg
from arjuna_core.se2 import SE2
from arjuna_slam.logs.recording import odometry_of, scan_of, transforms_of
from tests.core.bags.recordings import ODOMETRY, SCAN, TF, decoded
from tests.slam.slam_room import room, scan_at

POSE = SE2(1.5, -2.5, -0.7)


def test_a_scan_is_the_scan_that_was_sent() -> None:
    sent = scan_at(room(), SE2(5.0, 5.0, 0.0), beams=77, stamp=12.5)
    scan, frame = scan_of(decoded(SCAN, serialize_message(scan_msg(sent, "lidar_link", 0.1))))
    assert (frame, scan.stamp) == ("lidar_link", 12.5)
    assert scan.angle_min == pytest.approx(sent.angle_min)
    assert scan.range_max == 30.0
    np.testing.assert_allclose(scan.ranges, sent.ranges, rtol=1e-6)


@pytest.mark.parametrize("frame", ["o", "od", "odo", "odom"])
def test_odometry_and_transforms_are_those_that_were_sent(frame: str) -> None:
    message = Odometry(header=header(frame, 3.25), child_frame_id="base_footprint")
    message.pose.pose = pose_msg(POSE)
    odometry = odometry_of(decoded(ODOMETRY, serialize_message(message)))
    moved = transform_msg(POSE, frame, "base_footprint", 3.25)
    (transform,) = transforms_of(decoded(TF, serialize_message(TFMessage(transforms=[moved]))))
    for item in (odometry, transform):
        assert (item.stamp, item.parent, item.child) == (3.25, frame, "base_footprint")
        assert item.transform.distance(POSE) < 1e-12
        assert item.transform.theta == pytest.approx(POSE.theta)
