"""Claims: the amcl node speaks as nav2_amcl does and localizes the robot of the test room."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("nav2_msgs")

from arjuna_interfaces.msg import LocalizationQuality
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav2_msgs.msg import ParticleCloud
from nav2_msgs.srv import SetInitialPose
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    grid_msg,
    header,
    pose_msg,
    scan_msg,
    se2_from_pose,
    seconds,
    transform_msg,
)
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.amcl import AmclNode
from tests.helpers.ros import RosBench
from tests.slam.amcl_room import DT, Robot, error, random_pose, room_map

pytestmark = pytest.mark.ros

ROOM = room_map()


class Room:
    """The rest of the robot: a map, transforms and scans for the node under test."""

    def __init__(self, bench: RosBench) -> None:
        self.bench = bench
        self.robot = Robot(np.random.default_rng(3))
        self.poses = bench.collect(PoseWithCovarianceStamped, "amcl_pose", qos.LATCHED)
        self.qualities = bench.collect(LocalizationQuality, "amcl/localization_quality")
        self.transforms: list[Any] = []
        bench.node.create_subscription(TFMessage, "/tf", self._on_tf, qos.TF)
        mount = transform_msg(SE2(), "base_footprint", "lidar_link", 0.0)
        bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)

    def _on_tf(self, message: Any) -> None:
        self.transforms += [t for t in message.transforms if t.header.frame_id == "map"]

    def publish_map(self) -> None:
        message = grid_msg(ROOM, "map", 0.0)
        self.bench.publish(OccupancyGridMsg, "map", message, qos.LATCHED)

    def publish_odometry(self) -> None:
        odometry = transform_msg(self.robot.odometry, "odom", "base_footprint", self.robot.now)
        self.bench.publish(TFMessage, "/tf", TFMessage(transforms=[odometry]), qos.TF)

    def publish_scan(self, scan: Any) -> None:
        message = scan_msg(scan, "lidar_link", DT)
        self.bench.publish(LaserScan, "scan", message, qos.SENSOR_PUBLISHER)

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.bench.advance(DT)
            scan = self.robot.step()
            self.publish_odometry()
            self.publish_scan(scan)

    def place(self, pose: SE2, frame: str = "map") -> None:
        message = PoseWithCovarianceStamped(header=header(frame, self.robot.now))
        message.pose.pose = pose_msg(pose)
        message.pose.covariance[0] = message.pose.covariance[7] = 0.25
        message.pose.covariance[35] = 0.0685
        self.bench.publish(PoseWithCovarianceStamped, "initialpose", message, qos.DEFAULT)

    @property
    def error(self) -> tuple[float, float]:
        pose = self.bench.process.transforms.lookup("map", "base_footprint")
        return error(pose, self.robot.pose)


@pytest.fixture
def bench() -> Iterator[RosBench]:
    bench = RosBench()
    yield bench
    bench.close()


@pytest.fixture
def room(bench: RosBench) -> Room:
    return Room(bench)


def started(room: Room, with_map: bool = True, **values: Any) -> AmclNode:
    """An active node; the map comes as in a bring-up, between configuration and activation."""
    node = AmclNode(room.bench.process, values)
    node.trigger_configure()
    room.bench.process.drain()
    if with_map:
        room.publish_map()
    node.trigger_activate()
    room.bench.process.drain()
    return node


def newest_pose(room: Room) -> SE2:
    return se2_from_pose(room.poses[-1].pose.pose)


def test_without_an_initial_pose_it_finds_itself_in_the_map(room: Room) -> None:
    started(room)
    room.drive(5)
    off, turned = room.error
    assert off < 0.06
    assert turned < 0.03
    assert room.qualities[-1].quality > 0.9
    assert room.poses[-1].header.frame_id == "map"


def test_a_map_that_comes_late_is_used(room: Room) -> None:
    started(room, with_map=False)
    room.drive(3)
    assert room.poses == []
    room.publish_map()
    room.drive(3)
    assert room.error[0] < 0.06


def test_a_map_latched_long_ago_is_used(room: Room) -> None:
    room.publish_map()
    started(room, with_map=False)
    for _ in range(100):  # the middleware delivers history on its own thread
        room.bench.process.spin_once(0.01)
    room.drive(3)
    assert room.error[0] < 0.06


def test_map_to_odom_is_broadcast_with_each_scan_dated_ahead(room: Room) -> None:
    started(room, transform_tolerance=0.5)
    room.drive(6)
    assert len(room.transforms) == 7  # the first also covers its own scan
    newest = room.transforms[-1]
    assert newest.child_frame_id == "odom"
    assert seconds(newest.header.stamp) == pytest.approx(room.robot.now + 0.5)


def test_tf_broadcast_can_be_switched_off(room: Room) -> None:
    started(room, tf_broadcast=False)
    room.drive(3)
    assert room.transforms == []
    assert room.poses


def test_an_initial_pose_is_where_it_starts(room: Room) -> None:
    started(room, global_localization_at_start="never")
    room.drive(2)
    assert room.poses == []
    room.place(room.robot.pose)
    room.drive(2)
    assert room.error[0] < 0.06


def test_an_initial_pose_before_the_map_is_kept(room: Room) -> None:
    started(room, with_map=False, global_localization_at_start="never")
    room.place(room.robot.pose)
    room.publish_map()
    room.drive(2)
    assert room.error[0] < 0.06


def test_parameters_can_give_the_initial_pose(room: Room) -> None:
    pose = room.robot.pose
    start = {"x": pose.x, "y": pose.y, "yaw": pose.theta}
    started(room, set_initial_pose=True, initial_pose=start, relocalize=False)
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


@pytest.mark.parametrize(
    ("pose", "frame"),
    [(SE2(), "odom"), (SE2(), ""), (SE2(99.0, 0.0, 0.0), "map"), (SE2(float("nan")), "map")],
)
def test_a_bad_initial_pose_changes_nothing(room: Room, pose: SE2, frame: str) -> None:
    started(room)
    room.drive(3)
    room.place(pose, frame)
    room.drive(3)
    assert room.error[0] < 0.06


def test_a_kidnapped_robot_is_noticed_and_found(room: Room) -> None:
    started(room)
    room.drive(10)
    room.robot.pose = random_pose(np.random.default_rng(8))
    room.drive(2)
    assert room.qualities[-1].quality < 0.7
    assert "agree with the map" in room.qualities[-1].reason
    room.drive(30)
    assert room.error[0] < 0.08
    assert room.qualities[-1].quality > 0.9


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


def test_the_lifecycle_can_be_run_through_twice(room: Room) -> None:
    node = started(room)
    room.drive(2)
    for step in ("deactivate", "cleanup", "configure", "activate"):
        assert getattr(node, f"trigger_{step}")() == TransitionCallbackReturn.SUCCESS
        room.bench.process.drain()
    room.publish_map()
    count = len(room.poses)
    room.drive(3)
    assert len(room.poses) > count
    assert room.error[0] < 0.06


def test_an_inactive_node_neither_publishes_nor_broadcasts(room: Room) -> None:
    node = started(room)
    room.drive(2)
    node.trigger_deactivate()
    poses, transforms = len(room.poses), len(room.transforms)
    room.drive(5)
    assert (len(room.poses), len(room.transforms)) == (poses, transforms)
    node.trigger_activate()
    room.drive(30)
    assert room.error[0] < 0.08


def test_crossed_particle_limits_refuse_the_configuration(room: Room) -> None:
    node = AmclNode(room.bench.process, {"min_particles": 3000})
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


def test_parameters_change_at_run_time_and_the_pose_stays(room: Room) -> None:
    node = started(room)
    room.drive(3)
    (result,) = node.set_parameters([Parameter("max_particles", value=800)])
    assert result.successful
    room.drive(3)
    assert room.error[0] < 0.06
    assert node.config.max_particles == 800
    (result,) = node.set_parameters([Parameter("laser_model_type", value="sonar")])
    assert not result.successful
    assert "likelihood_field" in result.reason


def test_after_the_clock_is_set_back_it_finds_itself_again(room: Room) -> None:
    started(room)
    room.drive(5)
    room.robot = Robot(np.random.default_rng(11))
    room.bench._ticks = 0
    room.drive(5)
    assert room.error[0] < 0.06


def test_two_runs_are_the_same_to_the_byte() -> None:
    def trace() -> bytes:
        bench = RosBench()
        room = Room(bench)
        started(room)
        room.drive(20)
        values = np.array([newest_pose(room).array(), room.poses[-1].pose.covariance[:3]])
        bench.close()
        return values.tobytes()

    assert trace() == trace()
