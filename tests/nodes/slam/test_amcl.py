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

from arjuna_core.errors import ConfigError
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
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.nodes.amcl import AmclNode
from tests.helpers.ros import RosBench
from tests.slam.amcl.room import DT, Robot, error, random_pose, room_map

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


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the node under test logs as errors."""
    return _logged(monkeypatch, "error")


@pytest.fixture
def warned(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the node under test logs as warnings."""
    return _logged(monkeypatch, "warning")


def _logged(monkeypatch: pytest.MonkeyPatch, level: str) -> list[str]:
    lines: list[str] = []
    real = AmclNode.get_logger

    class Logger:
        def __init__(self, logger: Any) -> None:
            self._logger = logger

        def __getattr__(self, name: str) -> Any:
            return lines.append if name == level else getattr(self._logger, name)

    monkeypatch.setattr(AmclNode, "get_logger", lambda node: Logger(real(node)))
    return lines


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


NAN = float("nan")


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (initial_pose(frame="odom"), "frame 'odom', valid: 'map'"),
        (initial_pose(frame=""), "frame '', valid: 'map'"),
        (initial_pose(SE2(99.0, 0.0, 0.0)), "lies outside the map, which spans x"),
        (initial_pose(SE2(NAN, 0.0, 0.0)), "is not finite"),
        (initial_pose(SE2(0.0, 0.0, NAN)), "is no rotation"),
        (initial_pose(covariance=(NAN, 0.25, 0.07)), "finite"),
        (initial_pose(covariance=(0.25, -0.25, 0.07)), "positive semi-definite"),
        (initial_pose(covariance=(0.1, 0.1, 0.07, 0.3)), "positive semi-definite"),
    ],
)
def test_a_bad_initial_pose_is_refused_with_a_reason_and_changes_nothing(
    room: Room, said: list[str], message: PoseWithCovarianceStamped, reason: str
) -> None:
    started(room)
    room.drive(3)
    room.bench.publish(PoseWithCovarianceStamped, "initialpose", message, qos.DEFAULT)
    (line,) = said
    assert "initial pose refused" in line
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
        (map_message(0, 0, 0), "has no free cell"),
        (map_message(40, 40, 0, resolution=0.0), "resolution must be positive"),
        (map_message(40, 40, 0, resolution=NAN), "resolution must be positive"),
        (map_message(1, 1, 0), "has no occupied cell"),
        (map_message(1, 1, 100), "has no free cell"),
        (map_message(1, 1, -1), "has no free cell"),
        (map_message(40, 40, 0), "has no occupied cell"),
    ],
)
def test_a_bad_map_is_refused_with_a_reason_and_the_last_one_kept(
    room: Room, said: list[str], message: OccupancyGridMsg, reason: str
) -> None:
    node = started(room)
    room.drive(3)
    room.bench.publish(OccupancyGridMsg, "map", message, qos.LATCHED)
    (line,) = said
    assert "refused" in line
    assert reason in line
    node.set_parameters([Parameter("max_particles", value=1500)])  # builds the filter anew
    room.drive(3)
    assert room.error[0] < 0.06


def test_a_bad_map_as_the_first_is_refused_and_a_good_one_then_used(
    room: Room, said: list[str]
) -> None:
    started(room, with_map=False)
    room.bench.publish(OccupancyGridMsg, "map", map_message(1, 1, 0), qos.LATCHED)
    room.drive(3)
    assert room.poses == []
    assert any("has no occupied cell" in line for line in said)
    room.publish_map()
    room.drive(3)
    assert room.error[0] < 0.06


def test_without_a_map_a_pose_is_kept_and_nothing_is_published(room: Room) -> None:
    started(room, with_map=False)
    room.place(room.robot.pose)
    room.drive(3)
    assert room.poses == []
    assert room.transforms == []


def test_scans_of_an_unknown_frame_are_dropped_with_a_reason(room: Room, warned: list[str]) -> None:
    started(room)
    room.drive(3)
    count = len(room.poses)
    message = scan_msg(room.robot.scan(), "nowhere", DT)
    room.bench.publish(LaserScan, "scan", message, qos.SENSOR_PUBLISHER)
    room.drive(3)
    assert any("nowhere" in line for line in warned)
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
    room: Room, said: list[str]
) -> None:
    started(room, set_initial_pose=True, initial_pose={"x": 90.0, "y": 0.0, "yaw": 0.0})
    assert "lies outside the map" in said[0]
    room.drive(2)
    assert room.error[0] < 0.06


@pytest.mark.parametrize("mode", ["auto", "always", "never"])
def test_the_search_at_the_start_is_as_told(room: Room, mode: str) -> None:
    wrong = {"x": 2.0, "y": -4.0, "yaw": 1.0}
    started(
        room,
        global_localization_at_start=mode,
        set_initial_pose=True,
        initial_pose=wrong,
        relocalize_patience=100.0,
    )
    room.drive(2)
    assert (room.error[0] < 0.06) == (mode == "always")


def test_the_pose_is_saved_at_its_rate_and_a_later_start_goes_on_from_there(room: Room) -> None:
    node = started(room, save_pose_rate=2.0, set_initial_pose=False)
    room.drive(12)
    saved = node.config.initial_pose
    assert SE2(saved.x, saved.y).distance(room.robot.pose) < 0.5
    belief = node._filter
    room.drive(6)
    assert node._filter is belief  # saving builds nothing anew
    assert (saved.x, saved.y) != (node.config.initial_pose.x, node.config.initial_pose.y)


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


def test_crossed_particle_limits_are_refused_at_the_start_and_at_run_time(room: Room) -> None:
    with pytest.raises(ConfigError, match="must not exceed max_particles"):
        AmclNode(room.bench.process, {"min_particles": 3000})
    node = started(room)
    (result,) = node.set_parameters([Parameter("min_particles", value=3000)])
    assert "min_particles (3000) must not exceed max_particles (2000)" in result.reason
    assert node.config.min_particles == node.get_parameter("min_particles").value == 500


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
