"""Claims: the amcl node speaks as nav2_amcl does and localizes the robot of the test room."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
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
from arjuna_core.grid import FREE, OCCUPIED, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    header,
    pose_msg,
    scan_msg,
    se2_from_pose,
    se2_from_transform,
    seconds,
    transform_msg,
)
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.nodes.amcl import AmclNode
from tests.helpers.amcl_room import ROOM, Room, started
from tests.helpers.ros import RosBench
from tests.nodes.slam.nodes import Logged
from tests.slam.amcl.room import BOXES, DT, Robot, room_map


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


def test_map_to_odom_covers_two_periods_of_slow_scans(room: Room) -> None:
    """Else a program that transforms an odometry's pose would fail before each next scan."""
    started(room, transform_tolerance=0.01)
    room.drive(6)
    newest = room.transforms[-1]
    assert seconds(newest.header.stamp) == pytest.approx(room.robot.now + 2.0 * DT)
    room.robot.now += 10.0  # as after an outage: no further ahead than Nav2 dates it
    room.drive(1)
    ahead = seconds(room.transforms[-1].header.stamp) - room.robot.now
    assert ahead == pytest.approx(1.0)


@pytest.mark.parametrize("how", ["on the topic", "before the map", "by the service"])
def test_an_initial_pose_is_where_it_starts(room: Room, how: str) -> None:
    started(room, with_map=how != "before the map", global_localization_at_start="never")
    room.drive(2)
    assert room.poses == []
    if how == "by the service":
        request = SetInitialPose.Request()
        request.pose.header.frame_id = "map"
        request.pose.pose.pose = pose_msg(room.robot.pose)
        room.bench.call(SetInitialPose, "set_initial_pose", request)
    else:
        room.put_robot(room.robot.pose)
    if how == "before the map":
        room.publish_map()
    room.drive(2)
    assert room.error[0] < 0.06


def test_an_initial_pose_of_the_past_is_moved_on_by_odometry(room: Room) -> None:
    started(room, global_localization_at_start="never", match_scans=False, relocalize=False)
    room.drive(2)
    message = initial_pose(room.robot.pose, covariance=(1e-6, 1e-6, 1e-6))
    message.header.stamp = header("map", room.robot.now).stamp
    begun = room.robot.pose
    room.drive(10)
    room.bench.publish(PoseWithCovarianceStamped, "initialpose", message, qos.DEFAULT)
    room.drive(1)
    moved = begun.inverse() @ room.robot.pose
    assert (abs(moved.x) > 0.1, abs(moved.theta) > 0.3) == (True, True)
    assert max(room.error) < 0.1


def test_an_initial_pose_given_before_activation_is_kept(room: Room) -> None:
    node = AmclNode(room.bench.process, {"global_localization_at_start": "never"})
    node.trigger_configure()
    room.put_robot(room.robot.pose)
    room.publish_map()
    node.trigger_activate()
    room.drive(2)
    assert room.error[0] < 0.06


def test_a_lost_robot_s_pose_follows_odometry_until_it_is_found(room: Room) -> None:
    """A guess is no pose to drive from, and a robot without one would never look about."""
    node = started(room)
    room.drive(10)
    led = se2_from_transform(room.transforms[-1].transform)
    room.robot.pose = SE2(-2.2, 1.0, 2.0)
    ring = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
    around = np.column_stack((-2.2 + 1.5 * np.cos(ring), 1.0 + 1.5 * np.sin(ring)))
    room.robot._boxes = tuple((x, y) for x, y in around.tolist())
    room.drive(8)
    assert "lost: only" in node.trouble()
    room.transforms.clear()
    room.drive(3)
    assert len(room.transforms) == 3
    assert se2_from_transform(room.transforms[-1].transform).distance(led) < 0.5
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
        (initial_pose(SE2(99.0, 0.0, 0.0)), "lies outside the map, which spans x"),
        (initial_pose(SE2(NAN, 0.0, 0.0)), "nan is not finite"),
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


def map_message(width: int, height: int, value: int) -> OccupancyGridMsg:
    message = OccupancyGridMsg(header=header("map", 0.0))
    message.info.resolution = 0.05
    message.info.width, message.info.height = width, height
    message.info.origin.orientation.w = 1.0
    message.data = [value] * (width * height)
    return message


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (map_message(0, 0, 0), "0 cells for 0 x 0"),
        (map_message(1, 1, 100), "has no free cell"),
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


