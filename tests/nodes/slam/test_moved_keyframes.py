"""Claims: keyframes can be moved by hand, and only such moves are taken."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("slam_toolbox")

from sensor_msgs.msg import LaserScan
from slam_toolbox.srv import Clear, LoopClosure, Pause, ToggleInteractive
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_msg
from arjuna_core.se2 import SE2
from tests.helpers.slam_robot import Robot, started

pytestmark = pytest.mark.ros


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
