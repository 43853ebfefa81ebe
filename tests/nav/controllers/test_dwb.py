"""DWB against its definition: of the velocities within reach, that of the least score."""

from __future__ import annotations

import functools
import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.controllers.dwb.config import (
    AGGREGATIONS,
    NAV2_CRITICS,
    DwbConfig,
    OscillationConfig,
)
from arjuna_nav.controllers.dwb.controller import Dwb
from arjuna_nav.controllers.dwb.distances import path_cells
from arjuna_nav.controllers.dwb.oscillation import Oscillation
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import RESOLUTION, costmap_of, grid_of

ORIGIN = SE2(-1.0, 0.5, 0.7)
PERIOD, TOLERANCE = 0.05, 0.2
ROW, FIRST, LAST = 40, 10, 60  # of the path's cells, straight to the right
GOAL_YAW = 1.0
GENERATORS = ("StandardTrajectoryGenerator", "LimitedAccelGenerator")


def made_costmap() -> Costmap:
    grid = grid_of(4.0, 4.0, (1.5, 2.4, 0.3, 0.3), (2.2, 1.0, 0.2, 0.7), origin=ORIGIN)
    return costmap_of(grid, radius=0.1)


COSTMAP = made_costmap()


def made_path() -> NDArray[np.float64]:
    cells = np.arange(FIRST, LAST + 1)
    in_grid = np.column_stack((cells, np.full(len(cells), ROW))) * RESOLUTION + 0.5 * RESOLUTION
    yaws = np.append(np.zeros(len(cells) - 1), GOAL_YAW)
    return np.column_stack((ORIGIN.apply(in_grid), yaws + ORIGIN.theta))


@functools.cache
def steps_to(columns: range) -> NDArray[np.float64]:
    """Return each cell's steps to some of the path's cells round what blocks."""
    far = np.full(COSTMAP.frame.shape, math.inf)
    queue = deque((ROW, column) for column in columns)
    far[ROW, list(columns)] = 0
    while queue:
        r, c = queue.popleft()
        for other in ((r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)):
            inside = 0 <= other[0] < far.shape[0] and 0 <= other[1] < far.shape[1]
            if inside and far[other] == math.inf and COSTMAP.data[other] < 253:
                far[other] = far[r, c] + 1
                queue.append(other)
    return far


