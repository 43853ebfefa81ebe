"""Claims: the slam_toolbox node speaks as slam_toolbox does and maps the test room."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMap
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.parameter import Parameter
from sensor_msgs.msg import LaserScan
from slam_toolbox.srv import (
    Clear,
    DeserializePoseGraph,
    LoopClosure,
    Pause,
    Reset,
    SaveMap,
    SerializePoseGraph,
    ToggleInteractive,
)
from std_msgs.msg import String
from std_srvs.srv import SetBool
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate, MarkerArray
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.files.maps import load_map
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, pose_msg, se2_from_pose, seconds
from arjuna_core.se2 import SE2
from arjuna_slam.localization import Localizer
from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode
from tests.helpers.ros import RosBench
from tests.helpers.slam_robot import DT, LOG, Robot, started
from tests.slam.slam_room import distance_to_walls, room


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


def test_restamped_transforms_come_at_their_own_rate_and_not_the_lidar_s(robot: Robot) -> None:
    started(robot, restamp_tf=True, transform_publish_period=0.02)
    robot.drive(3)
    before = len(robot.transforms)
    for _ in range(50):  # no scan comes
        robot.bench.advance(0.02)
    stamps = [seconds(t.header.stamp) for t in robot.transforms[before:]]
    assert len(stamps) == len(set(stamps)) == 50
    assert stamps[-1] == pytest.approx(robot.bench.process.now + 0.2, abs=0.02)


@pytest.mark.parametrize("left_out", [{"minimum_time_interval": 0.5}, {"throttle_scans": 4}])
def test_transforms_are_dated_past_scans_that_are_left_out(
    robot: Robot, left_out: dict[str, float]
) -> None:
    """As slam_toolbox's; its own files have 0.5 s between scans, and 0.2 s past them."""
    started(robot, transform_timeout=0.2, **left_out)
    for _ in range(20):
        robot.drive(1)
        robot.bench.advance(0.06)
        assert seconds(robot.transforms[-1].header.stamp) == pytest.approx(robot.now + 0.2, abs=0.1)
    assert len(robot.poses) < 10


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


def test_who_asks_for_no_latched_map_gets_it_at_its_interval(robot: Robot) -> None:
    """As programs that explore do: `create_subscription(OccupancyGrid, '/map', callback, 10)`."""
    started(robot, map_update_interval=1.0)
    robot.drive(5)
    robot.call(Pause, "pause_new_measurements")
    robot.bench.advance(1.5)
    heard = robot.bench.collect(OccupancyGrid, "/map", qos.DEFAULT)
    assert heard == []
    robot.bench.advance(3.0)
    assert len(heard) == 3
    assert heard[0].data == robot.maps[-1].data


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


def test_paused_it_takes_no_scan_and_resumes_after(robot: Robot) -> None:
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


def test_reset_starts_a_new_map_where_odometry_is(robot: Robot) -> None:
    node = started(robot)
    robot.drive(40)
    assert len(node.slam.graph) > 3
    assert robot.call(Reset, "reset").result == Reset.Response.RESULT_SUCCESS
    assert len(node.slam.graph) == 0
    robot.drive(1)
    pose = se2_from_pose(robot.poses[-1].pose.pose)
    assert pose.distance(robot.odometry) == pytest.approx(0.0, abs=1e-9)
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


DOWN = 10  # scans that nobody hears


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "slam_toolbox"


@pytest.fixture
def killed(robot: Robot, file: Path) -> SlamToolboxNode:
    """A mapper that has kept its map; no node learns that the process ends."""
    node = started(robot, resume_file=str(file), maps_folder=str(file.parent))
    robot.drive(55)
    node.memory.settle()
    return node


@pytest.fixture
def next_process(robot: Robot) -> Iterator[Robot]:
    """The robot as the next process meets it, which has driven on and is elsewhere by now."""
    bench = RosBench()
    later = Robot(bench)
    yield later
    bench.close()


def drive_on(robot: Robot, later: Robot, count: int = 10) -> None:
    """Let the robot be where it came to meanwhile, and drive on."""
    later.k, later.now = robot.k + DOWN, robot.now + DOWN * DT
    later.bench.advance(later.now)
    later.drive(count)


