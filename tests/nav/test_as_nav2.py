"""With `--as-nav2` each server computes what Nav2's published sources say, worked out by hand.

Each case has its derivation in a comment; the sources are those of navigation2's jazzy branch.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.files.map_image import MapOptions, Pixels, occupancy_of
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import BehaviorStatus
from arjuna_nav.behaviors.motions import AssistedTeleop, DriveOnHeading, Spin
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.controllers.follower import FollowState, PathFollower
from arjuna_nav.controllers.plugins import CONTROLLERS
from arjuna_nav.costmap import Costmap, LayeredCostmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.layers.observations import PlacedScan
from arjuna_nav.docking.approach import steer
from arjuna_nav.navigator import Ending
from arjuna_nav.planners.base import PLANNERS, PlanStatus
from arjuna_nav.safety.collision_monitor import CollisionMonitor
from arjuna_nav.safety.sight import Sight
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.motion import differential, omnidirectional
from bringup.parameters.sources import as_theirs
from bringup.stack import all_nodes
from tests.helpers.nav.navigator_script import DETOUR, GOAL, Script, failed, planned
from tests.nav.worlds import block, costmap_of, empty_grid, grid_of, polyline, room, scan_from

pytestmark = pytest.mark.ros
ROBOT = Footprint.circle(0.25)
ROOM = room()


@functools.cache
def free() -> Costmap:
    """Return a free costmap, 12 m square about the origin."""
    return costmap_of(empty_grid(12.0, 12.0, SE2(-6.0, -6.0)))


def nav2_config(node: str, **values: Any) -> Any:
    """Return a node's parameters as `--as-nav2` sets them, given those of a file."""
    (spec,) = (one for one in all_nodes() if one.name == node)
    parameters = as_theirs({node: values}, [spec], replaces=False)
    return load(spec.config, parameters.get(node, {}))


# controller_server

RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"


def beside_a_wall() -> Costmap:
    """Return one whose cost is 119 at the origin: 252 exp(-5 (0.40 - 0.25)) = 119.04."""
    return costmap_of(grid_of(12.0, 12.0, (0.0, 6.40, 12.0, 0.05), origin=SE2(-6.025, -6.025)))


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


# distance = -ln(119 / 252) / factor + 0.25 = 0.40007 or 0.32503, whatever the layer's own factor:
# v = 0.5 x distance / 0.6
@pytest.mark.parametrize(("factor", "v"), [(5.0, 0.33339), (10.0, 0.27086)])
def test_pure_pursuit_beside_an_obstacle(factor: float, v: float) -> None:
    follower = controller(RPP, {"inflation_cost_scaling_factor": factor})
    follower.set_path(ahead())
    driven = follower.compute(SE2(), STILL, beside_a_wall(), 0.0).velocity
    assert driven.x == pytest.approx(v, abs=1e-4)


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


# planner_server


def planner(name: str, **values: Any) -> Any:
    given = {f"GridBased.{key}": value for key, value in values.items()}
    made = nav2_config("planner_server", **{"GridBased.plugin": name}, **given).GridBased
    return PLANNERS.make(made, ROBOT)


@pytest.mark.parametrize("name", ["SmacPlanner2D", "SmacPlannerHybrid"])
def test_smac_does_not_leave_an_inscribed_cell(name: str) -> None:
    grid = empty_grid(4.0, 4.0, SE2(-2.0, -2.0))
    block(grid, 2.2, 1.0, 0.1, 2.0)  # 0.2 m from the start: its cell has 253
    plan = planner(f"nav2_smac_planner::{name}").plan(costmap_of(grid), SE2(), SE2(-1.5))
    # AStarAlgorithm::areInputsValid: "Starting point in lethal space"
    assert plan.status is PlanStatus.START_OCCUPIED


# a square of a cost, 10 cells deep: through it 10 x 2 x cost / 252 more (SmacPlanner2D), or
# 10 x 2 (cost / 252)^2 (Theta*); round it 2 x 0.414 x 10.5 = 8.7 more by octiles, or
# 2 (hypot(35, 10.5) - 35) = 3.1 by straight lines
SMAC_2D, THETA = "nav2_smac_planner::SmacPlanner2D", "nav2_theta_star_planner::ThetaStarPlanner"