@dataclass(frozen=True)
class Case:
    """A moving robot; the pose is in the grid [m]."""

    config: DwbConfig
    pose: SE2
    velocity: Velocity
    limit: float = math.inf

    @property
    def goal_gap(self) -> float:
        return math.dist((self.pose.x, self.pose.y), ((LAST + 0.5) * 0.05, (ROW + 0.5) * 0.05))

    @property
    def arrived(self) -> bool:
        return self.goal_gap <= TOLERANCE

    def chosen(self) -> Velocity | None:
        dwb = Dwb(self.config, Footprint.circle(0.1), TOLERANCE, PERIOD)
        dwb.speed_limit = self.limit
        dwb.set_path(made_path())
        result = dwb.compute(ORIGIN @ self.pose, self.velocity, COSTMAP, 0.0)
        return result.velocity if result.status is ControlStatus.SUCCEEDED else None

    @property
    def limited(self) -> bool:
        return self.config.trajectory_generator_name.endswith("LimitedAccelGenerator")

    def reachable(self) -> list[tuple[float, float, float]]:
        """Return the velocities within reach of the accelerations, and zero of each part."""
        c, now = self.config, self.velocity
        reach = PERIOD if self.limited else c.sim_time
        fastest = min(c.max_speed_xy, self.limit)
        top = min(c.max_vel_x, fastest)
        vs = spread(
            max(min(c.min_vel_x, top), now.x + c.decel_lim_x * reach),
            min(top, now.x + c.acc_lim_x * reach),
            c.vx_samples,
        )
        sides = spread(
            max(c.min_vel_y, -fastest, now.y - c.acc_lim_y * reach),
            min(c.max_vel_y, fastest, now.y + c.acc_lim_y * reach),
            c.vy_samples,
        )
        turn = c.acc_lim_theta * reach
        ws = spread(
            max(-c.max_vel_theta, self.velocity.yaw_rate - turn),
            min(c.max_vel_theta, self.velocity.yaw_rate + turn),
            c.vtheta_samples,
        )
        fastest = max(fastest, min(math.hypot(v, side) for v in vs for side in sides))
        return [
            (v, side, w)
            for v in vs
            for side in sides
            for w in ws
            if math.hypot(v, side) <= fastest + 1e-9
            and (math.hypot(v, side) >= c.min_speed_xy or abs(w) >= c.min_speed_theta)
            and (self.arrived or (v, side, w) != (0.0, 0.0, 0.0))
        ]

    def driven(self, to_v: float, to_side: float, to_w: float) -> list[SE2]:
        """Return the poses of a trajectory, in the grid [m]."""
        c, now = self.config, self.velocity
        v, side, w = (to_v, to_side, to_w) if self.limited else (now.x, now.y, now.yaw_rate)
        steps = math.ceil(math.hypot(to_v, to_side) * c.sim_time / c.linear_granularity)
        steps = max(steps, math.ceil(abs(to_w) * c.sim_time / c.angular_granularity), 1)
        if c.discretize_by_time:
            steps = math.ceil(c.sim_time / c.time_granularity)
        dt, poses = c.sim_time / steps, [self.pose]
        for _ in range(steps):
            v = nearer(v, to_v, c.acc_lim_x * dt, -c.decel_lim_x * dt)
            w = nearer(w, to_w, c.acc_lim_theta * dt, -c.decel_lim_theta * dt)
            side = nearer(side, to_side, c.acc_lim_y * dt, -c.decel_lim_y * dt)
            x, y, theta = poses[-1].array()
            cosine, sine = math.cos(theta + 0.5 * w * dt), math.sin(theta + 0.5 * w * dt)
            x += (v * cosine - side * sine) * dt
            y += (v * sine + side * cosine) * dt
            poses.append(SE2(x, y, theta + w * dt))
        return poses

    def score(self, v: float, side: float, w: float) -> float:
        c, uses = self.config, self.config.critics
        poses = self.driven(v, side, w)
        costs = [at(COSTMAP.data, pose) for pose in poses[1:]]
        if any(cost is None or cost >= 253 for cost in costs):
            return math.inf
        total, counted = 0.0, poses + poses[-1:] * c.include_last_point
        edges = [edge_cost(pose) for pose in poses[1:]]
        for name, own, found in (
            ("BaseObstacle", c.BaseObstacle, costs),
            ("ObstacleFootprint", c.ObstacleFootprint, edges),
        ):
            if name in uses:
                summed = sum(found) + c.include_last_point * found[-1]
                total += own.scale * (summed if own.sum_scores else found[-1])
        if "PreferForward" in uses:
            p = c.PreferForward
            hardly = v < p.strafe_x and abs(w) < p.strafe_theta
            total += p.scale * (p.penalty if v < 0.0 or hardly else p.theta_scale * abs(w))
        total += c.Twirling.scale * abs(w) * ("Twirling" in uses)
        if self.arrived:
            return total + self._turning_score(math.hypot(v, side), poses)
        far, ahead = self.goal_gap > c.PathAlign.forward_point_distance, self.path_ahead()
        for name, grid in (("Path", steps_to(ahead)), ("Goal", steps_to(ahead[-1:]))):
            if f"{name}Dist" in uses:
                own = getattr(c, f"{name}Dist")
                values = [at(grid, pose) for pose in counted]
                total += 0.025 * own.scale * together(values, own.aggregation_type)
            if f"{name}Align" in uses and far:
                own = getattr(c, f"{name}Align")
                points = [at(grid, pose @ SE2(own.forward_point_distance)) for pose in counted]
                most = float(sum(grid.shape))
                values = [most if value is None else min(value, most) for value in points]
                total += 0.025 * own.scale * together(values, own.aggregation_type)
        return total

    def _turning_score(self, speed: float, poses: list[SE2]) -> float:
        """Return what turning to the goal's heading costs where its position is reached."""
        c = self.config
        if "RotateToGoal" not in c.critics:
            return 0.0
        own, score = c.RotateToGoal, 0.0
        now = math.hypot(self.velocity.x, self.velocity.y)
        if now > c.trans_stopped_velocity:
            score = own.scale * own.slowing_factor * speed**2 if speed < now else math.inf
        elif speed != 0.0:
            return math.inf
        share = 1.0 if own.lookahead_time < 0.0 else min(own.lookahead_time / c.sim_time, 1.0)
        counted = poses[math.floor((len(poses) - 1) * share + 1e-9)]
        return score + own.scale * abs(wrap(GOAL_YAW - counted.theta))

    def path_ahead(self) -> range:
        """Return the columns of the path's cells that count."""
        nearest = min(max(round(self.pose.x / RESOLUTION - 0.5), FIRST), LAST)
        last = min(math.floor(nearest + self.config.forward_prune_distance / 0.05 + 1e-6), LAST)
        return range(nearest, max(last, min(nearest + 1, LAST)) + 1)


