"""Claims: the amcl node refuses what it cannot use, says why, and stays as it was."""

from __future__ import annotations

import numpy as np
import pytest

from tests.nodes.slam.nodes import Logged

pytest.importorskip("rclpy")
pytest.importorskip("nav2_msgs")

from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.grid import FREE, OCCUPIED, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_msg, scan_msg, seconds, transform_msg
from arjuna_core.se2 import IDENTITY, SE2
from tests.helpers.amcl_room import ROOM, Room, started
from tests.slam.amcl.room import BOXES, DT, room_map

pytestmark = pytest.mark.ros


NAN = float("nan")


def initial_pose(
    pose: SE2 = IDENTITY, frame: str = "map", covariance: tuple[float, ...] = (0.25, 0.25, 0.0685)
) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped(header=header(frame, 0.0))
    message.pose.pose = pose_msg(pose)
    message.pose.covariance[0], message.pose.covariance[7] = covariance[:2]
    message.pose.covariance[35] = covariance[2]
    if len(covariance) > 3:
        message.pose.covariance[1] = message.pose.covariance[6] = covariance[3]
    return message


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (initial_pose(frame="odom"), "frame 'odom', valid: 'map'"),
        (initial_pose(frame=""), "frame '', valid: 'map'"),
        (initial_pose(SE2(99.0, 0.0, 0.0)), "lies outside the map, which spans x"),
        (initial_pose(SE2(NAN, 0.0, 0.0)), "nan is not finite"),
        (initial_pose(SE2(0.0, 0.0, NAN)), "nan is not finite"),
        (initial_pose(covariance=(NAN, 0.25, 0.07)), "nan is not finite"),
        (initial_pose(covariance=(0.25, -0.25, 0.07)), "a variance is -0.25"),
        (initial_pose(covariance=(0.1, 0.1, 0.07, 0.3)), "positive semi-definite"),
    ],
)
def test_a_bad_initial_pose_is_refused_with_a_reason_and_changes_nothing(
    room: Room, logged: Logged, message: PoseWithCovarianceStamped, reason: str
) -> None:
    started(room)
    room.drive(3)
    room.bench.publish(PoseWithCovarianceStamped, "initialpose", message, qos.DEFAULT)
    (line,) = logged.errors + logged.warnings
    assert "initial pose refused" in line or "initialpose refused" in line
    assert reason in line
    room.drive(3)
    assert room.error[0] < 0.06


def map_message(width: int, height: int, value: int, resolution: float = 0.05) -> OccupancyGridMsg:
    message = OccupancyGridMsg(header=header("map", 0.0))
    message.info.resolution = resolution
    message.info.width, message.info.height = width, height
    message.info.origin.orientation.w = 1.0
    message.data = [value] * (width * height)
    return message


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (map_message(0, 0, 0), "0 cells for 0 x 0"),
        (map_message(40, 40, 0, resolution=0.0), "cells of 0.0 m"),
        (map_message(40, 40, 0, resolution=NAN), "info.resolution: nan"),
        (map_message(1, 1, 0), "has no occupied cell"),
        (map_message(1, 1, 100), "has no free cell"),
        (map_message(1, 1, -1), "has no free cell"),
        (map_message(40, 40, 0), "has no occupied cell"),
    ],
)
def test_a_bad_map_is_refused_with_a_reason_and_the_last_one_kept(
    room: Room, logged: Logged, message: OccupancyGridMsg, reason: str
) -> None:
    node = started(room)
    room.drive(3)
    room.bench.publish(OccupancyGridMsg, "map", message, qos.LATCHED)
    (line,) = logged.errors + logged.warnings
    assert "refused" in line
    assert reason in line
    node.set_parameters([Parameter("max_particles", value=1500)])  # builds the filter anew
    room.drive(3)
    assert room.error[0] < 0.06


def test_on_a_map_of_another_building_the_pose_is_no_longer_broadcast(room: Room) -> None:
    node = started(room)
    room.put_robot(room.robot.pose)
    room.drive(10)
    corridors = np.full(ROOM.data.shape, FREE, np.int8)
    corridors[::30], corridors[:, ::90] = OCCUPIED, OCCUPIED
    room.publish_map(OccupancyGrid(ROOM.frame, corridors))
    room.transforms.clear()
    room.drive(10)
    assert room.transforms == []
    assert "lost since the map was replaced: only" in node.trouble()
    room.publish_map(ROOM)
    room.drive(3)
    assert room.transforms
    assert node.trouble() == ""
    assert room.error < (0.3, 0.2)


def test_on_a_newer_map_of_the_same_building_the_pose_is_kept(room: Room) -> None:
    started(room)
    room.put_robot(room.robot.pose)
    room.drive(10)
    room.publish_map(room_map(boxes=BOXES[1:]))
    room.transforms.clear()
    room.drive(5)
    assert len(room.transforms) >= 4
    assert room.error < (0.2, 0.1)


def test_a_bad_map_as_the_first_is_refused_and_a_good_one_then_used(
    room: Room, logged: Logged
) -> None:
    started(room, with_map=False)
    room.bench.publish(OccupancyGridMsg, "map", map_message(1, 1, 0), qos.LATCHED)
    room.drive(3)
    assert room.poses == []
    assert any("has no occupied cell" in line for line in logged.errors)
    room.publish_map()
    room.drive(3)
    assert room.error[0] < 0.06


def test_scans_of_an_unknown_frame_are_dropped_with_a_reason(room: Room, logged: Logged) -> None:
    started(room)
    room.drive(3)
    count = len(room.poses)
    message = scan_msg(room.robot.scan(), "nowhere", DT)
    room.bench.publish(LaserScan, "scan", message, qos.SENSOR_PUBLISHER)
    room.drive(3)
    assert any("nowhere" in line for line in logged.warnings)
    assert len(room.poses) == count + 3
    assert room.error[0] < 0.06


def test_odometry_that_is_no_pose_leaves_the_filter_as_it_was(room: Room) -> None:
    started(room)
    room.drive(3)
    odometry = transform_msg(room.robot.odometry, "odom", "base_footprint", room.robot.now + DT)
    odometry.transform.translation.x = NAN
    room.bench.advance(DT)
    room.bench.publish(TFMessage, "/tf", TFMessage(transforms=[odometry]), qos.TF)
    room.publish_scan(room.robot.step())
    room.drive(4)
    assert room.error[0] < 0.06


def test_a_configured_pose_off_the_map_is_refused_and_the_map_searched(
    room: Room, logged: Logged
) -> None:
    started(room, set_initial_pose=True, initial_pose={"x": 90.0, "y": 0.0, "yaw": 0.0})
    assert "lies outside the map" in logged.errors[0]
    room.drive(2)
    assert room.error[0] < 0.06


def test_a_scan_waits_for_its_transform(room: Room) -> None:
    started(room)
    room.bench.advance(DT)
    scan = room.robot.step()
    room.publish_scan(scan)
    assert room.poses == []
    room.publish_odometry()
    room.bench.advance(0.02)
    assert len(room.poses) == 1


def test_scans_without_transforms_are_dropped_and_later_ones_used(room: Room) -> None:
    started(room)
    for _ in range(15):
        room.bench.advance(DT)
        room.publish_scan(room.robot.step())
    assert room.poses == []
    room.drive(2)
    assert room.error[0] < 0.06
    assert seconds(room.poses[0].header.stamp) > 1.0
