"""Claims: the amcl node speaks as nav2_amcl does and localizes the robot of the test room."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("nav2_msgs")

from nav2_msgs.msg import ParticleCloud
from nav2_msgs.srv import SetInitialPose
from std_srvs.srv import Empty

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_msg, seconds
from arjuna_core.se2 import SE2
from tests.helpers.amcl_room import Room, started
from tests.slam.amcl.room import BOXES

pytestmark = pytest.mark.ros


def test_without_an_initial_pose_it_finds_itself_in_the_map(room: Room) -> None:
    started(room)
    room.drive(5)
    off, turned = room.error
    assert off < 0.06
    assert turned < 0.03
    assert room.qualities[-1].quality > 0.9
    assert room.poses[-1].header.frame_id == "map"


def test_a_motion_model_of_one_s_own(room: Room, own_plugins: Path) -> None:
    started(room, robot_model_type="my_motion:sure")
    room.drive(5)
    assert room.error[0] < 0.06


def test_a_map_that_comes_late_is_used(room: Room) -> None:
    started(room, with_map=False)
    room.drive(3)
    assert room.poses == []
    room.publish_map()
    room.drive(3)
    assert room.error[0] < 0.06


def test_a_map_latched_long_ago_is_used(room: Room) -> None:
    room.publish_map()
    node = started(room, with_map=False)
    room.bench.until(lambda: node._grid is not None, "the map of before")
    room.drive(3)
    assert room.error[0] < 0.06


def test_map_to_odom_is_broadcast_with_each_scan_dated_ahead(room: Room) -> None:
    started(room, transform_tolerance=0.5)
    room.drive(6)
    assert len(room.transforms) == 7  # the first also covers its own scan
    newest = room.transforms[-1]
    assert newest.child_frame_id == "odom"
    assert seconds(newest.header.stamp) == pytest.approx(room.robot.now + 0.5)


def test_an_initial_pose_is_where_it_starts(room: Room) -> None:
    started(room, global_localization_at_start="never")
    room.drive(2)
    assert room.poses == []
    room.put_robot(room.robot.pose)
    room.drive(2)
    assert room.error[0] < 0.06


def test_an_initial_pose_before_the_map_is_kept(room: Room) -> None:
    started(room, with_map=False, global_localization_at_start="never")
    room.put_robot(room.robot.pose)
    room.publish_map()
    room.drive(2)
    assert room.error[0] < 0.06


def test_the_service_sets_the_pose_too(room: Room) -> None:
    started(room, global_localization_at_start="never")
    request = SetInitialPose.Request()
    request.pose.header.frame_id = "map"
    request.pose.pose.pose = pose_msg(room.robot.pose)
    room.bench.call(SetInitialPose, "set_initial_pose", request)
    room.drive(2)
    assert room.error[0] < 0.06


def test_a_robot_that_is_lost_and_searched_elsewhere_has_no_pose_until_found(
    room: Room,
) -> None:
    node = started(room)
    room.drive(10)
    room.robot.pose = SE2(-2.2, 1.0, 2.0)
    ring = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    around = np.column_stack((-2.2 + 1.5 * np.cos(ring), 1.0 + 1.5 * np.sin(ring)))
    room.robot._boxes = tuple((x, y) for x, y in around.tolist())
    room.drive(8)
    assert "lost: only" in node.trouble()
    room.transforms.clear()
    room.drive(3)
    assert room.transforms == []
    room.robot._boxes = BOXES
    room.drive(30)
    assert node.trouble() == ""
    assert room.transforms
    assert room.error[0] < 0.08


def test_global_localization_and_nomotion_update_answer(room: Room) -> None:
    started(room)
    room.drive(3)
    count = len(room.poses)
    room.bench.call(Empty, "request_nomotion_update", Empty.Request())
    room.publish_scan(room.robot.scan())
    assert len(room.poses) == count + 1
    room.bench.call(Empty, "reinitialize_global_localization", Empty.Request())
    room.drive(1)
    assert len(room.poses) == count + 2
    assert room.error[0] < 0.06


def test_the_particle_cloud_is_published_to_those_who_listen(room: Room) -> None:
    clouds = room.bench.collect(ParticleCloud, "particle_cloud", qos.SENSOR_SUBSCRIPTION)
    started(room)
    room.drive(2)
    assert len(clouds[-1].particles) >= 500
    weights = [particle.weight for particle in clouds[-1].particles]
    assert sum(weights) == pytest.approx(1.0)
