"""Servers alone in a process: costs and outlines come by the topics that parameters name."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PolygonStamped, Twist
from nav2_msgs.action import BackUp, DockRobot, DriveOnHeading, SmoothPath
from nav2_msgs.msg import Costmap as CostmapMsg
from nav2_msgs.msg import CostmapUpdate

from arjuna_core.grid import GridFrame
from arjuna_core.ros import qos
from arjuna_core.ros.convert import path_msg, pose_stamped
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import STILL
from arjuna_nav.costmap.costmap import LETHAL, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.nodes.behavior_actions import BACKUP
from arjuna_nav.nodes.costmap.messages import (
    costmap_raw_msg,
    costmap_raw_update_msg,
    polygon_msg,
)
from bringup.stack import (
    BEHAVIOR_SERVER,
    COLLISION_MONITOR,
    DOCKING_SERVER,
    SMOOTHER_SERVER,
    NodeSpec,
)
from tests.helpers.nav.navigation import (
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    backup,
    drive,
    started,
    wall_ahead,
)
from tests.nav.worlds import polyline

IN_MAP = dataclasses.replace(BACKUP, area="global")
BODY = Footprint.polygon(np.array([[0.2, 0.15], [0.2, -0.15], [-0.2, -0.15], [-0.2, 0.15]]))


class Elsewhere:
    """A costmap in another process, as Nav2's: whole once, then its changes and the outline."""

    def __init__(self, robot: PlayedRobot, costs: str, outline: str, frame: str) -> None:
        self._robot, self._costs, self._outline, self._frame = robot, costs, outline, frame
        grid = GridFrame(0.05, 160, 160, SE2(-4.0, -4.0))
        self.costmap = Costmap(grid, np.zeros(grid.shape, np.uint8))
        self.body = BODY

    def publish(self) -> None:
        message = costmap_raw_msg(self.costmap, self._frame, self._robot.now)
        self._robot.bench.publish(CostmapMsg, self._costs, message, qos.LATCHED)
        self.live()

    def live(self) -> None:
        outline = polygon_msg(self.body.at(self._robot.pose), self._frame, self._robot.now)
        self._robot.bench.publish(PolygonStamped, self._outline, outline, qos.DEFAULT)

    def wall(self, x: float) -> None:
        """Mark a wall across x [m], without publishing it."""
        column = self.costmap.frame.to_cell(x, 0.0)[1]
        self.costmap.data[:, column] = LETHAL

    def update(self, x: float) -> None:
        """Publish only the columns round a wall."""
        column = self.costmap.frame.to_cell(x, 0.0)[1]
        window = slice(0, self.costmap.frame.height), slice(column - 3, column + 4)
        message = costmap_raw_update_msg(self.costmap, window, self._frame, self._robot.now)
        self._robot.bench.publish(CostmapUpdate, f"{self._costs}_updates", message, qos.LATCHED)

    def run(self, duration: float) -> None:
        """Let time pass [s] while it publishes its outline five times a second."""
        for _ in range(round(duration / 0.2)):
            self.live()
            self._robot.run(0.2)

    def run_until_done(self, goal: Goal) -> None:
        for _ in range(100):
            if not goal.done:
                self.run(0.2)
        assert goal.done


def alone(
    spec: NodeSpec, side: str = "local", frame: str = "odom", **values: Any
) -> tuple[PlayedRobot, Elsewhere]:
    robot = PlayedRobot({spec.name: values})
    robot.bring_up(spec)
    robot.run(0.4)
    topics = f"/{side}_costmap/costmap_raw", f"/{side}_costmap/published_footprint"
    return robot, Elsewhere(robot, *topics, frame)


def test_a_behaviour_waits_for_costs_and_an_outline() -> None:
    robot, costmap = alone(BEHAVIOR_SERVER)
    assert_failed(drive(robot, 0.5, 0.2), 720)
    costmap.publish()
    goal = drive(robot, 0.5, 0.2)
    costmap.run_until_done(goal)
    assert goal.status == SUCCEEDED
    assert robot.pose.x == pytest.approx(0.5, abs=0.04)


def test_a_behaviour_without_an_outline_says_so() -> None:
    robot, costmap = alone(BEHAVIOR_SERVER, local_footprint_topic="elsewhere/outline")
    costmap.publish()
    goal = drive(robot, 0.5, 0.2)
    robot.run(0.2)
    assert_failed(goal, DriveOnHeading.Result.TF_ERROR)
    assert "no footprint has come on 'elsewhere/outline'" in goal.result.error_msg


@pytest.mark.parametrize("late", [False, True])
def test_a_behaviour_stops_before_what_costs_or_their_changes_show(late: bool) -> None:
    robot, costmap = alone(BEHAVIOR_SERVER)
    if not late:
        costmap.wall(1.0)
    costmap.publish()
    goal = drive(robot, 1.5, 0.2)
    if late:
        costmap.run(1.0)
        costmap.wall(1.0)
        costmap.update(1.0)
    costmap.run_until_done(goal)
    assert_failed(goal, 723, "collision ahead at")
    assert 0.1 < robot.pose.x < 0.8
    assert robot.command == STILL


def test_an_outline_is_turned_back_from_where_the_robot_was() -> None:
    robot, costmap = alone(BEHAVIOR_SERVER)
    robot.pose = SE2(0.3, 0.2, 1.57)
    robot.run(0.4)
    costmap.publish()
    server = robot.nodes["behavior_server"]
    shape = server._costmaps["local"].footprint()
    assert shape.points == pytest.approx(BODY.points, abs=1e-5)


