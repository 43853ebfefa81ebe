"""Claims: pace, bad scans and stock parameters work as they should."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from slam_toolbox.srv import ClearQueue
from tf2_msgs.msg import TFMessage

from arjuna_core.config import load
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, seconds, transform_msg
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig, SlamNodeConfig
from arjuna_slam.matching.scan_filter import Skip
from bringup.parameters.checking import merged_sources
from bringup.parameters.files import for_node, shipped_parameters
from tests.helpers.slam_robot import DT, LOG, Robot, started
from tests.nodes.slam.nodes import Logged
from tests.slam.slam_room import distance_to_walls, room

FOREIGN = Path(__file__).resolve().parents[2] / "foreign" / "slam_toolbox"
STOCK = FOREIGN / "mapper_params_online_async.yaml"


def test_a_stock_file_is_accepted_with_remarks_and_maps(robot: Robot, logged: Logged) -> None:
    read = merged_sources([STOCK])
    node = started(robot, **for_node(read.parameters, "slam_toolbox"))
    robot.drive(len(LOG) - 1)
    assert not logged.warnings
    named = {remark.where.partition(": ")[2] for remark in read.remarks}
    assert {"ceres_loss_function", "link_match_minimum_response_fine", "stack_size_to_use"} <= named
    assert not {"loop_match_minimum_response_fine", "throttle_scans", "scan_buffer_size"} & named
    assert robot.error() < 0.03
    grid = grid_from_msg(robot.maps[-1])
    cells = grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64))
    assert distance_to_walls(room(), LOG[0][2].apply(cells)).mean() < 0.03
    assert len(robot.poses) == pytest.approx(len(LOG) * DT / 0.5, abs=3)
    assert len(node.slam.graph) < len(LOG) * 0.05 / 0.5 + 3


# slam_toolbox 2.7: slam_mapper.cpp, slam_toolbox_common.cpp, laser_utils.cpp
THEIRS = {
    "odom_frame": "odom", "map_frame": "map", "base_frame": "base_footprint",
    "scan_topic": "/scan", "map_name": "/map", "resolution": 0.05, "max_laser_range": 25.0,
    "scan_queue_size": 1, "throttle_scans": 1, "minimum_time_interval": 0.5,
    "map_update_interval": 10.0, "transform_publish_period": 0.05, "transform_timeout": 0.5,
    "position_covariance_scale": 1.0, "yaw_covariance_scale": 1.0,
    "enable_interactive_mode": False, "use_map_saver": True, "debug_logging": False,
    "map_file_name": "", "map_start_pose": (), "map_start_at_dock": False,
    "use_scan_matching": True, "minimum_travel_distance": 0.5, "minimum_travel_heading": 0.5,
    "do_loop_closing": True, "loop_search_maximum_distance": 3.0,
    "loop_match_minimum_response_coarse": 0.35, "loop_match_minimum_response_fine": 0.45,
    "correlation_search_space_dimension": 0.5, "loop_search_space_dimension": 8.0,
    "coarse_search_angle_offset": 0.349, "distance_variance_penalty": 0.5,
    "angle_variance_penalty": 1.0, "minimum_distance_penalty": 0.05, "minimum_angle_penalty": 0.9,
    "min_pass_through": 2, "occupancy_threshold": 0.1,
}  # fmt: skip


def test_what_a_file_leaves_out_is_as_in_slam_toolbox() -> None:
    config = SlamNodeConfig()
    assert {name: getattr(config, name) for name in THEIRS} == THEIRS


def test_the_shipped_values_are_those_of_the_mapper_itself() -> None:
    config = load(SlamNodeConfig, shipped_parameters()["slam_toolbox"])
    own = {f.name: getattr(SlamConfig(), f.name) for f in dataclasses.fields(SlamConfig)}
    assert {name: getattr(config.core, name) for name in own} == own


ADMITTED = {
    "resolution": 0.0, "max_laser_range": 0.0, "throttle_scans": 0, "map_update_interval": 0.01,
    "scan_queue_size": 0, "position_covariance_scale": 0.0, "yaw_covariance_scale": 0.0,
    "distance_variance_penalty": 0.0, "angle_variance_penalty": 0.0,
    "minimum_distance_penalty": 1.5, "minimum_angle_penalty": 1.5,
    "loop_search_space_dimension": 0.0, "coarse_search_angle_offset": 6.28,
    "loop_match_minimum_response_fine": 2.0, "loop_match_minimum_response_coarse": 2.0,
    "occupancy_threshold": 1.2, "min_pass_through": 5000,
}  # fmt: skip


@pytest.mark.parametrize("name", ADMITTED)
def test_what_slam_toolbox_admits_maps_here(robot: Robot, logged: Logged, name: str) -> None:
    started(robot, **{name: ADMITTED[name]})
    robot.drive(12)
    assert robot.error() < 0.05
    assert robot.maps
    corrected = name in ("resolution", "max_laser_range", "throttle_scans", "map_update_interval")
    assert [text for text in logged.warnings if text.startswith(f"{name} is ")] == [
        text for text in logged.warnings if corrected
    ]
    assert len(logged.warnings) == corrected


def test_every_third_scan_or_none_too_soon_if_so_asked(robot: Robot) -> None:
    node = started(robot, throttle_scans=3)
    robot.drive(30)
    assert len(robot.poses) == 10
    node.trigger_deactivate()
    started(robot, minimum_time_interval=0.35)
    robot.poses.clear()
    robot.drive(40)
    assert len(robot.poses) == 10


@pytest.mark.parametrize(("synchronous", "used"), [(True, 8), (False, 1)])
def test_waiting_scans_are_used_or_dropped(robot: Robot, synchronous: bool, used: int) -> None:
    node = started(robot, synchronous=synchronous)
    robot.drive(3)
    late = []
    for _ in range(8):
        robot.wait()
        robot.send(robot.scan())
        late.append((robot.odometry, robot.now))
    assert len(robot.poses) == 3
    for robot.odometry, robot.now in late:
        robot.send_odometry()
    robot.bench.advance(0.02)
    assert len(robot.poses) == 3 + used
    assert robot.error() < 0.03
    assert node.slam.scans.skipped == 0


def test_clear_queue_drops_the_scans_that_wait(robot: Robot) -> None:
    started(robot, synchronous=True)
    robot.drive(3)
    for _ in range(4):
        robot.wait()
        robot.send(robot.scan())
    assert robot.call(ClearQueue, "clear_queue").status
    robot.send_odometry()
    robot.bench.advance(0.04)
    assert len(robot.poses) == 3
    robot.drive(5)
    assert robot.error() < 0.03


def test_scans_without_a_reading_move_nothing(robot: Robot, logged: Logged) -> None:
    node = started(robot)
    send_spoilt(robot, ranges=[math.nan] * 360)
    assert node.slam.scans.counts[Skip.EMPTY] == node.slam.scans.skipped == 20
    assert len(logged.warnings) == 1
    assert Skip.EMPTY.value in logged.warnings[0]
    assert_continues(robot)


def test_where_nothing_is_in_range_odometry_carries_from_the_first_scan(robot: Robot) -> None:
    node = started(robot)
    send_spoilt(robot, ranges=[math.inf] * 360)
    assert node.slam.scans.skipped == 0
    assert len(robot.poses) == 25
    assert robot.error() < 0.05  # the odometry's, after 2 s
    robot.drive(5)
    assert robot.error() < 0.03


def test_scans_that_cannot_be_are_refused_reported_once_and_move_nothing(
    robot: Robot, logged: Logged
) -> None:
    node = started(robot)
    send_spoilt(robot, ranges=[])
    tally = node.guard.tallies[("/slam_toolbox", "/scan")]
    assert (tally.kind, tally.count) == ("refused", 20)
    assert len(logged.warnings) == 1
    assert "0 beams" in logged.warnings[0]
    assert_continues(robot)


def send_spoilt(robot: Robot, **fields: Any) -> None:
    """Drive, then send twenty scans with fields that are not as they should be."""
    robot.drive(5)
    for _ in range(20):
        robot.wait()
        robot.send_odometry()
        scan = robot.scan()
        for name, value in fields.items():
            setattr(scan, name, value)
        robot.send(scan)


def assert_continues(robot: Robot) -> None:
    assert len(robot.poses) == 5
    robot.drive(5)
    assert robot.error() < 0.03


def test_beam_counts_may_change_from_scan_to_scan(robot: Robot) -> None:
    node = started(robot)
    for k in range(40):
        robot.wait()
        robot.send_odometry()
        message = robot.scan()
        message.ranges = message.ranges[: 360 - 7 * k]
        robot.send(message)
    assert node.slam.scans.skipped == 0
    assert len(robot.poses) == 40
    assert robot.error() < 0.03


def test_scans_without_transforms_wait_then_are_dropped(robot: Robot, logged: Logged) -> None:
    started(robot)
    robot.drive(5)
    for _ in range(15):
        robot.wait()
        message = robot.scan()
        message.header.frame_id = "nowhere"
        robot.send(message)
    robot.drive(20)
    assert robot.error() < 0.03
    (warning,) = logged.warnings
    assert "no transform connects 'base_footprint' and 'nowhere'" in warning or "in time" in warning


def test_lifelong_and_short_range_reach_the_mapper(robot: Robot) -> None:
    node = started(robot, mode="lifelong", min_laser_range=2.5)
    robot.drive(30)
    session = node.slam.session()
    assert session is not None
    assert session.scans[0].range_min == 2.5
    assert robot.error() < 0.03


def test_a_lidar_mounted_upside_down_maps_the_same_room(robot: Robot) -> None:
    started(robot)
    mount = transform_msg(SE2(), "base_footprint", "lidar_link", 0.0)
    mount.transform.rotation.x, mount.transform.rotation.w = 1.0, 0.0
    robot.bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)
    for _ in range(40):
        robot.wait()
        robot.send_odometry()
        message = robot.scan()
        message.angle_min, message.angle_increment = -message.angle_min, -message.angle_increment
        robot.send(message)
    assert robot.error() < 0.03


def test_scans_are_processed_only_once_the_robot_has_moved_if_so_asked(robot: Robot) -> None:
    """As in slam_toolbox; the correction is dated on with every scan all the same."""
    node = started(robot, process_between_keyframes=False, transform_timeout=0.3)
    robot.drive(40)
    assert len(robot.poses) == len(node.slam.graph) < 20
    robot.bench.advance(0.06)
    assert seconds(robot.transforms[-1].header.stamp) == pytest.approx(robot.now + 0.3)


def test_frames_and_scales_of_what_is_published(robot: Robot) -> None:
    started(robot, map_frame="world", position_covariance_scale=0.0, resolution=0.1)
    robot.drive(12)
    pose, grid = robot.poses[-1], robot.maps[-1]
    assert (pose.header.frame_id, grid.header.frame_id) == ("world", "world")
    assert (pose.pose.covariance[0], grid.info.resolution) == (0.0, pytest.approx(0.1))


def test_scans_wait_for_the_odometry_that_is_asked_for(robot: Robot) -> None:
    started(robot, odom_frame="odometry")
    robot.drive(3)
    assert not robot.poses
