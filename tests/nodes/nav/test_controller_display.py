"""controller_server: what its controllers show, and what of their parameters it keeps itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from dwb_msgs.msg import LocalPlanEvaluation
from geometry_msgs.msg import PointStamped, PoseStamped
from nav2_msgs.action import FollowPath
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros.convert import path_msg, poses_from_path, seconds, transform_msg
from arjuna_core.twist import STILL
from bringup.stack import CONTROLLER_SERVER, LOCAL_COSTMAP
from tests.helpers.nav.navigation import CANCELED, Goal, PlayedRobot, started
from tests.nav.worlds import polyline

ROUTE = path_msg(polyline([(0.0, 0.0), (2.0, 0.0)], 0.0), "map", 0.0)
BACK = path_msg(polyline([(0.0, 0.0), (-2.0, 0.0)], math.pi), "map", 0.0)
DWB = {
    "FollowPath.plugin": "dwb_core::DWBLocalPlanner",
    "FollowPath.critics": ["GoalDist", "PathDist", "BaseObstacle"],
}
MPPI = {"FollowPath.plugin": "nav2_mppi_controller::MPPIController"}


def made(**parameters: Any) -> PlayedRobot:
    return started(LOCAL_COSTMAP, CONTROLLER_SERVER, settle=0.5, controller_server=parameters)


def follow(robot: PlayedRobot) -> Goal:
    return robot.send(FollowPath, "follow_path", FollowPath.Goal(path=ROUTE))


def test_dwb_s_trajectories_and_cells_are_shown() -> None:
    robot = made(**DWB, **{"FollowPath.publish_cost_grid_pc": True})
    markers = robot.bench.collect(MarkerArray, "/marker")
    clouds = robot.bench.collect(PointCloud2, "/cost_cloud")
    parts = robot.bench.collect(Path, "/transformed_global_plan")
    plans = robot.bench.collect(Path, "/local_plan")
    evaluations = robot.bench.collect(LocalPlanEvaluation, "/evaluation")
    follow(robot)
    robot.run(0.5)
    lines = markers[-1].markers
    assert len({(line.ns, line.id) for line in lines}) == len(lines) > 100
    assert {line.type for line in lines} == {Marker.LINE_STRIP}
    assert {seconds(line.lifetime) for line in lines} == {0.1}
    scored = evaluations[-1]
    assert len(scored.twists) == len(lines)
    best, totals = scored.twists[scored.best_index], [each.total for each in scored.twists]
    assert best.total == min(total for total in totals if total >= 0.0)
    assert scored.twists[scored.worst_index].total == max(totals)
    assert {score.name for score in best.scores} == set(DWB["FollowPath.critics"])
    assert len(best.traj.time_offsets) == len(best.traj.poses) - 1
    assert best.traj.velocity.x == pytest.approx(robot.command.x, abs=0.1)
    cloud = clouds[-1]
    assert [field.name for field in cloud.fields] == [
        *("x", "y", "z", "GoalDist", "PathDist", "BaseObstacle", "total_cost")
    ]
    values = np.frombuffer(cloud.data, np.float32).reshape(-1, 7)
    assert cloud.width == len(values) == 60 * 60
    near = np.hypot(values[:, 0] - 1.0, values[:, 1]) < 0.04
    assert values[near, 4].min() == 0.0
    assert {each.header.frame_id for each in (lines[0], cloud, parts[-1], plans[-1])} == {"map"}
    assert poses_from_path(parts[-1])[-1, 0] == pytest.approx(2.0)
    assert poses_from_path(plans[-1])[-1, 0] > robot.pose.x + 0.1


def test_pure_pursuit_shows_how_it_turns() -> None:
    """By the names that RViz's configurations of Nav2 have."""
    fixed = {"FollowPath.use_fixed_curvature_lookahead": True}
    robot = made(**fixed, **{"FollowPath.curvature_lookahead_dist": 0.9})
    bends = robot.bench.collect(PointStamped, "/curvature_lookahead_point")
    turns = robot.bench.collect(Bool, "/is_rotating_to_heading")
    arcs = robot.bench.collect(Path, "/lookahead_collision_arc")
    follow(robot)
    robot.run(0.3)
    assert {each.header.frame_id for each in (bends[-1], arcs[-1])} == {"map"}
    assert bends[-1].point.x - robot.pose.x == pytest.approx(0.9, abs=0.1)
    assert not turns[-1].data
    robot.send(FollowPath, "follow_path", FollowPath.Goal(path=BACK))
    robot.run(0.3)
    assert turns[-1].data


