"""Nav2's own behaviour with `--as-nav2`, and goals reached with stock parameter files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from nav2_msgs.action import FollowWaypoints

from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from bringup.parameters.files import load_parameters, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.sources import as_theirs
from bringup.stack import NAVIGATION_GROUP, VELOCITY_SMOOTHER, all_nodes
from tests.helpers.nav.navigation import ABORTED, SUCCEEDED, PlayedRobot, started
from tests.helpers.nav.navigator_goals import go
from tests.helpers.nav.stock_files import FILES

A, B, OUTSIDE = SE2(0.4), SE2(0.8), SE2(9.0)


def stock(**parameters: Any) -> PlayedRobot:
    values: dict[str, Any] = as_theirs(parameters, NAVIGATION_GROUP.nodes, replaces=False)
    return started(*NAVIGATION_GROUP.nodes, **values)


# WaypointFollower::followWaypointsHandler: poses from goal_index on, number_of_loops rounds more, a
# pose that fails is missed, and the end where stop_on_failure says so; the task after each arrival
@pytest.mark.parametrize(
    ("poses", "fields", "values", "status", "missed", "visited"),
    [
        ((A, B), {}, {}, SUCCEEDED, [], [0, 1]),
        ((A, B), {"number_of_loops": 1}, {}, SUCCEEDED, [], [0, 1, 0, 1]),
        ((A, B), {"goal_index": 1}, {}, SUCCEEDED, [], [1]),
        ((OUTSIDE, A), {}, {"stop_on_failure": False}, SUCCEEDED, [0], [0, 1]),
        ((OUTSIDE, A), {}, {"stop_on_failure": True}, ABORTED, [0], [0]),
    ],
)
def test_waypoints(
    poses: tuple[SE2, ...],
    fields: dict[str, int],
    values: dict[str, Any],
    status: int,
    missed: list[int],
    visited: list[int],
) -> None:
    robot = stock(waypoint_follower=values)
    stamped = [pose_stamped(pose, "map", 0.0) for pose in poses]
    request = FollowWaypoints.Goal(poses=stamped, **fields)
    goal = robot.send(FollowWaypoints, "follow_waypoints", request)
    robot.run_until_done(goal, 60.0)
    named = [each.current_waypoint for each in goal.feedback]
    assert goal.status == status
    assert [each.index for each in goal.result.missed_waypoints] == missed
    assert [k for i, k in enumerate(named) if named[i - 1 : i] != [k]] == visited
    if status == SUCCEEDED:  # within xy_goal_tolerance, and nothing drives on
        assert 0.01 < robot.pose.distance(poses[-1]) <= 0.25


def test_a_command_is_smoothed_at_the_smoothers_rate_alone() -> None:
    given = {"velocity_smoother": {"cmd_vel_out_topic": "cmd_vel", "max_accel": [2.5, 0.0, 3.2]}}
    values: dict[str, Any] = as_theirs(given, [VELOCITY_SMOOTHER], replaces=False)
    robot = started(VELOCITY_SMOOTHER, settle=0.5, **values)
    message = Twist()
    message.linear.x = 0.4
    robot.bench.publish(Twist, "/cmd_vel_nav", message)
    assert not robot.commands  # smootherTimer has yet to run
    robot.run(0.25)
    # 2.5 / 20 = 0.125 a tick of 50 ms
    assert [each.x for each in robot.commands[:4]] == pytest.approx([0.125, 0.25, 0.375, 0.4])


@pytest.mark.parametrize("name", ["Jazzy's nav2_params", "TurtleBot3 on Humble"])
def test_a_goal_is_reached(name: str, tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(FILES[name], encoding="utf-8")
    given = load_parameters([path])
    parameters = understand(given, shipped_parameters(), all_nodes()).parameters
    robot = PlayedRobot(parameters, shipped=False)
    robot.bring_up(*NAVIGATION_GROUP.nodes)
    robot.send_map()
    robot.run(1.0)
    goal = go(robot, SE2(1.5, 1.5, 0.5))
    robot.run_until_done(goal, 30.0)
    assert goal.status == SUCCEEDED, goal.result.error_msg
    assert robot.pose.distance(SE2(1.5, 1.5)) < 0.25