def spread(low: float, high: float, count: int) -> list[float]:
    values = np.linspace(low, high, count).tolist() if low < high else [low]
    return [*values, 0.0] if low < 0.0 < high and 0.0 not in values else values


def nearer(value: float, target: float, up: float, down: float) -> float:
    faster = abs(target) > abs(value) and value * target >= 0.0
    most = up if faster else down
    return value + min(max(target - value, -most), most)


def at(grid: NDArray[Any], pose: SE2) -> Any:
    row, column = math.floor(pose.y / RESOLUTION), math.floor(pose.x / RESOLUTION)
    inside = 0 <= row < grid.shape[0] and 0 <= column < grid.shape[1]
    return float(grid[row, column]) if inside else None


def edge_cost(pose: SE2) -> float:
    """Return the worst cost on the outline, each edge in steps of half a cell."""
    corners, worst = Footprint.circle(0.1).points, 0.0
    for a, b in zip(np.roll(corners, 1, axis=0), corners, strict=True):
        count = int(2.0 * math.dist(a, b) / RESOLUTION) + 1
        on_edge = [a + (b - a) * k / count for k in range(count)]
        costs = [at(COSTMAP.data, pose @ SE2(float(x), float(y))) for x, y in on_edge]
        worst = max(worst, *(cost or 0.0 for cost in costs))
    return worst


def together(values: list[float], how: str) -> float:
    """Return what MapGridCritic makes of a trajectory's values; 0 ends a product."""
    if how != "product":
        return sum(values) if how == "sum" else values[-1]
    total = 1.0
    for value in values:
        total *= value if total > 0.0 else 1.0
    return total


def made_case(seed: int) -> Case:
    rng = np.random.default_rng(seed)
    base, scale = DwbConfig(), lambda: float(rng.uniform(1.0, 30.0))
    config = replace(
        base,
        min_vel_x=float(rng.choice([0.0, -0.3])),
        min_speed_xy=float(rng.choice([0.0, 0.12])),
        acc_lim_x=float(rng.uniform(0.05, 0.5)),
        decel_lim_x=-float(rng.uniform(0.05, 0.5)),
        acc_lim_theta=float(rng.uniform(0.2, 1.0)),
        decel_lim_theta=-float(rng.uniform(0.2, 1.0)),
        vx_samples=5,
        vtheta_samples=6,
        sim_time=float(rng.uniform(0.8, 1.7)),
        angular_granularity=0.1,
        forward_prune_distance=float(rng.uniform(0.3, 1.5)),
        critics=tuple(name for name in NAV2_CRITICS if rng.random() < 0.6),
        PathDist=replace(base.PathDist, scale=scale()),
        GoalDist=replace(base.GoalDist, scale=scale()),
        PathAlign=replace(base.PathAlign, scale=scale(), forward_point_distance=0.3),
        GoalAlign=replace(base.GoalAlign, scale=scale(), forward_point_distance=0.2),
        Twirling=replace(base.Twirling, scale=0.3 * scale()),
        PreferForward=replace(base.PreferForward, scale=0.3 * scale(), theta_scale=1.0),
        BaseObstacle=replace(base.BaseObstacle, scale=0.3, sum_scores=bool(rng.integers(2))),
        ObstacleFootprint=replace(
            base.ObstacleFootprint, scale=0.2, sum_scores=bool(rng.integers(2))
        ),
        RotateToGoal=replace(
            base.RotateToGoal, scale=scale(), lookahead_time=float(rng.choice([-1.0, 0.5]))
        ),
    )
    near = bool(rng.integers(2))
    x, y = (2.95, 2.0) if near else rng.uniform((0.6, 1.8), (2.5, 2.2))
    pose = SE2(float(x), float(y), float(rng.uniform(-2.0, 2.0)))
    velocity = Velocity(float(rng.uniform(-0.1, 0.5)), yaw_rate=float(rng.uniform(-0.6, 0.6)))
    case = Case(config, pose, velocity, float(rng.choice([math.inf, 0.25])))
    if seed >= 10:
        grids = ("PathDist", "GoalDist", "PathAlign", "GoalAlign")
        kinds = {
            name: replace(getattr(config, name), aggregation_type=str(rng.choice(AGGREGATIONS)))
            for name in grids
        }
        return replace(case, config=replace(config, critics=NAV2_CRITICS, **kinds))
    if seed % 2:
        return case
    config = replace(
        config,
        min_vel_y=-0.3,
        max_vel_y=0.2,
        acc_lim_y=float(rng.uniform(0.1, 0.5)),
        decel_lim_y=-float(rng.uniform(0.1, 0.5)),
        min_speed_theta=float(rng.choice([0.0, 0.2])),
        discretize_by_time=bool(rng.integers(2)),
        time_granularity=0.2,
        trajectory_generator_name=f"dwb_plugins::{rng.choice(GENERATORS)}",
    )
    velocity = replace(velocity, y=float(rng.uniform(-0.2, 0.2)))
    return replace(case, config=config, velocity=velocity)