def corridors() -> OccupancyGrid:
    """Return another building's map."""
    data = np.full(ROOM.data.shape, FREE, np.int8)
    data[::30], data[:, ::90] = OCCUPIED, OCCUPIED
    return OccupancyGrid(ROOM.frame, data)


def test_on_a_map_of_another_building_the_pose_is_no_longer_broadcast(room: Room) -> None:
    node = started(room)
    room.put_robot(room.robot.pose)
    room.drive(10)
    room.publish_map(corridors())
    room.transforms.clear()
    room.drive(10)
    assert room.transforms == []
    assert "lost since the map was replaced: only" in node.trouble()
    room.publish_map(ROOM)
    room.drive(3)
    assert room.transforms
    assert node.trouble() == ""
    assert room.error < (0.3, 0.2)


def test_without_relocalization_the_pose_is_broadcast_whatever_the_map(room: Room) -> None:
    node = started(room, relocalize=False)
    room.put_robot(room.robot.pose)
    room.drive(10)
    room.publish_map(corridors())
    room.transforms.clear()
    room.drive(5)
    assert len(room.transforms) >= 4
    assert "since the map was replaced" not in node.trouble()


def test_on_a_newer_map_of_the_same_building_the_pose_is_kept(room: Room) -> None:
    started(room)
    room.put_robot(room.robot.pose)
    room.drive(10)
    room.publish_map(room_map(boxes=BOXES[1:]))
    room.transforms.clear()
    room.drive(5)
    assert len(room.transforms) >= 4
    assert room.error < (0.2, 0.1)


def test_a_bad_first_map_is_refused_and_a_good_one_used(room: Room, logged: Logged) -> None:
    started(room, with_map=False)
    room.bench.publish(OccupancyGridMsg, "map", map_message(1, 1, 100), qos.LATCHED)
    room.drive(3)
    assert room.poses == []
    assert any("has no free cell" in line for line in logged.errors)
    room.publish_map()
    room.drive(3)
    assert room.error[0] < 0.06


def test_on_a_map_that_shows_nothing_odometry_leads(room: Room, logged: Logged) -> None:
    started(room, with_map=False)
    room.publish_map(OccupancyGrid(ROOM.frame, np.full_like(ROOM.data, FREE)))
    room.put_robot(room.robot.pose)
    room.drive(10)
    assert room.transforms
    assert room.error[0] < 0.2
    assert [line for line in logged.warnings if "odometry alone" in line]
    assert not [line for line in logged.warnings if "lost" in line]


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


def test_a_start_off_the_map_leads_to_a_search(room: Room, logged: Logged) -> None:
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


@pytest.mark.parametrize("mode", ["auto", "always", "never"])
def test_the_search_at_the_start_is_as_configured(room: Room, mode: str) -> None:
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


def test_the_pose_is_saved_at_its_rate_and_a_later_start_resumes_there(room: Room) -> None:
    node = started(room, save_pose_rate=2.0, set_initial_pose=False)
    room.drive(12)
    saved = node.config.initial_pose
    assert SE2(saved.x, saved.y).distance(room.robot.pose) < 0.5
    belief = node._filter
    room.drive(6)
    assert node._filter is belief  # saving builds nothing anew
    assert (saved.x, saved.y) != (node.config.initial_pose.x, node.config.initial_pose.y)


def test_parameters_can_give_the_initial_pose(room: Room) -> None:
    pose = room.robot.pose
    start = {"x": pose.x, "y": pose.y, "yaw": pose.theta}
    started(room, set_initial_pose=True, initial_pose=start, relocalize=False)
    room.drive(2)
    assert room.error[0] < 0.06


def test_tf_broadcast_can_be_switched_off(room: Room) -> None:
    started(room, tf_broadcast=False)
    room.drive(3)
    assert room.transforms == []
    assert room.poses


def test_two_runs_are_the_same_to_the_byte() -> None:
    def trace() -> bytes:
        bench = RosBench()
        room = Room(bench)
        started(room)
        room.drive(20)
        newest = room.poses[-1].pose
        values = np.array([se2_from_pose(newest.pose).array(), newest.covariance[:3]])
        bench.close()
        return values.tobytes()

    assert trace() == trace()
