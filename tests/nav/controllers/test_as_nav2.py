"""With `--as-nav2` controllers compute what Nav2's published sources say, worked out by hand.

Each case has its derivation in a comment; the sources are those of navigation2's jazzy branch.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.controllers.follower import FollowState, PathFollower
from arjuna_nav.controllers.mppi import critics, path_critics
from arjuna_nav.controllers.mppi.rollouts import Limits, Rollouts
from arjuna_nav.controllers.mppi.scene import Grid, Scene
from arjuna_nav.controllers.plugins import CONTROLLERS, GOAL_CHECKERS
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.inflation import clearances
from tests.helpers.nav.as_nav2 import nav2_config
from tests.nav.worlds import block, costmap_of, empty_grid, polyline

pytestmark = pytest.mark.ros
ROBOT = Footprint.circle(0.25)
RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"


@functools.cache
def free() -> Costmap:
    """Return a free costmap, 12 m square about the origin."""
    return costmap_of(empty_grid(12.0, 12.0, SE2(-6.0, -6.0)))


def beside_a_wall() -> Costmap:
    """Return one whose cost is 119 at the origin: 252 exp(-5 (0.40 - 0.25)) = 119.04."""
    grid = empty_grid(12.0, 12.0, SE2(-6.025, -6.025))
    block(grid, 0.0, 6.40, 12.0, 0.05)
    return costmap_of(grid)


def ahead(y: float = 0.0, length: float = 4.0, yaw: float = 0.0) -> Any:
    """Return a straight path beside the robot, to the right's left by y."""
    return polyline([(0.0, y), (length, y)], yaw)


LEFT, BENT = polyline([(0.0, 0.0), (0.0, 4.0)], 1.57), ahead(0.3)
PURSUIT: dict[str, tuple[dict[str, Any], Any, Velocity, float, float]] = {
    # y = 0.3, L = 0.6: k = 2 y / L^2 = 5/3, radius 0.6: v = 0.5 (0.6 / 0.9), w = v k
    "bend": ({}, BENT, STILL, 1 / 3, 5 / 9),
    # L = 0.1 x 1.5 -> min 0.3, y = 0.15: k = 10/3, 0.5 (0.3 / 0.9) = 0.167 -> min_speed 0.25
    "least lookahead": ({"use_velocity_scaled_lookahead_dist": True}, ahead(0.15), Velocity(0.1),
                        0.25, 5 / 6),
    # L = 1.5 -> max 0.9, y = 0.3: k = 0.6 / 0.81, radius 1.35 beyond 0.9
    "most lookahead": ({"use_velocity_scaled_lookahead_dist": True}, BENT, Velocity(1.0), 0.5,
                       0.5 * 0.6 / 0.81),
    # 0.3 m left of 0.6: v = 0.5 x 0.5
    "approach": ({}, ahead(length=0.3), STILL, 0.25, 0.0),
    # 0.5 x 0.3 / 6 = 0.025 -> min_approach_linear_velocity
    "least approach": ({"approach_velocity_scaling_dist": 6.0}, ahead(length=0.3), STILL, 0.05,
                       0.0),
    # 90 degrees off: on the spot, 1.8 within 0 + 3.2 x 0.05
    "turn begins": ({}, LEFT, STILL, 0.0, 0.16),
    # 1.8 within 1.0 + 0.16
    "turn gains speed": ({}, LEFT, Velocity(yaw_rate=1.0), 0.0, 1.16),
    # sqrt(2 x 0.5 x 1.5708) = 1.2533 is less than 1.8 - 0.025
    "turn brakes": ({"max_angular_accel": 0.5}, LEFT, Velocity(yaw_rate=1.8), 0.0, 1.2533),
    # 0.79 rad off is beyond 0.785, whatever came before; 0.78 is not
    "turns": ({"rotate_to_heading_min_angle": 0.523}, BENT, STILL, 0.0, 0.16),
    "turns no more": ({"rotate_to_heading_min_angle": 0.524}, BENT, STILL, 1 / 3, 5 / 9),
    # within xy_goal_tolerance: to the goal's heading, 1 rad off
    "goal": ({}, ahead(length=0.1, yaw=1.0), STILL, 0.0, 0.16),
    # without turns it drives into the goal: 0.5 x 0.1 / 0.6
    "goal without turns": ({"use_rotate_to_heading": False}, ahead(length=0.1, yaw=1.0), STILL,
                           1 / 12, 0.0),
    # rotate_to_heading_angular_vel bounds turns on the spot alone
    "bends are not capped": ({"rotate_to_heading_angular_vel": 0.3}, BENT, STILL, 1 / 3, 5 / 9),
    # the point at 0.9 m says v and w: k = 0.6 / 0.81, radius 1.35
    "fixed curvature": ({"use_fixed_curvature_lookahead": True, "curvature_lookahead_dist": 0.9},
                        BENT, STILL, 0.5, 0.5 * 0.6 / 0.81),
    # 1.2 m on, 0.6 of it beyond the end: k = 0 still, and v by 0.6 m left
    "beyond the goal": ({"use_fixed_curvature_lookahead": True, "curvature_lookahead_dist": 1.2,
                         "interpolate_curvature_after_goal": True}, ahead(length=0.6), STILL, 0.5,
                        0.0),
}  # fmt: skip