@pytest.mark.parametrize("seed", range(16))
def test_drives_the_velocity_within_reach_that_scores_least(seed: int) -> None:
    case = made_case(seed)
    scores = {sample: case.score(*sample) for sample in case.reachable()}
    chosen, least = case.chosen(), min(scores.values())
    if chosen is None:
        assert least == math.inf
        return
    found = (chosen.x, chosen.y, chosen.yaw_rate)
    own = next(s for sample, s in scores.items() if sample == pytest.approx(found))
    assert own == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("key", ["min_speed_xy", "min_speed_theta", "max_speed_xy"])
def test_a_speed_below_zero_limits_nothing(key: str) -> None:
    case = made_case(3)
    free: dict[str, Any] = {"min_speed_xy": 0.0, "min_speed_theta": 0.0, "max_speed_xy": 100.0}
    slowest = {"min_speed_xy": 100.0, "min_speed_theta": 100.0} if "min" in key else {}
    expected = replace(case, config=replace(case.config, **free)).chosen()
    limits: dict[str, Any] = {**free, **slowest, key: -1.0}
    assert replace(case, config=replace(case.config, **limits)).chosen() == expected


def test_says_that_every_trajectory_collides_and_from_where() -> None:
    config = DwbConfig(vx_samples=3, vtheta_samples=4, linear_granularity=0.05)
    dwb = Dwb(config, Footprint.circle(0.1), TOLERANCE, PERIOD)
    dwb.set_path(made_path())
    result = dwb.compute(ORIGIN @ SE2(1.65, 2.55), STILL, COSTMAP, 0.0)
    assert result.status is ControlStatus.NO_VALID_CONTROL
    where = ORIGIN @ SE2(1.65, 2.55)
    said = f"collision ahead at every one of 14 velocities from ({where.x:.2f}, {where.y:.2f})"
    assert result.message == said


def test_of_fewer_samples_than_two_it_takes_two() -> None:
    config = DwbConfig(vx_samples=0, vy_samples=0, vtheta_samples=1, linear_granularity=0.05)
    dwb = Dwb(config, Footprint.circle(0.1), TOLERANCE, PERIOD)
    dwb.set_path(made_path())
    result = dwb.compute(ORIGIN @ SE2(1.65, 2.55), STILL, COSTMAP, 0.0)
    # 0 and the greatest speed by -1, 0 and 1 rad/s, but for standing
    assert "every one of 5 velocities" in result.message


@pytest.mark.parametrize("tolerance", [None, 0.1, 0.5])
def test_no_tolerance_stops_it_short_of_the_goal_checkers(tolerance: float | None) -> None:
    far = SE2((LAST + 0.5) * 0.05 - 0.3, (ROW + 0.5) * 0.05)
    velocity = Case(DwbConfig(xy_goal_tolerance=tolerance), far, STILL).chosen()
    assert velocity is not None
    assert velocity.x > 0.0


@pytest.mark.parametrize("drift", [-0.004, 0.0, 0.004])
def test_a_robot_that_slips_sideways_turns_at_the_goal_all_the_same(drift: float) -> None:
    there = SE2((LAST + 0.5) * 0.05, (ROW + 0.5) * 0.05, GOAL_YAW - 1.0)
    case = Case(DwbConfig(min_vel_y=0.0, max_vel_y=0.0, acc_lim_y=0.0), there, Velocity(y=drift))
    chosen = case.chosen()
    assert chosen is not None
    assert (chosen.x, chosen.y) == (0.0, 0.0)
    assert chosen.yaw_rate > 0.0


BACK, FORTH, STRAFE_RIGHT, STRAFE_LEFT, RIGHT, LEFT = range(6)
V, W = (lambda v: Velocity(v)), (lambda w: Velocity(yaw_rate=w))


