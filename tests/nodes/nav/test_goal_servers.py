"""The goals of every server of navigation: whatever ends one, its robot stands at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from nav2_msgs.action import (
    ComputeAndTrackRoute,
    ComputePathThroughPoses,
    ComputePathToPose,
    DockRobot,
    FollowPath,
    FollowWaypoints,
    SmoothPath,
)

from arjuna_core.ros.convert import path_msg
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL
from bringup.stack import (
    BEHAVIOR_SERVER,
    CONTROLLER_SERVER,
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    NAVIGATION_GROUP,
    PLANNER_SERVER,
    ROUTE_SERVER,
    SMOOTHER_SERVER,
    NodeSpec,
)
from tests.helpers.nav.navigation import (
    CANCELED,
    KINDS,
    UNKNOWN,
    Goal,
    PlayedRobot,
    assert_failed,
    start,
    started,
)
from tests.helpers.nav.navigator_goals import assert_stopped_for_good, go, stamped, through
from tests.helpers.nav.routes import written
from tests.nav.worlds import polyline

FAR = SE2(3.0, 1.0)


class Server(NamedTuple):
    """A server, how a goal is sent to it, its code for the unknown, and how long the goal runs."""

    node: str
    send: Callable[[PlayedRobot], Goal]
    unknown: int = 0
    specs: tuple[NodeSpec, ...] = NAVIGATION_GROUP.nodes
    lasts: float = 2.0


def sends(action: Any, name: str, **fields: Any) -> Callable[[PlayedRobot], Goal]:
    return lambda robot: robot.send(action, name, action.Goal(**fields))


PATH = path_msg(polyline([(0.0, 0.0), (2.0, 0.0)], 0.0), "map", 0.0)
PLANNING = (GLOBAL_COSTMAP, PLANNER_SERVER)
TO_POSE, THROUGH = "compute_path_to_pose", "compute_path_through_poses"
SERVERS = {
    "navigate_to_pose": Server("bt_navigator", lambda robot: go(robot, FAR)),
    "navigate_through_poses": Server("bt_navigator", lambda robot: through(robot, FAR, FAR)),
    "follow_waypoints": Server(
        "waypoint_follower",
        sends(FollowWaypoints, "follow_waypoints", poses=[stamped(FAR)]),
        FollowWaypoints.Result.UNKNOWN,
    ),
    "dock_robot": Server(
        "docking_server",
        sends(DockRobot, "dock_robot", dock_id="home"),
        DockRobot.Result.UNKNOWN,
        lasts=6.0,  # it approaches
    ),
    "follow_path": Server(
        "controller_server",
        sends(FollowPath, "follow_path", path=PATH),
        FollowPath.Result.UNKNOWN,
        (LOCAL_COSTMAP, CONTROLLER_SERVER),
    ),
    **{
        kind: Server(
            "behavior_server",
            lambda robot, kind=kind: start(robot, kind),  # type: ignore[misc]
            UNKNOWN[kind],
            (LOCAL_COSTMAP, BEHAVIOR_SERVER),
            lasts=0.5,
        )
        for kind in KINDS
    },
    "compute_and_track_route": Server(
        "route_server",
        sends(ComputeAndTrackRoute, "compute_and_track_route", start_id=0, goal_id=2),
        ComputeAndTrackRoute.Result.UNKNOWN,
        (ROUTE_SERVER,),
    ),
    TO_POSE: Server(
        "planner_server",
        sends(ComputePathToPose, TO_POSE, goal=stamped(FAR)),
        ComputePathToPose.Result.UNKNOWN,
        PLANNING,
        lasts=0.1,
    ),
    THROUGH: Server(
        "planner_server",
        sends(ComputePathThroughPoses, THROUGH, goals=[stamped(FAR)]),
        ComputePathThroughPoses.Result.UNKNOWN,
        PLANNING,
        lasts=0.1,
    ),
}
DOCK = {"docks": ["home"], "home.type": "simple_charging_dock", "home.pose": [1.2, 0.4, 0.3]}


@pytest.fixture
def robot(server: Server, tmp_path: Path) -> PlayedRobot:
    graph = {"graph_filepath": str(written(tmp_path))}
    robot = started(*server.specs, settle=0.0, docking_server=DOCK, route_server=graph)
    robot.localized = server.specs is not PLANNING  # a planner waits for the robot's pose
    robot.run(1.0)
    return robot


def sent(robot: PlayedRobot, server: Server) -> Goal:
    """Return a goal that has run for a while, from the start."""
    robot.pose = IDENTITY
    robot.run(0.1)
    goal = server.send(robot)
    robot.run(server.lasts)
    assert not goal.done
    robot.forget()
    return goal


def assert_aborted(goal: Goal, server: Server, reason: str) -> None:
    if hasattr(goal.result, "error_msg"):  # the routes' actions have none
        assert_failed(goal, server.unknown, reason)
    else:
        assert goal.result.error_code == server.unknown


@pytest.mark.parametrize("server", SERVERS.values(), ids=SERVERS)
def test_whatever_ends_a_goal_stops_the_robot(robot: PlayedRobot, server: Server) -> None:
    """A newer goal, a cancel, a set-back clock, the node's deactivation and its shutdown."""
    older = sent(robot, server)
    newer = server.send(robot)
    robot.run(0.1)
    assert_aborted(older, server, "replaced by a newer goal")
    assert not newer.done
    newer.cancel()
    assert newer.status == CANCELED
    assert_stopped_for_good(robot)

    goal = sent(robot, server)
    is_localized, robot.localized = robot.localized, False
    robot.bench.set_back()
    assert_aborted(goal, server, "time was set back")
    assert robot.command == STILL
    robot.localized = is_localized
    robot.run(1.0)

    goal = sent(robot, server)
    robot.transition(server.node, "deactivate")
    assert_aborted(goal, server, "the node was")
    assert_stopped_for_good(robot)
    assert not server.send(robot).accepted
    robot.transition(server.node, "activate")
    assert_stopped_for_good(robot)
    goal = server.send(robot)
    robot.run(0.1)
    robot.transition(server.node, "shutdown")
    assert_aborted(goal, server, "the node was")
    assert_stopped_for_good(robot)


def test_a_server_at_rest_takes_no_path_to_smooth() -> None:
    robot = started(GLOBAL_COSTMAP, SMOOTHER_SERVER)
    robot.transition("smoother_server", "deactivate")
    assert not robot.send(SmoothPath, "smooth_path", SmoothPath.Goal(path=PATH)).accepted