def controller(name: str, values: dict[str, Any], period: float = 0.05) -> Any:
    given = {f"FollowPath.{key}": value for key, value in values.items()}
    made = nav2_config("controller_server", **{"FollowPath.plugin": name}, **given).FollowPath
    return CONTROLLERS.make(made, ROBOT, 0.25, period)


@pytest.mark.parametrize("case", PURSUIT)
def test_pure_pursuit(case: str) -> None:
    values, path, driven, v, w = PURSUIT[case]
    follower = controller(RPP, values)
    follower.set_path(path)
    result = follower.compute(SE2(), driven, free(), 0.0)
    assert result.status is ControlStatus.SUCCEEDED
    assert (result.velocity.x, result.velocity.yaw_rate) == pytest.approx((v, w), abs=1e-4)


def test_pure_pursuit_beside_an_obstacle() -> None:
    follower = controller(RPP, {"inflation_cost_scaling_factor": 5.0})
    follower.set_path(ahead())
    # distance = -ln(119 / 252) / 5 + 0.25 = 0.40007: v = 0.5 x 0.40007 / 0.6
    driven = follower.compute(SE2(), STILL, beside_a_wall(), 0.0).velocity
    assert driven.x == pytest.approx(0.33339, abs=1e-4)


@pytest.mark.parametrize("name", ["SimpleGoalChecker", "PositionGoalChecker", "StoppedGoalChecker"])
@pytest.mark.parametrize("stateful", [True, False])
def test_a_position_that_was_reached_stays_reached(name: str, stateful: bool) -> None:
    values = {"plugin": f"nav2_controller::{name}", "stateful": stateful}
    given = {f"general_goal_checker.{key}": value for key, value in values.items()}
    checker = GOAL_CHECKERS.make(nav2_config("controller_server", **given).general_goal_checker)
    # check_xy is false from the first success on: 3 m away it is not looked at again
    assert not checker.reached(SE2(0.251), SE2())
    assert checker.reached(SE2(0.249, 0.0, 0.249), SE2())
    assert checker.reached(SE2(3.0, 0.0, 0.249), SE2()) == stateful


def follow(costmap: Costmap, path: Any, pose: SE2, **values: Any) -> Any:
    made = nav2_config("controller_server", **{"FollowPath.plugin": RPP}, **values)
    follower = PathFollower(made, ROBOT)
    follower.start(path, 0.0)
    return follower.tick(pose, STILL, costmap, 0.0)


def test_the_goal_checker_alone_ends_a_path() -> None:
    # 0.24 m and 0.2 rad lie within 0.25 and 0.25: isGoalReached, nothing drives on
    last = polyline([(3.0, 0.0), (4.0, 0.0)], 0.0)
    assert follow(free(), last, SE2(3.76, 0.0, 0.2)).state is FollowState.SUCCEEDED


def test_a_collision_ahead_fails_at_once() -> None:
    grid = empty_grid(12.0, 12.0, SE2(-6.0, -6.0))
    block(grid, 6.55, 5.0, 0.1, 2.0)  # 0.55 m ahead: the robot's front would come to 0.75
    result = follow(costmap_of(grid), ahead(), SE2())
    # failure_tolerance 0: NoValidControl is thrown on, no other lookahead or turn is tried
    assert (result.state, result.error) == (FollowState.FAILED, ControlStatus.NO_VALID_CONTROL)