@pytest.mark.parametrize(
    ("commands", "forbidden"),
    [
        ([V(0.1), V(0.1)], set()),
        ([V(0.1), V(-0.1)], {FORTH}),
        ([V(-0.1), V(0.0), V(0.1)], {BACK}),
        ([V(0.1), V(-0.1), V(-0.1)], {FORTH}),
        ([W(0.1), W(-0.1)], {LEFT}),
        ([W(-0.1), W(0.0), W(0.1)], {RIGHT}),
        ([Velocity(0.05, yaw_rate=0.1), Velocity(-0.05, yaw_rate=-0.1)], {FORTH, LEFT}),
        ([Velocity(0.06, yaw_rate=0.1), Velocity(0.06, yaw_rate=-0.1)], set()),
        ([Velocity(y=0.1), Velocity(y=-0.1)], {STRAFE_LEFT}),
        ([Velocity(y=-0.1), Velocity(y=0.1)], {STRAFE_RIGHT}),
        ([V(0.0), W(0.1), W(0.2)], set()),
        ([Velocity(-0.05, y=-0.1, yaw_rate=-0.1)], set()),
    ],
)
def test_oscillating_velocities_are_refused(commands: list[Velocity], forbidden: set[int]) -> None:
    oscillation = Oscillation(OscillationConfig())
    for command in commands:
        oscillation.take(command, SE2(), 0.0)
    assert sum(oscillation.allowed, ()) == tuple(k not in forbidden for k in range(6))


@pytest.mark.parametrize(
    ("pose", "at", "values", "got_on"),
    [
        (SE2(0.5, 0.0, 3.0), 9.0, {}, False),
        (SE2(0.51, 0.0, 3.0), 9.0, {}, True),
        (SE2(0.51, 0.0, 3.0), 9.0, {"oscillation_reset_dist": -1.0}, False),
        (SE2(0.0, 0.0, -3.0), 9.0, {}, False),
        (SE2(0.0, 0.0, -2.9), 9.0, {}, True),
        (SE2(0.0, 0.0, -2.9), 9.0, {"oscillation_reset_angle": -1.0}, False),
        (SE2(0.0, 0.0, 3.0), 3.0, {"oscillation_reset_time": 2.0}, False),
        (SE2(0.0, 0.0, 3.0), 3.1, {"oscillation_reset_time": 2.0}, True),
    ],
)
def test_until_the_robot_got_on_from_where_it_changed(
    pose: SE2, at: float, values: dict[str, float], got_on: bool
) -> None:
    limits = {"oscillation_reset_dist": 0.5, "oscillation_reset_angle": 0.3, **values}
    oscillation = Oscillation(OscillationConfig(**limits))
    oscillation.take(V(0.1), SE2(9.0, 9.0, 0.0), 0.0)
    oscillation.take(V(-0.1), SE2(0.0, 0.0, 3.0), 1.0)
    oscillation.take(V(-0.1), pose, at)
    assert sum(oscillation.allowed, ()) == (True, got_on, *4 * [True])
    oscillation.reset()
    assert all(sum(oscillation.allowed, ()))


def test_each_path_allows_all_turns_again() -> None:
    """A robot near its goal that had turned both ways stood until its progress was missed."""
    config = DwbConfig(critics=("Oscillation", "Twirling"), max_vel_x=0.0, vtheta_samples=3)
    dwb, pose = Dwb(config, Footprint.circle(0.1), TOLERANCE, PERIOD), ORIGIN @ SE2(1.0, 2.0)
    dwb.set_path(made_path())
    for turn in (-0.5, 0.5):
        dwb._oscillation.take(W(turn), pose, 0.0)
    assert dwb.compute(pose, STILL, COSTMAP, 0.0).velocity.yaw_rate > 0.0
    dwb.set_path(made_path())
    assert dwb.compute(pose, STILL, COSTMAP, 0.0).velocity.yaw_rate < 0.0


@pytest.mark.parametrize("seed", range(3))
def test_a_paths_cells_hold_its_points_and_lie_side_by_side(seed: int) -> None:
    height, width = 30, 40
    points = np.random.default_rng(seed).uniform((1.0, 1.0), (width - 1.0, height - 1.0), (6, 2))
    rows, columns = np.divmod(path_cells(points, height, width), width)
    cells = list(zip(columns.tolist(), rows.tolist(), strict=True))
    assert {(int(x), int(y)) for x, y in points} <= set(cells)
    assert max(np.abs(np.diff(cells, axis=0)).max(axis=1)) == 1
    outside = np.array([*points[:2], (width + 5.0, points[1, 1])])
    assert path_cells(outside, height, width)[-1] == int(points[1, 1]) * width + width - 1
