"""MPPI's critics against their definitions, on seeded rollouts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import SE2, wrap
from arjuna_nav.controllers.mppi.config import (
    CostConfig,
    CriticConfig,
    DeadbandConfig,
    GoalAngleConfig,
    NearGoalConfig,
    ObstaclesConfig,
    PathAlignConfig,
    PathAngleConfig,
    PathFollowConfig,
)
from arjuna_nav.controllers.mppi.critics import (
    constraint,
    cost_critic,
    deadband,
    goal,
    goal_angle,
    obstacles_critic,
    prefer_forward,
    twirling,
)
from arjuna_nav.controllers.mppi.path_critics import path_align, path_angle, path_follow
from arjuna_nav.controllers.mppi.rollouts import Limits, Rollouts
from arjuna_nav.controllers.mppi.scene import Grid, Scene
from arjuna_nav.costmap.inflation import clearances

STEPS, BATCH, DT, RADIUS = 12, 6, 0.05, 0.25
GOAL, UNTOLD = SE2(0.7, -0.4, 2.8), clearances(0.0)
LIMITS = Limits(-0.2, 0.3, 1.0, 2.5, 2.5, 3.0)
Floats = NDArray[Any]
Asked = Callable[[float], Floats | None]


def made_rollouts(seed: int = 1) -> Rollouts:
    v, w, x, y, yaw = np.random.default_rng(seed).normal(0.0, 0.5, (5, STEPS, BATCH))
    parts = (v, w, x, y, 4.0 * yaw, np.empty((0, 0)))
    return Rollouts(*(np.ascontiguousarray(a, np.float32) for a in parts))


def made_scene(**changes: Any) -> Scene:
    """Return 30 poses 0.1 m apart on a bend, all free, on a costmap with costs of all kinds."""
    s = 0.1 * np.arange(30)
    path = np.column_stack((np.sin(s), 1.0 - np.cos(s), s)).astype(np.float32)
    data = np.random.default_rng(5).integers(0, 253, (40, 40)).astype(np.uint8)
    data[18:21, 23:26], data[15, 15:20], data[26:29, 18:20] = 254, 255, 253
    outline = np.array([[2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0], [2.0, -1.0]])
    grid = Grid(data, 20.3, 19.6, 0.4, 10.0, outline, False, 100)
    scene = Scene(path, np.ones(30, np.bool_), GOAL, 1.0, 10, grid, UNTOLD, RADIUS, LIMITS, DT)
    return scene._replace(**changes)


def wrapped(angles: Floats) -> Floats:
    sizes: Floats = np.abs(wrap(angles.astype(np.float64)))
    return sizes


R = made_rollouts()
S = R._replace(side=np.random.default_rng(2).normal(0.0, 0.5, (STEPS, BATCH)).astype(np.float32))
ALONG = np.hypot(S.v, S.side) * np.sign(S.v)
"""Speeds over ground, negative where the robot drives back."""
SIDEWAYS = LIMITS._replace(side_max=0.4)
AT = made_scene().path[16, :2].astype(float)
"""The pose six beyond the farthest that is reached."""


def angle_to_it(poses: Rollouts, both_directions: bool) -> Floats:
    off = wrapped(np.arctan2(AT[1] - poses.y[-1], AT[0] - poses.x[-1]) - poses.yaw[-1])
    return np.minimum(off, math.pi - off) if both_directions else off


@pytest.mark.parametrize(
    ("cost", "expected"),
    [
        (
            goal(NearGoalConfig(cost_weight=3.0, threshold_to_consider=1.0), R, made_scene()),
            3.0 * np.hypot(R.x - GOAL.x, R.y - GOAL.y).mean(axis=0),
        ),
        (
            goal_angle(
                GoalAngleConfig(cost_weight=2.0, threshold_to_consider=1.0), R, made_scene()
            ),
            2.0 * wrapped(R.yaw - GOAL.theta).mean(axis=0),
        ),
        (
            goal_angle(
                GoalAngleConfig(threshold_to_consider=1.0, symmetric_yaw_tolerance=True),
                R,
                made_scene(),
            ),
            np.minimum(wrapped(R.yaw - GOAL.theta), math.pi - wrapped(R.yaw - GOAL.theta)).mean(
                axis=0
            ),
        ),
        (
            prefer_forward(
                NearGoalConfig(cost_weight=5.0, threshold_to_consider=1.0), R, made_scene()
            ),
            5.0 * DT * np.maximum(-R.v, 0.0).sum(axis=0),
        ),
        (
            constraint(CriticConfig(cost_weight=4.0), R, made_scene()),
            4.0 * DT * (np.maximum(R.v - 0.3, 0.0) + np.maximum(-0.2 - R.v, 0.0)).sum(axis=0),
        ),
        (
            constraint(CriticConfig(cost_weight=4.0), S, made_scene(limits=SIDEWAYS)),
            4.0
            * DT
            * (np.maximum(ALONG - 0.5, 0.0) + np.maximum(-math.hypot(0.2, 0.4) - ALONG, 0.0)).sum(
                axis=0
            ),
        ),
        (
            twirling(CriticConfig(cost_weight=10.0), R, made_scene()),
            10.0 * np.abs(R.w).mean(axis=0),
        ),
        (
            deadband(
                DeadbandConfig(cost_weight=35.0, deadband_velocities=(0.2, 9.0, 0.3)),
                R,
                made_scene(),
            ),
            35.0
            * DT
            * (np.maximum(0.2 - np.abs(R.v), 0.0) + np.maximum(0.3 - np.abs(R.w), 0.0)).sum(axis=0),
        ),
        (
            deadband(
                DeadbandConfig(cost_weight=35.0, deadband_velocities=(0.0, 0.4, 0.0)),
                S,
                made_scene(),
            ),
            35.0 * DT * np.maximum(0.4 - np.abs(S.side), 0.0).sum(axis=0),
        ),
        (
            path_follow(
                PathFollowConfig(cost_weight=5.0, threshold_to_consider=1.0), R, made_scene()
            ),
            5.0 * np.hypot(R.x[-1] - AT[0], R.y[-1] - AT[1]),
        ),
        (
            path_angle(
                PathAngleConfig(cost_weight=2.2, threshold_to_consider=1.0, offset_from_furthest=6),
                R,
                made_scene(),
            ),
            2.2 * angle_to_it(R, both_directions=False),
        ),
        (
            path_angle(
                PathAngleConfig(
                    threshold_to_consider=1.0,
                    offset_from_furthest=6,
                    max_angle_to_furthest=0.7,
                    mode=1,
                ),
                R,
                made_scene(),
            ),
            angle_to_it(R, both_directions=True),
        ),
    ],
)
def test_each_costs_what_it_is_defined_to(cost: Floats, expected: Floats) -> None:
    assert cost == pytest.approx(expected, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize(
    ("asked", "counts_near"),
    [
        (lambda d: goal(NearGoalConfig(), R, made_scene(goal_distance=d)), True),
        (lambda d: goal_angle(GoalAngleConfig(), R, made_scene(goal_distance=d)), True),
        (lambda d: prefer_forward(NearGoalConfig(), R, made_scene(goal_distance=d)), False),
        (lambda d: path_follow(PathFollowConfig(), R, made_scene(goal_distance=d)), False),
        (
            lambda d: path_angle(
                PathAngleConfig(max_angle_to_furthest=0.0), R, made_scene(goal_distance=d)
            ),
            False,
        ),
        (
            lambda d: path_align(PathAlignConfig(), R, made_scene(goal_distance=d, furthest=20)),
            False,
        ),
    ],
)
def test_counts_on_one_side_of_its_distance_from_the_goal(asked: Asked, counts_near: bool) -> None:
    assert (asked(0.49) is not None) is counts_near
    assert asked(0.5) is not None, "the edge belongs to both"
    assert (asked(0.51) is not None) is not counts_near


@pytest.mark.parametrize(("distance", "counts"), [(0.25, False), (0.26, True)])
def test_turning_is_free_within_the_goals_tolerance(distance: float, counts: bool) -> None:
    scene = made_scene(goal_distance=distance)._replace(xy_goal_tolerance=0.25)
    assert (twirling(CriticConfig(), R, scene) is not None) is counts


def test_the_path_is_followed_to_the_next_free_pose_and_no_further_than_its_end() -> None:
    config = PathFollowConfig(offset_from_furthest=6)
    scene = made_scene()
    scene.free[16:18] = False
    x, y = scene.path[18, :2]
    assert path_follow(config, R, scene) == pytest.approx(np.hypot(R.x[-1] - x, R.y[-1] - y))
    scene.free[16:] = False
    x, y = scene.path[-1, :2]
    for last in (scene, made_scene(furthest=27)):
        assert path_follow(config, R, last) == pytest.approx(np.hypot(R.x[-1] - x, R.y[-1] - y))


@pytest.mark.parametrize(
    ("bearing", "forwards", "both_directions"),
    [(0.4, False, False), (0.6, True, True), (-0.6, True, True), (3.0, True, False)],
)
def test_the_angle_counts_where_the_path_leads_away(
    bearing: float, forwards: bool, both_directions: bool
) -> None:
    path = np.zeros((30, 3), np.float32)
    path[-1, :2] = math.cos(bearing), math.sin(bearing)
    scene = made_scene(path=path, furthest=28)
    for mode, counts in ((0, forwards), (1, both_directions)):
        config = PathAngleConfig(max_angle_to_furthest=0.5, mode=mode)
        assert (path_angle(config, R, scene) is not None) is counts


@pytest.mark.parametrize(
    ("bearing", "heading", "counts"),
    [
        (0.2, 0.0, False),
        (0.2, math.pi, True),
        (3.0, 0.0, False),
        (3.0, 3.1, True),
        (1.2, 1.0, True),
    ],
)
def test_mode_2_may_back_towards_the_path(bearing: float, heading: float, counts: bool) -> None:
    """By hand: a pose behind that faces ahead is reached by backing, one that faces back is not.

    (3.0, 0.0): the bearing and the pose's heading part by over a right angle, so it is turned about
    to -0.14 rad, which is within 0.5; (3.0, 3.1): they agree, and 3.0 rad are not.
    """
    path = np.zeros((30, 3), np.float32)
    path[-1] = math.cos(bearing), math.sin(bearing), heading
    scene, config = (
        made_scene(path=path, furthest=28),
        PathAngleConfig(max_angle_to_furthest=0.5, mode=2, cost_weight=2.0),
    )
    against = abs(wrap(bearing - heading)) > 0.5 * math.pi
    off = abs(wrap(bearing + (math.pi if against else 0.0)))
    assert (off >= 0.5) is counts, "the case is worked out wrong"
    costs = path_angle(config, R, scene)
    assert (costs is not None) is counts
    if costs is not None:
        sight = np.arctan2(path[-1, 1] - R.y[-1], path[-1, 0] - R.x[-1]).astype(np.float64)
        turned = np.where(wrapped(sight - heading) > 0.5 * math.pi, sight + math.pi, sight)
        assert costs == pytest.approx(2.0 * wrapped(turned - R.yaw[-1]), rel=1e-4, abs=1e-4)


def test_where_the_robot_cannot_reverse_its_front_counts() -> None:
    path = np.zeros((30, 3), np.float32)
    path[-1, :2] = -1.0, 0.1
    scene = made_scene(path=path, furthest=28)
    for mode in (1, 2):
        config = PathAngleConfig(max_angle_to_furthest=0.5, mode=mode)
        assert path_angle(config, R, scene) is None
        front = path_angle(replace(config, mode=0), R, scene)
        forwards_only = scene._replace(limits=LIMITS._replace(v_min=0.0))
        assert path_angle(config, R, forwards_only) == pytest.approx(front)


def mean_gap(b: int, scene: Scene, step: int) -> float:
    """Return a rollout's mean distance from the pose of the path that is as far along."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(scene.path[:, :2], axis=0).T)))
    points = np.column_stack((R.x[::step, b], R.y[::step, b]))
    driven = np.cumsum(np.hypot(*np.diff(points, axis=0).T))
    nearest = [int(np.abs(along - distance).argmin()) for distance in driven]
    gaps = [
        math.dist(point, scene.path[i, :2])
        for point, i in zip(points[1:], nearest, strict=True)
        if scene.free[i]
    ]
    return float(np.mean(gaps)) if gaps else 0.0