MPPI = "nav2_mppi_controller::MPPIController"
LIMITS = Limits(-0.35, 0.5, 1.9, 3.0, 3.0, 3.5, 0.5)
FORTH = np.column_stack((0.1 * np.arange(30), np.zeros(30), np.zeros(30))).astype(np.float32)
LEFTWARDS = FORTH[:, [1, 0, 2]]
CRITICS: dict[str, tuple[str, Any, dict[str, Any], list[list[float]], float | None]] = {
    # 5 x mean(2, 1) m from the goal
    "goal": ("GoalCritic", critics.goal, {"goal_distance": 1.4}, [[0] * 5, [0, 0, 1, 0, 0]], 7.5),
    # 3 x mean(0, 0.5) rad from its heading
    "goal angle": ("GoalAngleCritic", critics.goal_angle, {"goal_distance": 0.5},
                   [[0] * 5, [0, 0, 0, 0, 0.5]], 0.75),
    # 5 x (0.2 m/s back) x 0.05 s
    "forward": ("PreferForwardCritic", critics.prefer_forward, {},
                [[-0.2, 0, 0, 0, 0], [0.1, 0, 0, 0, 0]], 0.05),
    # max_vel = hypot(vx_max, vy_max) = 0.70711 of a differential drive too: 4 x 0.09289 x 0.05
    "constraint": ("ConstraintCritic", critics.constraint, {},
                   [[0.8, 0, 0, 0, 0], [0.6, 0, 0, 0, 0]], 0.018579),
    # hypot(0.6, 0.8) = 1.0: 4 x 0.29289 x 0.05
    "sideways": ("ConstraintCritic", critics.constraint, {}, [[0.6, 0, 0, 0, 0, 0.8]], 0.058579),
    # 10 x mean(0.2, 0.4)
    "twirling": ("TwirlingCritic", critics.twirling, {}, [[0, 0.2, 0, 0, 0], [0, -0.4, 0, 0, 0]],
                 3.0),
    # withinPositionGoalTolerance: off
    "twirling at the goal": ("TwirlingCritic", critics.twirling, {"goal_distance": 0.24},
                             [[0, 0.2, 0, 0, 0]], None),
    # 35 x (0.2 - 0.05) x 0.05 beyond a deadband of 0.2
    "deadband": ("VelocityDeadbandCritic", critics.deadband, {}, [[0.05, 0.5, 0, 0, 0]], 0.2625),
    # pose 10 + 6 lies at 1.6 m: 5 x hypot(1.6 - 1.3, 0.4)
    "follow": ("PathFollowCritic", path_critics.path_follow, {}, [[0] * 5, [0, 0, 1.3, 0.4, 0]],
               2.5),
    # pose 10 + 4 lies to the left, pi / 2 off: 2.2 x pi / 2
    "angle": ("PathAngleCritic", path_critics.path_angle, {"path": LEFTWARDS}, [[0] * 5] * 2,
              1.1 * math.pi),
    # it lies ahead, within max_angle_to_furthest
    "no angle": ("PathAngleCritic", path_critics.path_angle, {}, [[0] * 5] * 2, None),
    # step 4 of 5: 0.4 m travelled, the pose as far is (0.4, 0): 10 x 0.3
    "align": ("PathAlignCritic", path_critics.path_align, {"furthest": 20},
              [[0, 0, 0.1 * k, 0.3, 0] for k in range(5)], 3.0),
    # steps 0 and 2 of 4, costs 0 and 100: 3.81 / 254 x 100 / 2
    "cost": ("CostCritic", critics.cost_critic, {},
             [[0] * 5, [0, 0, 0.2, 0, 0], [0, 0, 0.5, 0, 0], [0, 0, 1, 0, 0]], 0.75),
    # near the goal preferential costs do not count
    "cost at the goal": ("CostCritic", critics.cost_critic, {"goal_distance": 0.5},
                         [[0, 0, 0.5, 0, 0]], 0.0),
}  # fmt: skip


@pytest.mark.parametrize("case", CRITICS)
def test_critics_of_mppi(case: str) -> None:
    name, critic, changes, steps, expected = CRITICS[case]
    parts = np.array(steps, np.float32).T[:, :, None]
    side = parts[5] if len(parts) > 5 else np.empty((0, 0), np.float32)
    data = np.zeros((40, 40), np.uint8)
    data[:, 25] = 100
    grid = Grid(data, 20.5, 20.5, 0.0, 10.0, ROBOT.points, True, 253)
    whole, near = np.ones(30, np.bool_), clearances(5.0)
    scene = Scene(FORTH, whole, SE2(2.0), 2.0, 10, grid, near, 0.25, LIMITS, 0.05)
    deadband = {"FollowPath.VelocityDeadbandCritic.deadband_velocities": [0.2, 0.0, 0.0]}
    made = nav2_config("controller_server", **{"FollowPath.plugin": MPPI}, **deadband).FollowPath
    scene = scene._replace(xy_goal_tolerance=0.25, **changes)
    v, w, x, y, yaw = parts[:5]
    cost = critic(getattr(made, name), Rollouts(v, w, x, y, yaw, side), scene)
    cost = cost[0] if isinstance(cost, tuple) else cost
    assert cost is None if expected is None else cost == pytest.approx([expected], rel=1e-4)


# angular_vel = sign x 1.8 within the measured 0.5 + 3.2 x 0.05; sqrt(2 x 0.5 x 1.5708) = 1.2533
@pytest.mark.parametrize(("accel", "driven", "rate"), [(3.2, 0.5, 0.66), (0.5, 1.8, 1.2533)])
def test_rotation_shim(accel: float, driven: float, rate: float) -> None:
    values = {"primary_controller": RPP, "max_angular_accel": accel}
    shim = controller("nav2_rotation_shim_controller::RotationShimController", values)
    shim.set_path(LEFT)
    velocity = shim.compute(SE2(), Velocity(yaw_rate=driven), free(), 0.0).velocity
    assert (velocity.x, velocity.yaw_rate) == pytest.approx((0.0, rate), abs=1e-4)