@pytest.mark.parametrize(
    ("name", "values", "cost", "through"),
    [
        (SMAC_2D, {"cost_travel_multiplier": 2.0}, 90, True),
        (SMAC_2D, {"cost_travel_multiplier": 2.0}, 130, False),
        (THETA, {}, 80, True),
        (THETA, {}, 180, False),
        (THETA, {"w_euc_cost": 5.0}, 180, True),  # round it 15.4 more
    ],
)
def test_a_cost_is_gone_round_where_that_is_cheaper(
    name: str, values: dict[str, Any], cost: int, through: bool
) -> None:
    data = np.zeros((81, 161), np.uint8)
    data[30:51, 75:85] = cost
    costmap = Costmap(GridFrame(0.1, 161, 81), data)
    path = planner(name, **values).plan(costmap, SE2(4.05, 4.05), SE2(12.05, 4.05)).path
    aside = np.abs(path[:, 1] - 4.05).max()
    assert aside < 0.3 if through else aside > 0.8


# behavior_server

SPINS = [
    # sqrt(2 x 3.2 x left), within 0.4 and 1.0
    (1.57, 0.0, 1.0),
    (1.57, 1.47, 0.8),
    (1.57, 1.565, 0.4),
    (-1.57, -1.47, -0.8),
]


@pytest.mark.parametrize(("target", "turned", "rate"), SPINS)
def test_spin(target: float, turned: float, rate: float) -> None:
    spin = Spin(target, nav2_config("behavior_server"), ROBOT, 0.0)
    spin.tick(SE2(), free(), 0.0)
    assert spin.tick(SE2(theta=turned), free(), 0.1).velocity.yaw_rate == pytest.approx(rate)


@pytest.mark.parametrize(("speed", "done"), [(-0.15, -0.29), (0.2, 0.29), (-0.15, -0.3)])
def test_drive_on_heading(speed: float, done: float) -> None:
    # command_speed until hypot(diff_x, diff_y) >= |command_x|
    drive = DriveOnHeading(
        math.copysign(0.3, speed), speed, nav2_config("behavior_server"), ROBOT, 10.0
    )
    drive.tick(SE2(), free(), 0.0)
    result = drive.tick(SE2(done), free(), 1.0)
    ended = abs(done) >= 0.3
    assert (result.status is BehaviorStatus.SUCCEEDED) == ended
    assert result.velocity == Velocity(0.0 if ended else speed)


# x = 0.10 k at step k of 0.1 s and 1 m/s, the front 0.25 m on; a wall from x on is hit at step k:
# at the first the robot stands, else the twist is scaled by k x 0.1 / 1.0
@pytest.mark.parametrize(("wall", "scale"), [(0.33, 0.0), (0.63, 0.4), (2.0, 1.0)])
def test_assisted_teleop(wall: float, scale: float) -> None:
    grid = empty_grid(12.0, 12.0, SE2(-6.0, -6.0), 0.01)
    block(grid, 6.0 + wall, 4.0, 0.1, 4.0)
    teleop = AssistedTeleop(nav2_config("behavior_server"), ROBOT, 0.0)
    teleop.take(Velocity(1.0), 0.0)
    result = teleop.tick(SE2(), costmap_of(grid), 0.0)
    assert result.velocity.x == pytest.approx(scale)


# bt_navigator

NAV2_TREE = "navigate_to_pose_w_replanning_and_recovery.xml"


def script() -> Script:
    made = nav2_config("bt_navigator")
    assert made.default_nav_to_pose_bt_xml == NAV2_TREE
    return Script((GOAL,), made.default_nav_to_pose_bt_xml, made)


def test_the_recoveries_are_nav2s_in_their_order_and_end_after_six() -> None:
    # RoundRobin: ClearingActions, Spin, Wait, BackUp; 6 retries of the RecoveryNode
    navigation, order = script(), []
    done = navigation.tick()
    while navigation.end is None and navigation.now < 60.0:
        order += [name for name in done if name != "plan"]
        answers = {name: failed() if name == "plan" else True for name in done}
        done = navigation.tick(**answers)  # type: ignore[arg-type]
    clear = ["clear_local", "clear_global"]
    recoveries = [clear, ["Spin"], ["Wait"], ["BackUp"], clear, ["Spin"]]
    expected = ["clear_global"]  # of ComputePathToPose's own RecoveryNode, before each
    for recovery in recoveries:
        expected += [*recovery, "clear_global"]
    assert order == expected
    # 7 clearings beside the planner, 2 + 1 + 1 + 1 + 2 + 1 by the round: each counts
    assert navigation.recoveries == 15
    assert navigation.end is not None
    assert navigation.end.error_code == PlanStatus.NO_VALID_PATH


def test_a_controller_that_fails_is_tried_again_on_a_cleared_costmap() -> None:
    navigation = script().follow()
    stuck = failed(ControlStatus.FAILED_TO_MAKE_PROGRESS)
    # RecoveryNode number_of_retries 1 round FollowPath, with ClearEntireCostmap local
    assert navigation.tick(follow=stuck) == ["clear_local"]
    assert navigation.tick(clear_local=True) == ["follow"]
    assert navigation.tick(follow=stuck) == ["clear_local"]


