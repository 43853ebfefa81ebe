"""planner_server: paths, every error code, and what it does while its costmap is not current."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputePathThroughPoses, ComputePathToPose
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import Path

from arjuna_core.ros.convert import path_msg, poses_from_path, seconds
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from bringup.stack import GLOBAL_COSTMAP, PLANNER_SERVER
from tests.helpers.nav.navigation import (
    ABORTED,
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    started,
)
from tests.helpers.nav.navigator_goals import IN_BOX, IN_RING, broken, stamped, walled_room
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of

Result = ComputePathToPose.Result
ResultThrough = ComputePathThroughPoses.Result
GOAL = SE2(2.0, 2.0, 1.0)


def made() -> PlayedRobot:
    return started(GLOBAL_COSTMAP, PLANNER_SERVER, world=walled_room(), settle=0.0)


def to_pose(robot: PlayedRobot, goal: SE2 | PoseStamped = GOAL, **fields: Any) -> Goal:
    pose = stamped(goal) if isinstance(goal, SE2) else goal
    request = ComputePathToPose.Goal(goal=pose, **fields)
    return robot.send(ComputePathToPose, "compute_path_to_pose", request)


def through(robot: PlayedRobot, *goals: SE2 | PoseStamped, **fields: Any) -> Goal:
    poses = [stamped(goal) if isinstance(goal, SE2) else goal for goal in goals]
    request = ComputePathThroughPoses.Goal(goals=poses, **fields)
    return robot.send(ComputePathThroughPoses, "compute_path_through_poses", request)


def test_a_path_leads_from_the_robot_to_the_goal_and_is_published(robot: PlayedRobot) -> None:
    published = robot.bench.collect(Path, "/plan")
    robot.run(1.0)
    goal = to_pose(robot)
    assert goal.status == SUCCEEDED
    assert (goal.result.error_code, goal.result.error_msg) == (Result.NONE, "")
    poses = poses_from_path(goal.result.path)
    assert poses[0, :2] == pytest.approx((0.0, 0.0))
    assert poses[-1] == pytest.approx(GOAL.array())
    assert goal.result.path.header.frame_id == "map"
    assert [message.poses for message in published] == [goal.result.path.poses]


# a wall with a gap of 0.4 m in front, behind which a second wall stands, and one of 1 m aside
WALLS = grid_of(
    *(12.0, 12.0, (7.5, 0.0, 0.2, 5.8), (7.5, 6.2, 0.2, 4.8), (8.1, 5.1, 0.2, 1.8)),
    origin=SE2(-6.0, -6.0),
)


@pytest.mark.parametrize("fits", [True, False])
def test_a_path_fits_the_outline_unless_the_planner_has_the_last_word(fits: bool) -> None:
    long = np.array([[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]])
    values: dict[str, Any] = {
        "global_costmap/global_costmap": {"footprint": str(long.tolist())},
        "planner_server": {"fit_outline": fits},
    }
    robot = started(GLOBAL_COSTMAP, PLANNER_SERVER, world=WALLS, **values)
    path = poses_from_path(to_pose(robot, SE2(4.0)).result.path)
    collision = first_collision(costmap_of(WALLS), Footprint.polygon(long), path)
    assert (collision is None) == fits


def test_the_start_counts_only_with_use_start(robot: PlayedRobot) -> None:
    robot.run(1.0)
    start = stamped(SE2(-2.0, 1.0))
    used = to_pose(robot, start=start, use_start=True)
    unused = to_pose(robot, start=start, use_start=False)
    assert poses_from_path(used.result.path)[0, :2] == pytest.approx((-2.0, 1.0))
    assert poses_from_path(unused.result.path)[0, :2] == pytest.approx((0.0, 0.0))


def test_poses_of_other_frames_are_brought_into_the_map(robot: PlayedRobot) -> None:
    robot.pose = SE2(1.0, 0.0, np.pi / 2.0)
    robot.run(1.0)
    goal = to_pose(robot, stamped(SE2(1.0, 0.0), "base_link"))
    assert poses_from_path(goal.result.path)[-1] == pytest.approx((1.0, 1.0, np.pi / 2.0))


def test_a_path_through_poses_passes_each_in_turn(robot: PlayedRobot) -> None:
    robot.run(1.0)
    stops = SE2(2.0, 1.5), SE2(-2.0, 1.5), SE2(-2.0, -1.0, 0.3)
    goal = through(robot, *stops)
    assert goal.status == SUCCEEDED
    poses = poses_from_path(goal.result.path)
    nearest = [np.hypot(*(poses[:, :2] - (stop.x, stop.y)).T).argmin() for stop in stops]
    assert nearest == sorted(nearest)
    for stop, index in zip(stops, nearest, strict=True):
        assert np.hypot(*(poses[index, :2] - (stop.x, stop.y))) < 0.05
    assert poses[-1] == pytest.approx(stops[-1].array())


FAILURES: list[tuple[int, dict[str, Any]]] = [
    (Result.INVALID_PLANNER, {"goal": GOAL, "planner_id": "Best"}),
    (Result.TF_ERROR, {"goal": stamped(GOAL, "moon")}),
    (Result.TF_ERROR, {"goal": broken()}),
    (Result.START_OUTSIDE_MAP, {"goal": GOAL, "start": stamped(SE2(9.0, 0.0)), "use_start": True}),
    (Result.GOAL_OUTSIDE_MAP, {"goal": SE2(0.0, -7.0)}),
    (Result.NO_VALID_PATH, {"goal": GOAL, "start": stamped(IN_BOX), "use_start": True}),
    (Result.GOAL_OCCUPIED, {"goal": IN_BOX}),
    (Result.NO_VALID_PATH, {"goal": IN_RING}),
]


def test_what_cannot_be_planned_fails_with_its_code(robot: PlayedRobot) -> None:
    robot.run(1.0)
    for code, fields in FAILURES:
        assert_failed(to_pose(robot, **fields), code)
        stops = (SE2(1.0, 0.0), fields["goal"])
        if fields.get("use_start"):
            stops = (GOAL, GOAL)
        others = {name: value for name, value in fields.items() if name != "goal"}
        assert_failed(through(robot, *stops, **others), code + 100)


def test_what_sensors_see_on_a_goal_may_leave_it_and_is_no_end_at_once() -> None:
    exactly: dict[str, Any] = {"planner_server": {"GridBased.tolerance": 0.0}}
    robot = started(GLOBAL_COSTMAP, PLANNER_SERVER, world=walled_room(), **exactly)
    free = robot.world.data.copy()
    block(robot.world, 7.35, 7.35, 0.3, 0.3)
    robot.run(1.0)
    assert_failed(to_pose(robot, GOAL), Result.NO_VALID_PATH)
    assert_failed(through(robot, SE2(1.0, 0.0), GOAL), ResultThrough.NO_VALID_PATH)
    robot.world.data[:] = free
    robot.bench.process.find("global_costmap/global_costmap").layered.clear_entirely()
    assert to_pose(robot, GOAL).status == SUCCEEDED


def test_no_poses_are_a_logged_error(robot: PlayedRobot, capfd: pytest.CaptureFixture[str]) -> None:
    robot.run(1.0)
    assert_failed(through(robot), ResultThrough.NO_VIAPOINTS_GIVEN)
    assert "compute_path_through_poses: goal aborted: 0 goals were" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("plugin", "radius", "logged"),
    [
        ("nav2_navfn_planner::NavfnPlanner", 0.6, "planner GridBased turns on the spot, but"),
        ("nav2_smac_planner::SmacPlannerHybrid", 0.6, "planner GridBased bends by 0.4 m, but the"),
        ("nav2_smac_planner::SmacPlannerHybrid", 0.4, ""),
        ("nav2_navfn_planner::NavfnPlanner", 0.0, ""),
    ],
)
def test_a_planner_that_bends_tighter_than_the_robot_can_is_reported(
    capfd: pytest.CaptureFixture[str], plugin: str, radius: float, logged: str
) -> None:
    own = {"GridBased.plugin": plugin, "min_turning_radius": radius}
    nodes = GLOBAL_COSTMAP, PLANNER_SERVER
    robot = started(*nodes, world=walled_room(), settle=1.0, planner_server=own)
    assert to_pose(robot).status == SUCCEEDED
    text = capfd.readouterr().err
    assert logged in text
    assert ("tightest bend" in text) is bool(logged)


@pytest.mark.parametrize(
    ("ask", "code"), [(to_pose, Result.TIMEOUT), (through, ResultThrough.TIMEOUT)]
)
def test_a_costmap_not_current_is_a_timeout(robot: PlayedRobot, ask: Any, code: int) -> None:
    robot.localized = False
    robot.run(1.0)
    goal = ask(robot, GOAL)
    robot.run(0.8)
    assert not goal.done
    robot.run(0.5)
    assert_failed(goal, code, "global_costmap")
    assert "map" in goal.result.error_msg


def test_a_goal_waits_for_the_costmap_to_become_current(robot: PlayedRobot) -> None:
    goal = to_pose(robot)
    assert not goal.done
    robot.succeed(goal, 0.9)
    assert 0.1 < seconds(goal.result.planning_time) < 0.9


def test_each_action_waits_for_its_own_time(robot: PlayedRobot) -> None:
    robot.localized = False
    robot.run(0.2)
    first = to_pose(robot)
    robot.run(0.7)
    second = through(robot, GOAL)
    robot.run(0.5)
    assert_failed(first, Result.TIMEOUT)
    assert not second.done
    robot.run(0.7)
    assert_failed(second, ResultThrough.TIMEOUT)


def test_newer_goals_replace_those_that_wait(robot: PlayedRobot) -> None:
    goals = [to_pose(robot) for _ in range(4)]
    robot.run(0.9)
    assert [goal.status for goal in goals] == [ABORTED, ABORTED, ABORTED, SUCCEEDED]
    assert_failed(goals[0], Result.UNKNOWN)
    older, newer = through(robot, GOAL), through(robot, GOAL)
    assert [older.status, newer.status] == [SUCCEEDED, SUCCEEDED]


def test_a_costmap_that_rests_is_a_timeout(robot: PlayedRobot) -> None:
    robot.run(1.0)
    robot.transition("global_costmap/global_costmap", "deactivate")
    robot.fail(to_pose(robot), 1.5, Result.TIMEOUT, "not active")


def test_a_map_that_grows_is_planned_on() -> None:
    robot = PlayedRobot()
    robot.bring_up(GLOBAL_COSTMAP, PLANNER_SERVER)
    robot.fail(to_pose(robot), 2.0, Result.TIMEOUT, "no map")
    robot.send_map(empty_grid(3.0, 3.0, SE2(-1.5, -1.5)))
    robot.run(1.0)
    assert_failed(to_pose(robot), Result.GOAL_OUTSIDE_MAP)
    robot.send_map()
    robot.run(1.0)
    assert to_pose(robot).status == SUCCEEDED


def valid(robot: PlayedRobot, path: Path) -> Any:
    return robot.bench.call(IsPathValid, "is_path_valid", IsPathValid.Request(path=path))


def straight(x0: float, x1: float, y: float) -> np.ndarray[Any, Any]:
    xs = np.arange(x0, x1, 0.1)
    return np.column_stack((xs, np.full_like(xs, y), np.zeros_like(xs)))


def test_is_path_valid_looks_at_what_is_ahead_of_the_robot(robot: PlayedRobot) -> None:
    robot.run(1.0)
    assert valid(robot, path_msg(straight(-1.0, 2.0, 1.0), "map", 0.0)).is_valid
    into_wall = valid(robot, path_msg(straight(-1.0, 6.0, 0.8), "map", 0.0))
    assert not into_wall.is_valid
    (index,) = into_wall.invalid_pose_indices
    assert -1.0 + 0.1 * index == pytest.approx(4.8, abs=0.21)  # wall at 5 less the robot
    from_wall = straight(-6.0, 2.0, 0.8)  # the wall is behind the robot
    assert valid(robot, path_msg(from_wall, "map", 0.0)).is_valid


def test_is_path_valid_says_no_to_what_is_no_path(robot: PlayedRobot) -> None:
    assert not valid(robot, path_msg(straight(-1.0, 2.0, 1.0), "map", 0.0)).is_valid  # no costmap
    robot.run(1.0)
    assert not valid(robot, path_msg(straight(-1.0, 2.0, 1.0), "moon", 0.0)).is_valid
    assert not valid(robot, Path()).is_valid
    bad = path_msg(straight(-1.0, 2.0, 1.0), "map", 0.0)
    bad.poses[3].pose.position.y = float("inf")
    assert not valid(robot, bad).is_valid


def test_is_path_valid_reads_the_path_in_its_own_frame(robot: PlayedRobot) -> None:
    robot.pose = SE2(0.0, 0.0, np.pi)
    robot.run(1.0)
    ahead = path_msg(straight(0.0, 7.0, 0.0), "base_link", 0.0)
    (index,) = valid(robot, ahead).invalid_pose_indices
    assert 0.1 * index == pytest.approx(4.8, abs=0.21)
