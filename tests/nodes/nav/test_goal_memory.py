"""Goals that outlive their process: kept in a file, resumed once the pose is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from nav2_msgs.action import FollowWaypoints

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import CANCELED, PlayedRobot, started
from tests.helpers.nav.navigator_goals import GOAL, TOLERANCE, drive, go, stamped, through

FAR = SE2(2.0, 1.0)


def kept_in(
    folder: Path, start: SE2 = IDENTITY, kept: bool = True, settle: float = 0.0
) -> PlayedRobot:
    """Return a robot whose goals are kept in a folder."""
    names = ("bt_navigator", "waypoint_follower") if kept else ()
    files: dict[str, Any] = {name: {"resume_file": str(folder / name)} for name in names}
    return started(*NAVIGATION_GROUP.nodes, start=start, settle=settle, **files)


def killed(robot: PlayedRobot) -> SE2:
    """End a robot's process as kill -9 does: no node notices; return the robot's pose."""
    robot.close()
    return robot.pose


def test_a_goal_is_resumed_by_the_next_process(tmp_path: Path) -> None:
    robot = kept_in(tmp_path, settle=1.0)
    go(robot, FAR)
    drive(robot)
    again = kept_in(tmp_path, killed(robot))
    again.localized = False
    again.run(2.0)
    assert again.commands == []
    again.localized = True
    again.run(15.0)
    assert again.pose.distance(FAR) < TOLERANCE
    assert again.command == STILL
    third = kept_in(tmp_path, killed(again))
    third.run(2.0)
    assert third.commands == []


def test_poses_before_the_last_are_resumed_with(tmp_path: Path) -> None:
    robot = kept_in(tmp_path, settle=1.0)
    through(robot, SE2(1.5, 0.5), FAR)
    drive(robot)
    again = kept_in(tmp_path, killed(robot))
    again.run(20.0)
    assert again.pose.distance(FAR) < TOLERANCE


def test_a_list_of_waypoints_is_resumed_where_it_was(tmp_path: Path) -> None:
    robot = kept_in(tmp_path, settle=1.0)
    poses = [stamped(pose) for pose in (SE2(0.5, 0.0), FAR, SE2(1.0, 0.0, 1.0))]
    goal = robot.send(FollowWaypoints, "follow_waypoints", FollowWaypoints.Goal(poses=poses))
    while goal.feedback[-1:] == [] or goal.feedback[-1].current_waypoint == 0:
        robot.run(0.2)
    robot.run(2.0)
    again = kept_in(tmp_path, killed(robot))
    for place in (FAR, SE2(1.0, 0.0)):
        for _ in range(150):
            again.run(0.2)
            if again.pose.distance(place) < TOLERANCE:
                break
        assert again.pose.distance(place) < TOLERANCE


@pytest.mark.parametrize("how", ["reached", "cancelled", "deactivated", "not asked for"])
def test_what_has_ended_is_not_resumed(tmp_path: Path, how: str) -> None:
    robot = kept_in(tmp_path, kept=how != "not asked for", settle=1.0)
    goal = go(robot, SE2(0.4, 0.0) if how == "reached" else FAR)
    if how == "reached":
        robot.succeed(goal, 5.0)
    else:
        robot.run(1.0)
    if how == "cancelled":
        goal.cancel()
        assert goal.status == CANCELED
    if how == "deactivated":
        robot.transition("bt_navigator", "deactivate")
    again = kept_in(tmp_path, killed(robot))
    again.run(1.5)
    assert again.commands == []


def test_time_set_back_is_survived_where_that_is_asked_for(tmp_path: Path) -> None:
    robot = kept_in(tmp_path, settle=1.0)
    goal = go(robot, GOAL)
    drive(robot)
    robot.localized = False
    robot.bench.set_back()
    assert robot.command == STILL
    robot.run(3.0)
    assert not goal.done
    robot.localized = True
    count = len(goal.feedback)
    robot.run(1.0)
    assert len(goal.feedback) > count + 5
    robot.succeed(goal, 20.0)
    assert robot.pose.distance(GOAL) < TOLERANCE


def test_a_list_of_waypoints_survives_time_set_back(tmp_path: Path) -> None:
    robot = kept_in(tmp_path, settle=1.0)
    poses = [stamped(GOAL), stamped(SE2(0.0, 1.0))]
    goal = robot.send(FollowWaypoints, "follow_waypoints", FollowWaypoints.Goal(poses=poses))
    drive(robot)
    robot.bench.set_back()
    robot.succeed(goal, 30.0)
    assert len(goal.result.missed_waypoints) == 0