def test_a_worse_path_is_followed_too() -> None:
    # RateController hz 1.0, and no PathValid above it
    navigation = script().follow()
    assert navigation.tick(0.7) == []
    assert navigation.tick(0.3) == ["plan"]
    assert navigation.tick(plan=planned(DETOUR)) == ["follow"]
    assert navigation.followed is DETOUR


def test_an_outage_ends_it() -> None:
    # WouldAControllerRecoveryHelp: no recovery helps against TF_ERROR, 102
    navigation = script().follow()
    assert navigation.tick(follow=failed(ControlStatus.TF_ERROR)) == []
    assert navigation.end is not None
    assert (navigation.end.ending, navigation.end.error_code) == (Ending.ABORTED, 102)


# collision_monitor

SQUARE = "[[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]"
AHEAD = {"action_type": "approach", "type": "circle", "radius": 0.5}
MONITOR: dict[str, tuple[dict[str, Any], float, int, Velocity, Velocity]] = {
    "stop": ({"action_type": "stop", "points": SQUARE}, 0.4, 4, Velocity(0.8), STILL),
    # 3 points are fewer than min_points 4
    "no stop": ({"action_type": "stop", "points": SQUARE}, 0.4, 3, Velocity(0.8), Velocity(0.8)),
    # 0.95 - 0.1 k < 0.5 first at k = 5, whose time is 0.4: 0.4 / 2.0
    "approach": (AHEAD, 0.95, 4, Velocity(1.0), Velocity(0.2)),
    # within the circle already: 0, and no way out
    "touches": (AHEAD, -0.45, 4, Velocity(1.0), STILL),
}  # fmt: skip


@pytest.mark.parametrize("case", MONITOR)
def test_collision_monitor(case: str) -> None:
    values, x, count, command, expected = MONITOR[case]
    zone = {f"zone.{key}": value for key, value in {"type": "polygon", **values}.items()}
    monitor = CollisionMonitor(nav2_config("collision_monitor", polygons=["zone"], **zone))
    sight = Sight.of(np.column_stack((np.full(count, x), 0.001 * np.arange(count))))
    driven = monitor.judge(command, sight, ROBOT).velocity
    assert (driven.x, driven.yaw_rate) == pytest.approx((expected.x, expected.yaw_rate))


# local_costmap, global_costmap

COSTMAP = "local_costmap/local_costmap"


def layered(**values: Any) -> LayeredCostmap:
    """Return a costmap of 5 m about the origin in cells of 0.1 m."""
    size = {"resolution": 0.1, "origin_x": -2.5, "origin_y": -2.5, "robot_radius": 0.25}
    return LayeredCostmap(nav2_config(COSTMAP, **size, footprint_padding=0.0, **values))


SCAN = {"obstacle_layer.observation_sources": "scan", "obstacle_layer.scan.clearing": True,
        "obstacle_layer.scan.max_obstacle_height": 2.0}  # fmt: skip


def test_from_a_collision_every_motion_collides() -> None:
    grid = OccupancyGrid(GridFrame(0.1, 50, 50, SE2(-2.5, -2.5)), np.zeros((50, 50), np.int8))
    grid.data[25, 27] = 100
    costmap = layered(plugins=["static_layer", "inflation_layer"])
    costmap.set_map(grid)
    back = np.column_stack((-0.05 * np.arange(20), np.zeros(20), np.zeros(20)))
    # 0.2 m lies within the inscribed radius, CostmapTopicCollisionChecker says no
    assert first_collision(costmap.costmap, ROBOT, back) == 0


# inf becomes range_max - 0.0001, which marks within obstacle_max_range; what is finite and beyond
# range_max is no reading
@pytest.mark.parametrize(("reading", "marks"), [(math.inf, True), (2.06, False), (2.04, True)])
def test_a_beam_without_return_marks_at_its_end(reading: float, marks: bool) -> None:
    costmap = layered(
        plugins=["obstacle_layer"], **SCAN, **{"obstacle_layer.scan.inf_is_valid": True}
    )
    scan = Scan(np.array([reading]), 0.0, 0.01, 0.1, 2.05)
    costmap.receive("obstacle_layer", "scan", PlacedScan(scan, SE2()))
    costmap.update(SE2(), 0.0)
    assert (costmap.costmap.data == 254).any() == marks


# docking_server


