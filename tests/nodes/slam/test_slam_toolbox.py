"""Claims: the slam_toolbox node speaks as slam_toolbox does and maps the test room."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("slam_toolbox")

from nav_msgs.srv import GetMap
from rclpy.parameter import Parameter
from slam_toolbox.srv import Pause, Reset, SaveMap
from std_msgs.msg import String
from std_srvs.srv import SetBool
from visualization_msgs.msg import MarkerArray

from arjuna_core.files.maps import load_map
from arjuna_core.ros.convert import grid_from_msg, se2_from_pose, seconds
from arjuna_core.se2 import SE2
from arjuna_slam.localization import Localizer
from tests.helpers.slam_robot import LOG, Robot, started
from tests.slam.slam_room import distance_to_walls, room

pytestmark = pytest.mark.ros


def test_the_pose_and_the_transform_follow_the_robot(robot: Robot) -> None:
    started(robot)
    robot.drive(60)
    truth = LOG[0][2].inverse() @ robot.truth
    assert se2_from_pose(robot.poses[-1].pose.pose).distance(truth) < 0.03
    assert robot.poses[-1].header.frame_id == "map"
    assert robot.poses[-1].pose.covariance[0] > 0.0
    pose = robot.bench.process.transforms.lookup("map", "base_footprint", robot.now)
    assert pose.distance(truth) < 0.03


def test_transforms_are_dated_past_their_scan_and_never_twice(robot: Robot) -> None:
    started(robot, transform_timeout=0.3)
    robot.drive(20)
    robot.bench.advance(0.06)
    stamps = [seconds(t.header.stamp) for t in robot.transforms]
    assert stamps[-1] == pytest.approx(robot.now + 0.3)
    assert len(stamps) == len(set(stamps))
    assert {t.child_frame_id for t in robot.transforms} == {"odom"}


def test_the_map_comes_with_the_first_scan_and_then_at_its_interval(robot: Robot) -> None:
    started(robot, map_update_interval=2.0)
    robot.drive(1)
    assert len(robot.maps) == len(robot.metadata) == 1
    robot.drive(49)
    assert len(robot.maps) == 3
    grid = grid_from_msg(robot.maps[-1])
    occupied = np.argwhere(grid.occupied()).astype(np.int64)
    points = LOG[0][2].apply(grid.frame.to_points(occupied))
    assert len(points) > 300
    assert distance_to_walls(room(), points).mean() < 0.03
    assert robot.metadata[-1].width == grid.frame.width


@pytest.mark.parametrize("always", [False, True])
def test_a_map_that_is_the_same_is_published_again_where_asked(robot: Robot, always: bool) -> None:
    started(robot, publish_unchanged_map=always)
    robot.drive(5)
    robot.call(Pause, "pause_new_measurements")
    robot.bench.advance(1.5)
    before = len(robot.maps)
    robot.bench.advance(5.0)
    assert len(robot.maps) - before == (5 if always else 0)


def test_mapping_stops_for_localization_and_continues(robot: Robot) -> None:
    node = started(robot)
    name, mode = "set_localization_mode", SetBool
    assert not robot.call(mode, name, data=True).success, "there is no map yet"
    robot.drive(30)
    answer = robot.call(mode, name, data=True)
    assert (answer.success, answer.message) == (True, "localization mode")
    count = len(node.slam.graph)
    robot.drive(20)
    assert isinstance(node.slam, Localizer)
    assert len(node.slam.graph) == count
    assert robot.error() < 0.03
    before = node.slam
    assert robot.call(mode, name, data=True).success
    assert node.slam is before, "it is in that mode"
    assert robot.call(mode, name, data=False).message == "mapping mode"
    robot.drive(20)
    assert len(node.slam.graph) > count
    assert robot.error() < 0.03


def test_a_robot_that_stands_still_does_not_publish_the_map_again(robot: Robot) -> None:
    started(robot, map_update_interval=1.0)
    robot.drive(1)
    robot.bench.advance(5.0)
    assert len(robot.maps) == 1


def test_a_map_is_saved_inside_the_open_folders_only(robot: Robot, tmp_path: Path) -> None:
    started(robot, maps_folder=str(tmp_path))
    no_map = SaveMap.Response.RESULT_NO_MAP_RECEIEVD
    assert robot.call(SaveMap, "save_map", name=String(data="room")).result == no_map
    robot.drive(30)
    saved = robot.call(SaveMap, "save_map", name=String(data="room"))
    assert saved.result == SaveMap.Response.RESULT_SUCCESS
    assert (load_map(tmp_path / "room.yaml").data == 100).sum() > 300
    outside = robot.call(SaveMap, "save_map", name=String(data="../room"))
    assert outside.result == SaveMap.Response.RESULT_UNDEFINED_FAILURE
    assert not (tmp_path.parent / "room.yaml").exists()


def test_dynamic_map_is_the_map(robot: Robot) -> None:
    started(robot)
    assert robot.call(GetMap, "dynamic_map").map.info.width == 0
    robot.drive(10)
    message = robot.call(GetMap, "dynamic_map").map
    assert message.header.frame_id == "map"
    assert 100 in message.data


def test_paused_it_takes_no_scan_in_and_goes_on_after(robot: Robot) -> None:
    node = started(robot)
    robot.drive(5)
    assert robot.call(Pause, "pause_new_measurements").status
    count = len(robot.poses)
    robot.drive(10)
    assert len(robot.poses) == count
    assert seconds(robot.transforms[-1].header.stamp) > robot.now
    robot.call(Pause, "pause_new_measurements")
    robot.drive(10)
    assert len(robot.poses) == count + 10
    truth = LOG[0][2].inverse() @ robot.truth
    assert se2_from_pose(robot.poses[-1].pose.pose).distance(truth) < 0.03
    assert node.slam.scans.skipped == 0


def test_reset_starts_a_new_map_at_the_robot(robot: Robot) -> None:
    node = started(robot)
    robot.drive(40)
    assert len(node.slam.graph) > 3
    assert robot.call(Reset, "reset").result == Reset.Response.RESULT_SUCCESS
    assert len(node.slam.graph) == 0
    robot.drive(1)
    assert se2_from_pose(robot.poses[-1].pose.pose) == SE2()
    assert robot.call(Reset, "reset", pause_new_measurements=True).result == 0
    robot.drive(2)
    assert len(node.slam.graph) == 0


def test_parameters_set_at_run_time_count_from_the_next_reset(robot: Robot) -> None:
    node = started(robot)
    robot.drive(10)
    names = ("minimum_travel_distance", "minimum_travel_heading")
    node.set_parameters([Parameter(name, value=100.0) for name in names])
    assert len(node.slam.graph) > 1
    robot.call(Reset, "reset")
    robot.drive(10)
    assert len(node.slam.graph) == 1


def test_the_graph_is_drawn_for_who_asks(robot: Robot) -> None:
    node = started(robot, map_update_interval=1.0)
    drawn = robot.bench.collect(MarkerArray, "/slam_toolbox/graph_visualization")
    robot.drive(30)
    nodes = drawn[-1].markers[0]
    assert 3 < len(nodes.points) <= len(node.slam.graph)
    assert nodes.header.frame_id == "map"


def test_a_clock_set_back_starts_a_new_map(robot: Robot) -> None:
    node = started(robot)
    robot.drive(20)
    node.on_time_jump()
    assert len(node.slam.graph) == 0
    assert node.slam.session() is None