@pytest.mark.parametrize("step", [1, 4])
def test_alignment_is_the_mean_distance_from_what_of_the_path_is_as_far(step: int) -> None:
    config = PathAlignConfig(cost_weight=10.0, offset_from_furthest=10, trajectory_point_step=step)
    scene = made_scene()
    scene.free[12:15] = False
    expected = [10.0 * mean_gap(b, scene, step) for b in range(BATCH)]
    assert path_align(config, R, scene) == pytest.approx(expected, rel=1e-4)


def test_alignment_counts_once_enough_of_the_path_is_reached_and_free() -> None:
    config = PathAlignConfig(offset_from_furthest=9, max_path_occupancy_ratio=0.2)
    assert path_align(config, R, made_scene(furthest=8)) is None
    scene = made_scene(furthest=9)
    scene.free[[3, 4, 10, 11]] = False  # of ten poses two
    assert path_align(config, R, scene) is not None
    scene.free[0] = False
    assert path_align(config, R, scene) is None


def cells_of(b: int, grid: Grid) -> list[tuple[int, int]]:
    centres = np.column_stack((R.x[:, b], R.y[:, b])).astype(np.float64)
    at = SE2(grid.x, grid.y, grid.theta).apply(grid.scale * centres)
    return [(math.floor(y), math.floor(x)) for x, y in at]