# target, speed and yaw rate: r, phi = theta - sight, delta = -sight;
# k = -(2 (delta - atan(-3 phi)) + (1 + 3 / (1 + 9 phi^2)) sin delta) / r; v = 0.25 / (1 + 0.4 k^2)
@pytest.mark.parametrize(
    ("target", "backward", "v", "w"),
    [
        (SE2(1.0), False, 0.25, 0.0),
        (SE2(0.2), False, 0.2, 0.0),  # 0.25 x 0.2 / slowdown_radius
        (SE2(0.05), False, 0.1, 0.0),  # v_linear_min
        (SE2(1.0, 0.0, 0.5), False, 0.1, -0.1965588),  # k = -1.965588, v = 0.0982 -> 0.1
        (SE2(1.0, 0.5), False, 0.1, 0.3333137),  # k = 3.333137
        (SE2(-1.0), True, -0.25, 0.0),
        (SE2(0.3, 0.3), False, 0.0644056, 0.75),  # k = 11.645: 0.1 k -> v_angular_max, v = 0.75 / k
    ],
)
def test_graceful_control_law(target: SE2, backward: bool, v: float, w: float) -> None:
    driven = steer(nav2_config("docking_server").controller, target, backward)
    assert (driven.x, driven.yaw_rate) == pytest.approx((v, w), abs=1e-4)


# amcl


class Ones:
    """Draws one standard deviation each time."""

    def standard_normal(self, shape: tuple[int, int]) -> Any:
        return np.ones(shape)


# each part is its mean and one deviation; alphas 0.2
@pytest.mark.parametrize(
    ("model", "delta", "moved"),
    [
        # turns 0 + sqrt(0.2 x 0.25), drives 0.5 + sqrt(0.2 x 0.25 + 0.2 x 0.04), turns
        # 0.2 + sqrt(0.2 x 0.04 + 0.2 x 0.25)
        (differential, SE2(0.5, 0.0, 0.2), [0.722388, 0.164278, 0.664439]),
        # backwards as forwards: 0.5 + sqrt(0.05), turned by pi + sqrt(0.05) and -pi + sqrt(0.05)
        (differential, SE2(-0.5), [-0.705592, -0.160458, 0.447214]),
        # drives sqrt(0.2 x 0.16), turns 0.4 + sqrt(0.2 x 0.16): a turn on the spot has no first one
        (differential, SE2(0.0, 0.0, 0.4), [0.178885, 0.0, 0.578885]),
        # along 0.5 + sqrt(0.05), across sqrt(0.05), to the left; turns sqrt(0.05)
        (omnidirectional, SE2(0.0, 0.5), [-0.223607, 0.723607, 0.223607]),
    ],
)
def test_motion_models(model: Any, delta: SE2, moved: list[float]) -> None:
    particles = model(nav2_config("amcl"), np.zeros((1, 3)), delta, Ones())
    assert particles[0] == pytest.approx(moved, abs=1e-5)


def test_amcl_rests_between_updates_and_does_not_match() -> None:
    made = ParticleFilter(nav2_config("amcl"), ROOM, np.random.default_rng(0))
    made.set_pose(SE2(0.03, 0.0, 0.01), np.diag([1e-6, 1e-6, 1e-6]))
    first = made.update(SE2(), scan_from(ROOM, SE2()))
    # 0.2 m is less than update_min_d: laser_scan is not used, map -> odom stays
    assert made.update(SE2(0.2), scan_from(ROOM, SE2(0.2))) is None
    # the heaviest cluster's mean, 3 cm off where matching would find the pose
    assert first is not None
    assert first.T_map_base.x == pytest.approx(0.03, abs=0.003)


# map_server


@pytest.mark.parametrize(
    ("mode", "negate", "shade", "alpha", "value"),
    [
        ("trinary", False, 0, None, 100),  # 1 - 0 / 255 > 0.65
        ("trinary", False, 128, None, -1),  # 0.498
        ("scale", False, 128, None, 62),  # (0.498 - 0.25) / 0.4 x 100 = 62.01
        ("scale", False, 0, 0, -1),  # transparent
        ("raw", False, 42, None, 42),
        ("trinary", False, 80, 255, -1),  # alpha is a fourth colour: 1 - 495 / 1020 = 0.515
        ("trinary", False, 255, 0, -1),  # 1 - 765 / 1020 = 0.25, no less than free_thresh
    ],
)
def test_map_server(mode: str, negate: bool, shade: int, alpha: int | None, value: int) -> None:
    options = MapOptions(mode, negate)
    given = None if alpha is None else np.array([[alpha]], np.uint8)
    pixels = Pixels(np.array([[shade]], np.uint8), 255, given)
    assert occupancy_of(pixels, options)[0, 0] == value
