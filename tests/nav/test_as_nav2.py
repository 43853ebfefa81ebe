"""With `--as-nav2` each server computes what Nav2's published sources say, worked out by hand.

Each case has its derivation in a comment; the sources are those of navigation2's jazzy branch.
Controllers are in `controllers/test_as_nav2.py`.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.files.map_image import MapOptions, occupancy_of
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.behaviors.base import BehaviorStatus
from arjuna_nav.behaviors.motions import AssistedTeleop, DriveOnHeading, Spin
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.costmap import Costmap, LayeredCostmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.layers.filters import FilterInfo
from arjuna_nav.costmap.layers.observations import PlacedScan
from arjuna_nav.costmap.layers.static import PlacedMap
from arjuna_nav.docking.approach import steer
from arjuna_nav.docking.dock_types import DOCK_TYPES, DockSenses
from arjuna_nav.navigator import Ending
from arjuna_nav.planners.base import PLANNERS, PlanStatus
from arjuna_nav.planners.hybrid.moves import arcs
from arjuna_nav.planners.waves.potential import spread, traversal_costs
from arjuna_nav.safety.collision_monitor import CollisionMonitor
from arjuna_nav.safety.sight import Sight
from arjuna_nav.safety.velocity_smoother import VelocitySmoother
from arjuna_nav.smoothers.base import SMOOTHERS
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.motion import differential, omnidirectional
from arjuna_slam.amcl.sensor_models import make_sensor
from arjuna_slam.matching.map_field import MapField
from tests.helpers.nav.as_nav2 import nav2_config
from tests.helpers.nav.navigator_script import DETOUR, GOAL, Script, failed, planned
from tests.nav.worlds import block, costmap_of, empty_grid, room, scan_from
from tests.slam.amcl.test_sensor_models import seen

pytestmark = pytest.mark.ros
ROBOT = Footprint.circle(0.25)
ROOM = room()


@functools.cache
def free() -> Costmap:
    """Return a free costmap, 12 m square about the origin."""
    return costmap_of(empty_grid(12.0, 12.0, SE2(-6.0, -6.0)))


# planner_server


def planner(name: str, **values: Any) -> Any:
    given = {f"GridBased.{key}": value for key, value in values.items()}
    made = nav2_config("planner_server", **{"GridBased.plugin": name}, **given).GridBased
    return PLANNERS.make(made, ROBOT)


# hf = 50 free; two equal neighbours: v = 0.704, one 14.8 higher (d = 0.296): v = 0.84093
@pytest.mark.parametrize(
    ("cell", "expected"),
    [((0, 1), 50.0), ((1, 1), 85.2), ((0, 2), 100.0), ((1, 2), 127.2465), ((0, -1), 50.0)],
)
def test_potential_of_navfn(cell: tuple[int, int], expected: float) -> None:
    data, costs = np.zeros((21, 21), np.uint8), traversal_costs()
    potential = spread(data, costs, np.array([[10.0, 10.0, 0.0]]))
    assert potential[10 + cell[0], 10 + cell[1]] == pytest.approx(expected, abs=1e-3)


# COST_NEUTRAL 50 + COST_FACTOR 0.8 x cost; from 253 on none
@pytest.mark.parametrize(
    ("cost", "expected"), [(0, 50.0), (100, 130.0), (250, 250.0), (253, math.inf), (254, math.inf)]
)
def test_costs_of_navfn(cost: int, expected: float) -> None:
    assert traversal_costs()[cost] == pytest.approx(expected)


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
    ("name", "cost", "through"),
    [(SMAC_2D, 90, True), (SMAC_2D, 130, False), (THETA, 80, True), (THETA, 180, False)],
)
def test_a_cost_is_gone_round_where_that_is_cheaper(name: str, cost: int, through: bool) -> None:
    data = np.zeros((81, 161), np.uint8)
    data[30:51, 75:85] = cost
    values = {"cost_travel_multiplier": 2.0} if name == SMAC_2D else {}
    costmap = Costmap(GridFrame(0.1, 161, 81), data)
    path = planner(name, **values).plan(costmap, SE2(4.05, 4.05), SE2(12.05, 4.05)).path
    aside = np.abs(path[:, 1] - 4.05).max()
    assert aside < 0.3 if through else aside > 0.8


def test_bends_of_hybrid() -> None:
    # 2 asin(sqrt 2 / 16) = 0.177 rad: 3 bins of 5 degrees; at 8 cells (8 sin 15, 8 - 8 cos 15)
    moves = arcs(0.0, 72, 8.0, False, (2.0, 1.2, 0.0), False)
    left = int(np.flatnonzero((moves.sides == 1) & (np.arange(len(moves.sides)) < 3))[0])
    end = moves.poses[moves.begins[left + 1] - 1]
    assert end == pytest.approx([2.070552, 0.272593, math.radians(15.0)], abs=1e-5)
    # its arc 8 x 0.261799, by non_straight_penalty
    assert moves.costs[left] == pytest.approx(8.0 * 0.261799 * 1.2, abs=1e-4)


# smoother_server

PEAK = np.array([[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 0, 0], [4, 0, 0]], np.float64)
SPIKE = np.column_stack((np.arange(11.0), np.eye(11)[5], np.zeros(11)))
SIMPLE, FITTED = "nav2_smoother::SimpleSmoother", "nav2_smoother::SavitzkyGolaySmoother"
SMOOTHED: dict[str, tuple[str, dict[str, Any], Any, list[float]]] = {
    # 0.2 (0 - a) + 0.3 (b - 2a) = 0, 0.2 (1 - b) + 0.3 (2a - 2b) = 0: b = 0.2 / 0.575, a = 0.375 b
    "balance": (SIMPLE, {"do_refinement": False}, PEAK, [0, 0.130435, 0.347826, 0.130435, 0]),
    # once more from there: 0.575 b = 0.2 x 0.347826 + 0.75 x 0.2 x 0.130435
    "refined": (SIMPLE, {"refinement_num": 1}, PEAK, [0, 0.090737, 0.155009, 0.090737, 0]),
    # w_data alone keeps the path
    "data": (SIMPLE, {"w_smooth": 0.0}, PEAK, [0, 0, 1, 0, 0]),
    # -2 3 6 7 6 3 -2 over 21
    "fit": (FITTED, {"do_refinement": False}, SPIKE,
            [k / 21 for k in (0, 0, -2, 3, 6, 7, 6, 3, -2, 0, 0)]),
    # beyond an end its point counts: y1 = (-2 + 3 + 6 + 7 c) / 21 of a first point at y = 1
    "ends": (FITTED, {"do_refinement": False}, np.column_stack(
        (np.arange(11.0), np.eye(11)[0], np.zeros(11))), [1, 7 / 21, 1 / 21, -2 / 21, *[0] * 7]),
}  # fmt: skip


@pytest.mark.parametrize("case", SMOOTHED)
def test_smoothers(case: str) -> None:
    name, values, path, expected = SMOOTHED[case]
    given = {f"simple_smoother.{key}": value for key, value in values.items()}
    made = nav2_config(
        "smoother_server", **{"simple_smoother.plugin": name}, **given
    ).simple_smoother
    costmap = costmap_of(empty_grid(20.0, 20.0, SE2(-5.0, -5.0), 0.1))
    result = SMOOTHERS.make(made).smooth(path, costmap)
    assert result.path[:, 1] == pytest.approx(expected, abs=1e-5)


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


def test_the_recoveries_are_nav2s_in_their_order() -> None:
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


def test_a_path_is_replaced_each_second_by_whatever_is_planned() -> None:
    # RateController hz 1.0, and no PathValid above it: a worse path is followed too
    navigation = script()
    navigation.tick()
    navigation.tick(plan=planned())
    assert navigation.tick(0.8) == []
    assert navigation.tick(0.2) == ["plan"]


def test_an_error_ends_it_after_six_recoveries() -> None:
    navigation, done = script(), ["plan"]
    navigation.tick()
    while navigation.end is None:
        answers = {name: failed() if name == "plan" else True for name in done}
        done = navigation.tick(**answers)  # type: ignore[arg-type]
    # 7 clearings beside the planner, 2 + 1 + 1 + 1 + 2 + 1 by the round: each counts
    assert navigation.recoveries == 15
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


# velocity_smoother: 20 Hz, so that 2.5 and 3.2 allow 0.125 m/s and 0.16 rad/s a tick

SMOOTHING: dict[str, tuple[dict[str, Any], Velocity, Velocity, Velocity]] = {
    "gains speed": ({}, STILL, Velocity(0.5), Velocity(0.125)),
    "brakes": ({"max_decel": [-1.0, 0.0, -3.2]}, Velocity(0.5), STILL, Velocity(0.45)),
    # through zero it decelerates: 0.1 - 1.0 / 20
    "turns back": ({"max_decel": [-1.0, 0.0, -3.2]}, Velocity(0.1), Velocity(-0.5), Velocity(0.05)),
    # eta = min(0.125 / 0.5, 0.16 / 2.5) = 0.064
    "eta": ({"scale_velocities": True}, STILL, Velocity(0.5, yaw_rate=2.5),
            Velocity(0.032, yaw_rate=0.16)),
    "no eta": ({}, STILL, Velocity(0.5, yaw_rate=2.5), Velocity(0.125, yaw_rate=0.16)),
    # max_velocity first, then the acceleration
    "greatest": ({"max_velocity": [0.1, 0.0, 2.5]}, STILL, Velocity(0.5), Velocity(0.1)),
    "deadband": ({"deadband_velocity": [0.13, 0.0, 0.0]}, STILL, Velocity(0.5), STILL),
}  # fmt: skip


@pytest.mark.parametrize("case", SMOOTHING)
def test_velocity_smoother(case: str) -> None:
    values, now, command, expected = SMOOTHING[case]
    smoother = VelocitySmoother(nav2_config("velocity_smoother", feedback="CLOSED_LOOP", **values))
    smoother.take(command, 0.0)
    result = smoother.tick(now, 0.0)
    assert result is not None
    assert (result.x, result.yaw_rate) == pytest.approx((expected.x, expected.yaw_rate))


# collision_monitor

SQUARE = "[[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]]"
AHEAD = {"action_type": "approach", "type": "circle", "radius": 0.5}
MONITOR: dict[str, tuple[dict[str, Any], float, int, Velocity, Velocity]] = {
    "stop": ({"action_type": "stop", "points": SQUARE}, 0.4, 4, Velocity(0.8), STILL),
    # 3 points are fewer than min_points 4
    "no stop": ({"action_type": "stop", "points": SQUARE}, 0.4, 3, Velocity(0.8), Velocity(0.8)),
    "slowdown": ({"action_type": "slowdown", "points": SQUARE, "slowdown_ratio": 0.3}, 0.4, 4,
                 Velocity(0.8, yaw_rate=1.0), Velocity(0.24, yaw_rate=0.3)),
    # min(0.4 / 0.8, 0.5 / 2.0) of both
    "limit": ({"action_type": "limit", "points": SQUARE, "linear_limit": 0.4}, 0.4, 4,
              Velocity(0.8, yaw_rate=2.0), Velocity(0.2, yaw_rate=0.5)),
    # 0.95 - 0.1 k < 0.5 first at k = 5, whose time is 0.4: 0.4 / 2.0
    "approach": (AHEAD, 0.95, 4, Velocity(1.0), Velocity(0.2)),
    # within the circle already: 0, and no way out
    "touches": (AHEAD, -0.45, 4, Velocity(1.0), STILL),
    # 2.65 - 0.1 k < 0.5 first at k = 22, beyond 2.0 s
    "far": (AHEAD, 2.65, 4, Velocity(1.0), Velocity(1.0)),
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


# 252 exp(-10 (d - 0.25)), 253 up to the inscribed radius, nothing beyond ceil(0.55 / 0.1) cells
@pytest.mark.parametrize(
    ("cells", "cost"), [(0, 254), (2, 253), (3, 152), (4, 56), (5, 20), (6, 7), (7, 0)]
)
def test_inflation(cells: int, cost: int) -> None:
    grid = OccupancyGrid(GridFrame(0.1, 50, 50, SE2(-2.5, -2.5)), np.zeros((50, 50), np.int8))
    grid.data[25, 25] = 100
    costmap = layered(plugins=["static_layer", "inflation_layer"])
    costmap.set_map(grid)
    assert costmap.costmap.data[25, 25 + cells] == cost


SCAN = {"obstacle_layer.observation_sources": "scan", "obstacle_layer.scan.clearing": True,
        "obstacle_layer.scan.max_obstacle_height": 2.0}  # fmt: skip


# obstacle_max_range 2.5, raytrace_max_range 3.0: cells before the end are cleared, the end marks
@pytest.mark.parametrize(
    ("reading", "values", "marked"),
    [
        (1.05, {}, True),
        (2.05, {"scan.obstacle_max_range": 2.0}, False),
        (1.05, {"scan.obstacle_min_range": 1.1}, False),
        (1.05, {"scan.marking": False}, False),
        (1.05, {"scan.min_obstacle_height": 0.1}, False),  # the scan lies at 0
        (1.05, {"enabled": False}, False),
    ],
)
def test_obstacles(reading: float, values: dict[str, Any], marked: bool) -> None:
    given = {f"obstacle_layer.{key}": value for key, value in values.items()}
    costmap = layered(plugins=["obstacle_layer"], **(SCAN | given))
    scan = Scan(np.array([reading]), 0.0, 0.01, 0.1, 12.0)
    costmap.receive("obstacle_layer", "scan", PlacedScan(scan, SE2()))
    costmap.update(SE2(), 0.0)
    row, column = costmap.costmap.frame.to_cell(reading, 0.0)
    assert (costmap.costmap.data[row, column] == 254) == marked


# round(value x 254 / 100); unknown leaves the cost below it
@pytest.mark.parametrize(("value", "cost"), [(100, 254), (50, 127), (1, 3), (0, 0), (-1, 0)])
def test_keepout(value: int, cost: int) -> None:
    zones = {"zones.plugin": "nav2_costmap_2d::KeepoutFilter", "zones.filter_info_topic": "info"}
    costmap = layered(plugins=["obstacle_layer"], filters=["zones"], **SCAN, **zones)
    mask = OccupancyGrid(GridFrame(0.08, 1, 1, SE2(0.02, 0.02)), np.array([[value]], np.int8))
    costmap.receive("zones", "info", FilterInfo(0, "mask"))
    costmap.receive("zones", "mask", PlacedMap(mask, ""))
    costmap.update(SE2(), 0.0)
    # the mask reaches from 0.02 to 0.10: it holds the middle of one cell
    assert costmap.costmap.data[25, 25] == cost
    assert np.count_nonzero(costmap.costmap.data) == (cost > 0)


def test_a_zone_that_reaches_into_a_cell_leaves_it_free() -> None:
    zones = {"zones.plugin": "nav2_costmap_2d::KeepoutFilter", "zones.filter_info_topic": "info"}
    costmap = layered(plugins=["obstacle_layer"], filters=["zones"], **SCAN, **zones)
    mask = OccupancyGrid(GridFrame(0.1, 1, 1, SE2(0.06, 0.06)), np.array([[100]], np.int8))
    costmap.receive("zones", "info", FilterInfo(0, "mask"))
    costmap.receive("zones", "mask", PlacedMap(mask, ""))
    costmap.update(SE2(), 0.0)
    # from 0.06 to 0.16 it holds the middle (0.15, 0.15) alone
    assert np.argwhere(costmap.costmap.data).tolist() == [[26, 26]]


def test_from_a_collision_every_motion_collides() -> None:
    grid = OccupancyGrid(GridFrame(0.1, 50, 50, SE2(-2.5, -2.5)), np.zeros((50, 50), np.int8))
    grid.data[25, 27] = 100
    costmap = layered(plugins=["static_layer", "inflation_layer"])
    costmap.set_map(grid)
    back = np.column_stack((-0.05 * np.arange(20), np.zeros(20), np.zeros(20)))
    # 0.2 m lies within the inscribed radius, CostmapTopicCollisionChecker says no
    assert first_collision(costmap.costmap, ROBOT, back) == 0


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


DOCK = {"plugin": "opennav_docking::SimpleChargingDock"}


@pytest.mark.parametrize(
    ("values", "senses", "docked", "charging"),
    [
        ({}, DockSenses(distance=0.04, current=0.6), True, True),  # < 0.05 m, > 0.5 A
        ({}, DockSenses(distance=0.06, current=0.4), False, False),
        ({"use_battery_status": False}, DockSenses(distance=0.04), True, True),  # isDocked
        ({"use_stall_detection": True, "stall_joint_names": ["wheel"]},
         DockSenses(distance=0.04, effort=1.1, speed=0.9), True, False),
        ({"use_stall_detection": True, "stall_joint_names": ["wheel"]},
         DockSenses(distance=0.04, effort=1.1, speed=1.1), False, False),
    ],
)  # fmt: skip
def test_docks(values: dict[str, Any], senses: DockSenses, docked: bool, charging: bool) -> None:
    given = {f"dock.{key}": value for key, value in (DOCK | values).items()}
    kind = DOCK_TYPES.make(nav2_config("docking_server", dock_plugins=["dock"], **given).dock)
    assert (kind.is_docked(senses), kind.is_charging(senses)) == (docked, charging)


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


# z_hit 0.5, sigma_hit 0.2, z_rand 0.5 over 10 m: 0.5 exp(-12.5 d^2) + 0.05
@pytest.mark.parametrize(
    ("model", "distance", "factor"),
    [
        ("likelihood_field", 0.0, 1.0 + 0.55**3),
        ("likelihood_field", 0.2, 1.0 + 0.3532653**3),
        ("likelihood_field", 1.0, 1.0 + 0.05000186**3),
        ("likelihood_field_prob", 0.2, 0.3532653),
    ],
)
def test_likelihoods(model: str, distance: float, factor: float) -> None:
    grid = OccupancyGrid(GridFrame(0.1, 31, 31), np.zeros((31, 31), np.int8))
    grid.data[15, 15] = 100
    sensor = make_sensor(MapField(grid, 2.0), nav2_config("amcl", laser_model_type=model))
    at = np.array([[1.55 + distance, 1.55, 0.0]])
    likelihood = sensor.weigh(at, seen(np.zeros((1, 2))))
    assert likelihood.levels == pytest.approx([factor], rel=1e-5)


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
        ("trinary", False, 254, None, 0),
        ("trinary", False, 128, None, -1),  # 0.498
        ("trinary", True, 254, None, 100),
        ("scale", False, 128, None, 62),  # (0.498 - 0.25) / 0.4 x 100 = 62.01
        ("scale", False, 0, 0, -1),  # transparent
        ("raw", False, 42, None, 42),
        ("raw", False, 101, None, -1),
        ("trinary", False, 80, 255, -1),  # alpha is a fourth colour: 1 - 495 / 1020 = 0.515
        ("trinary", False, 255, 0, -1),  # 1 - 765 / 1020 = 0.25, no less than free_thresh
    ],
)
def test_map_server(mode: str, negate: bool, shade: int, alpha: int | None, value: int) -> None:
    options = MapOptions(mode, negate)
    given = None if alpha is None else np.array([[alpha]], np.uint8)
    assert occupancy_of(np.array([[shade]], np.uint8), given, options)[0, 0] == value