def summed(table: Floats, scene: Scene, step: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Return what a table says of the cells under each rollout's centre, and which collide."""
    data, sums, hit = scene.grid.data, np.zeros(BATCH), np.zeros(BATCH, np.bool_)
    for b in range(BATCH):
        for row, column in cells_of(b, scene.grid)[::step]:
            if not (0 <= row < data.shape[0] and 0 <= column < data.shape[1]):
                hit[b] = True
                continue
            sums[b] += table[data[row, column]]
            hit[b] |= data[row, column] in (253, 254)
    return sums, hit


@pytest.mark.parametrize(("distance", "step"), [(1.0, 2), (1.01, 2), (1.01, 3)])
def test_costs_are_averaged_and_collisions_cost_their_own(distance: float, step: int) -> None:
    config = CostConfig(
        cost_weight=3.0,
        critical_cost=300.0,
        collision_cost=1e4,
        near_collision_cost=240,
        near_goal_distance=1.0,
        trajectory_point_step=step,
    )
    scene = made_scene(goal_distance=distance)
    table = np.where(np.arange(256) < 254, np.arange(256) * (distance > 1.0), 0.0)
    table[240:255] = 300.0
    sums, hit = summed(table, scene, step)
    assert 0 < hit.sum() < BATCH
    expected = np.where(hit, 1e4, sums) * 3.0 / 254 / len(range(0, STEPS, step))
    costs, blocked = cost_critic(config, R, scene)
    assert costs == pytest.approx(expected, rel=1e-4)
    assert not blocked


@pytest.mark.parametrize("scaling", [0.0, 11.0])
@pytest.mark.parametrize("distance", [0.5, 0.51])
def test_obstacles_repel_by_the_distance_that_costs_encode(distance: float, scaling: float) -> None:
    config = ObstaclesConfig(
        repulsion_weight=2.5, critical_weight=20.0, collision_cost=1e3, near_goal_distance=0.5
    )
    scene = made_scene(goal_distance=distance)._replace(
        clearances=clearances(scaling), inflation_radius=0.7
    )
    near, far = np.zeros(256), np.zeros(256)
    for cost in range(1, 255):  # cost = 252 exp(-k d) beyond the inscribed radius
        away = math.log(252.0 / cost) / (scaling or 3.0)
        near[cost], far[cost] = max(0.1 - away, 0.0), max(0.7 - away, 0.0)
    (sums, hit), (repelled, _) = summed(near, scene, 1), summed(far, scene, 1)
    assert 0 < hit.sum() < BATCH
    costs, blocked = obstacles_critic(config, R, scene)
    # ObstaclesCritic::score: raw_cost, and repulsive_cost less the least, over the length
    expected = 20.0 * np.where(hit, 1e3, sums)
    expected += 2.5 * (repelled - repelled.min()) / STEPS * (distance > 0.5)
    assert costs == pytest.approx(expected, rel=1e-3)
    assert not blocked


@pytest.mark.parametrize("consider", [False, True])
def test_all_collide_where_the_outline_counts_and_has_no_room(consider: bool) -> None:
    scene, still = made_scene(), Rollouts(*(0.0 * a for a in R))
    scene.grid.data[:] = 120
    scene.grid.data[19, 22] = 254  # within the outline, not under the centre
    assert cost_critic(CostConfig(consider_footprint=consider), still, scene)[1] is consider
    own = ObstaclesConfig(consider_footprint=consider)
    assert obstacles_critic(own, still, scene)[1] is consider


def test_alignment_may_count_headings_a_radian_as_a_metre() -> None:
    scene = made_scene()
    plain, oriented = (
        PathAlignConfig(
            cost_weight=1.0,
            offset_from_furthest=10,
            trajectory_point_step=STEPS - 1,
            use_path_orientations=with_headings,
        )
        for with_headings in (False, True)
    )
    gaps, both = path_align(plain, R, scene), path_align(oriented, R, scene)
    assert gaps is not None
    assert both is not None
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(scene.path[:, :2], axis=0).T)))
    driven = np.hypot(R.x[-1] - R.x[0], R.y[-1] - R.y[0])
    at = [int(np.abs(along - distance).argmin()) for distance in driven]
    off = wrapped(R.yaw[-1] - scene.path[at, 2])
    assert both == pytest.approx(np.hypot(gaps, off), rel=1e-4)