def test_the_graceful_controller_shows_its_target() -> None:
    robot = made(**{"FollowPath.plugin": "nav2_graceful_controller::GracefulController"})
    targets = robot.bench.collect(PoseStamped, "/motion_target")
    follow(robot)
    robot.run(0.3)
    assert targets[-1].header.frame_id == "map"
    assert targets[-1].pose.position.x - robot.pose.x == pytest.approx(1.0, abs=0.15)


def test_mppi_s_rollouts_are_shown_as_points_with_their_colours() -> None:
    robot = made(**MPPI, **{"FollowPath.visualize": True})
    shown = robot.bench.collect(MarkerArray, "/trajectories")
    optimal = robot.bench.collect(Path, "/optimal_trajectory")
    follow(robot)
    robot.run(0.5)
    candidates, best = shown[-1].markers
    assert (candidates.ns, best.ns) == ("Candidate Trajectories", "Optimal Trajectory")
    assert candidates.type == Marker.SPHERE_LIST
    assert len(candidates.points) == len(candidates.colors) == 200 * 19
    assert candidates.colors[0].b > candidates.colors[-1].b
    assert len(optimal[-1].poses) == len(best.points) == 56


@pytest.mark.parametrize("topic", ["global", "local"])
def test_plans_are_not_shown_where_dwb_is_not_to(topic: str) -> None:
    for shows in (True, False):
        robot = made(**DWB, **{f"FollowPath.publish_{topic}_plan": shows})
        name = "/received_global_plan" if topic == "global" else "/local_plan"
        plans = robot.bench.collect(Path, name)
        follow(robot)
        robot.run(0.3)
        assert bool(plans) is shows
        robot.close()


def test_a_cancelled_robot_brakes_as_the_controller_is_to() -> None:
    own = {"FollowPath.use_cancel_deceleration": True, "FollowPath.cancel_deceleration": 0.4}
    robot = made(**own)
    goal = follow(robot)
    robot.run(2.0)
    robot.forget()
    goal.cancel()
    robot.run_until_done(goal, 3.0)
    assert goal.status == CANCELED
    speeds = [command.x for command in robot.commands]
    steps = -np.diff([speed for speed in speeds if speed > 0.0])
    assert len(steps) > 10
    assert steps == pytest.approx(0.4 * 0.05, abs=1e-6)
    assert robot.commands[-1] == STILL


@pytest.mark.parametrize(("tolerance", "says"), [(0.1, "0.3 s"), (0.6, "0.6 s")])
def test_a_pose_may_be_as_old_as_the_controllers_tolerance(tolerance: float, says: str) -> None:
    robot = made(**{"FollowPath.transform_tolerance": tolerance})
    goal = follow(robot)
    robot.run(1.0)
    robot.localized = False
    while not goal.done and robot.now < 5.0:  # odometry goes on, what corrects it does not
        moved = transform_msg(robot.pose, "odom", "base_footprint", robot.now)
        robot.bench.publish(TFMessage, "/tf", TFMessage(transforms=[moved]))
        robot.run(0.02)
    assert f"tolerance of {says}" in goal.result.error_msg


def test_odometry_is_averaged_over_its_duration() -> None:
    def lookaheads(**parameters: Any) -> list[float]:
        robot = made(**parameters)
        shown = robot.bench.collect(PointStamped, "/lookahead_point")
        follow(robot)
        robot.run(0.6)
        robot.close()
        return [each.point.x for each in shown]

    newest, mean = lookaheads(), lookaheads(odom_duration=0.5)
    assert mean[4] < newest[4] - 0.1
    assert newest[-1] == pytest.approx(0.6, abs=0.02)  # 1.5 s of the speed