def test_the_next_process_resumes_map_and_pose(
    robot: Robot, killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    again = started(next_process, resume_file=str(file))
    nodes = len(again.slam.graph)
    assert nodes > 5
    drive_on(robot, next_process)
    assert len(next_process.poses) == 10
    assert next_process.error() < 0.05
    assert len(again.slam.graph) > nodes
    again.memory.settle()
    assert file.is_file()


def test_a_process_that_dies_before_its_first_scan_leaves_the_map_to_the_next(
    killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    before = file.read_bytes()
    started(next_process, resume_file=str(file))
    next_process.bench.advance(6.0)
    assert file.read_bytes() == before


def test_a_damaged_file_is_refused_with_an_error_and_a_new_map_begins(
    robot: Robot,
    killed: SlamToolboxNode,
    file: Path,
    next_process: Robot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    errors: list[str] = []
    monkeypatch.setattr(RcutilsLogger, "error", lambda self, text: errors.append(text))
    file.write_bytes(file.read_bytes()[:-100])
    again = started(next_process, resume_file=str(file))
    assert len(errors) == 1
    assert "a new map begins" in errors[0]
    assert "cut short" in errors[0]
    assert len(again.slam.graph) == 0
    drive_on(robot, next_process, 3)
    assert len(next_process.poses) == 3


def test_a_clock_that_was_set_back_meanwhile_begins_a_new_map(
    killed: SlamToolboxNode, file: Path, next_process: Robot
) -> None:
    again = started(next_process, resume_file=str(file))
    assert len(again.slam.graph) > 5
    next_process.drive(1)
    assert len(again.slam.graph) == 1
    assert not file.exists()


@pytest.mark.parametrize("how", ["reset", "deactivated", "another map"])
def test_a_map_that_was_given_up_is_not_resumed(
    robot: Robot, killed: SlamToolboxNode, file: Path, how: str
) -> None:
    assert file.is_file()
    if how == "reset":
        robot.call(Reset, "reset")
    if how == "deactivated":
        killed.trigger_deactivate()
    if how == "another map":
        robot.call(SerializePoseGraph, "serialize_map", filename="room")
        robot.call(DeserializePoseGraph, "deserialize_map", filename="room", match_type=1)
    assert not file.exists()


def test_a_map_is_kept_only_where_that_is_asked_for(robot: Robot, tmp_path: Path) -> None:
    node = started(robot, maps_folder=str(tmp_path))
    robot.drive(55)
    node.memory.settle()
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_takes_nothing_does_not_end_the_mapping(robot: Robot, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    node = started(robot, resume_file=str(tmp_path / "file/slam_toolbox"))
    robot.drive(70)
    node.memory.settle()
    assert robot.error() < 0.03


def test_keyframes_can_be_moved_by_hand_and_are_put_back(robot: Robot) -> None:
    node = started(robot)
    robot.drive(60)
    updates = robot.bench.collect(InteractiveMarkerUpdate, "/slam_toolbox/update")
    scans = robot.bench.collect(LaserScan, "/slam_toolbox/scan_visualization", qos.DEFAULT)
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    assert len(updates[-1].markers) == len(node.slam.graph)
    count = len(robot.poses)
    robot.drive(3)
    assert len(robot.poses) == count  # the graph does not change under the hand
    where = node.slam.graph.pose(5) @ SE2(0.3, 0.1, 0.0)
    feedback = InteractiveMarkerFeedback(
        marker_name="5", pose=pose_msg(where), event_type=InteractiveMarkerFeedback.MOUSE_UP
    )
    before = node.slam.graph.poses.copy()
    for action in (Clear, LoopClosure):
        robot.bench.publish(InteractiveMarkerFeedback, "/slam_toolbox/feedback", feedback)
        listed = robot.call(GetInteractiveMarkers, "get_interactive_markers")
        assert listed.markers[5].pose.position.x == pytest.approx(where.x)
        name = "clear_changes" if action is Clear else "manual_loop_closure"
        robot.call(action, name)
        listed = robot.call(GetInteractiveMarkers, "get_interactive_markers")
        assert listed.markers[5].pose.position.x == pytest.approx(before[5, 0], abs=0.02)
    assert scans[-1].header.frame_id == "scan_visualization"
    assert np.abs(node.slam.graph.poses - before).max() < 0.02  # it did not fit there
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    assert len(updates[-1].erases) == len(node.slam.graph)
    robot.drive(3)
    assert robot.error() < 0.03


@pytest.mark.parametrize("mode", ["mapping", "localization"])
def test_the_interactive_mode_is_off_until_it_is_toggled(robot: Robot, mode: str) -> None:
    started(robot, enable_interactive_mode=True, mode=mode)
    robot.drive(5)
    assert len(robot.maps) == 1
    assert len(robot.poses) == 5
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    robot.drive(5)
    assert len(robot.poses) == 5
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    robot.drive(5)
    assert len(robot.poses) == 10


def test_where_it_is_not_allowed_nothing_is_toggled_closed_or_cleared(robot: Robot) -> None:
    started(robot, enable_interactive_mode=False)
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    robot.call(LoopClosure, "manual_loop_closure")
    robot.call(Clear, "clear_changes")
    robot.drive(5)
    assert len(robot.poses) == 5


def test_feedback_of_no_keyframe_or_no_pose_is_ignored(robot: Robot) -> None:
    node = started(robot, enable_interactive_mode=True)
    robot.call(Pause, "pause_new_measurements")
    for name in ("99", "-1", "all", ""):
        message = InteractiveMarkerFeedback(marker_name=name, event_type=5)
        robot.bench.publish(InteractiveMarkerFeedback, "/slam_toolbox/feedback", message)
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    robot.call(Pause, "pause_new_measurements")
    robot.drive(5)
    robot.call(ToggleInteractive, "toggle_interactive_mode")
    broken = InteractiveMarkerFeedback(marker_name="0", event_type=5)
    broken.pose.position.x = math.nan
    robot.bench.publish(InteractiveMarkerFeedback, "/slam_toolbox/feedback", broken)
    robot.call(LoopClosure, "manual_loop_closure")
    assert np.isfinite(node.slam.graph.poses).all()