def test_a_behaviour_ends_where_the_costmap_falls_silent() -> None:
    robot, costmap = alone(BEHAVIOR_SERVER)
    costmap.publish()
    costmap.run(1.0)
    goal = drive(robot, 2.0, 0.1)
    costmap.run(2.0)
    assert not goal.done
    robot.run(1.5)
    assert_failed(goal, 720, "nothing has come on 'local_costmap/costmap_raw'")


@pytest.mark.parametrize("times", [1, 2])
def test_costs_that_are_latched_are_never_silent(times: int) -> None:
    robot, costmap = alone(BEHAVIOR_SERVER)
    for _ in range(times):
        costmap.publish()
        robot.run(6.0)
    goal = drive(robot, 1.0, 0.2)
    robot.run(6.0)
    assert goal.status == SUCCEEDED
    costmap.wall(1.6)
    costmap.publish()
    robot.run(6.0)
    goal = drive(robot, 1.0, 0.2)
    robot.run(6.0)
    assert_failed(goal, 723)


def test_a_behaviour_takes_topics_and_frames_by_name() -> None:
    names = {"local_costmap_topic": "/other/costs", "local_footprint_topic": "/other/outline"}
    robot = started(BEHAVIOR_SERVER, settle=0.4, behavior_server=names)
    costmap = Elsewhere(robot, "/other/costs", "/other/outline", "odom")
    costmap.publish()
    costmap.run_until_done(goal := drive(robot, 0.3, 0.2))
    assert goal.status == SUCCEEDED


def test_a_behaviour_of_ones_own_moves_in_the_whole_map() -> None:
    own = {"behavior_plugins": ["backup"], "backup.plugin": f"{__name__}:IN_MAP"}
    robot, costmap = alone(BEHAVIOR_SERVER, "global", "map", global_frame="map", **own)
    costmap.wall(-1.0)
    costmap.publish()
    goal = backup(robot, 2.0, 0.2)
    costmap.run_until_done(goal)
    assert_failed(goal, BackUp.Result.COLLISION_AHEAD)
    assert robot.pose.x < -0.1


@pytest.mark.parametrize("length", [0.2, 0.5])
def test_the_collision_monitor_takes_the_outline_by_topic(length: float) -> None:
    robot, costmap = alone(COLLISION_MONITOR)
    costmap.body = Footprint.polygon(BODY.points * [length / 0.2, 1.0])
    wall_ahead(robot, 1.0)
    ahead = Twist()
    ahead.linear.x = 0.2
    for _ in range(30):
        robot.bench.publish(Twist, "/cmd_vel_smoothed", ahead)
        costmap.run(0.2)
    assert 1.0 - length - 0.1 < robot.pose.x < 1.0 - length


def smooth(robot: PlayedRobot, frame: str = "map") -> Goal:
    path = path_msg(polyline([(0.0, 0.0), (2.0, 0.0)], 0.0), frame, 0.0)
    goal = SmoothPath.Goal(path=path, check_for_collisions=True)
    return robot.send(SmoothPath, "smooth_path", goal)


def test_a_smoother_takes_costs_and_the_outline_by_topic() -> None:
    robot, costmap = alone(SMOOTHER_SERVER, "global", "map")
    assert_failed(smooth(robot), SmoothPath.Result.UNKNOWN)
    costmap.publish()
    assert smooth(robot).status == SUCCEEDED
    costmap.wall(2.1)
    costmap.publish()
    assert_failed(smooth(robot), SmoothPath.Result.SMOOTHED_PATH_IN_COLLISION)
    costmap.body = Footprint.circle(0.04)
    costmap.publish()
    assert smooth(robot).status == SUCCEEDED


@pytest.mark.parametrize(
    ("values", "reason"),
    [({"robot_base_frame": "nobody"}, "nobody"), ({"transform_tolerance": 0.05}, "s old")],
)
def test_a_smoother_says_why_it_has_no_outline(values: dict[str, Any], reason: str) -> None:
    robot, costmap = alone(SMOOTHER_SERVER, "global", "map", **values)
    robot.localized = False
    robot.run(0.2)
    costmap.publish()
    assert_failed(smooth(robot), SmoothPath.Result.UNKNOWN, reason)


@pytest.mark.parametrize("blocked", [False, True])
def test_docking_takes_costs_and_the_outline_by_topic(blocked: bool) -> None:
    names = {
        "controller.costmap_topic": "/camera/costs",
        "controller.footprint_topic": "/camera/outline",
        "controller.dock_collision_threshold": 0.0,
        "max_retries": 0,
    }
    robot = started(DOCKING_SERVER, settle=0.4, docking_server=names)
    costmap = Elsewhere(robot, "/camera/costs", "/camera/outline", "odom")
    costmap.wall(0.6 if blocked else 3.0)
    goal = DockRobot.Goal(
        use_dock_id=False,
        dock_pose=pose_stamped(SE2(0.7, 0.0), "map", 0.0),
        dock_type="simple_charging_dock",
        navigate_to_staging_pose=False,
    )
    assert_failed(robot.send(DockRobot, "dock_robot", goal), DockRobot.Result.FAILED_TO_CONTROL)
    costmap.publish()
    ordered = robot.send(DockRobot, "dock_robot", goal)
    costmap.run(2.0)
    if blocked:
        assert_failed(ordered, DockRobot.Result.FAILED_TO_CONTROL, "collision ahead")
        assert robot.pose.distance(IDENTITY) < 0.1
    else:
        assert robot.pose.x > 0.1
