"""Claims: the task is computed for many robots as for each, by the geometry that it documents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.errors import ConfigError
from arjuna_sim.files.world_file import load_world
from arjuna_sim.learning import task
from arjuna_sim.learning.task import TaskConfig
from arjuna_sim.model.geometry.walls import surfaces
from tests.sim.builders import EMPTY, ROOM

CONFIG = TaskConfig()
NONE = np.array([False])


def test_a_sector_reads_its_nearest_point_counter_clockwise_from_behind() -> None:
    points = np.array([[[-1.0, -0.1], [1.0, 0.1], [0.5, 0.1], [-0.1, 1.5], [9.0, -1.0]]])
    points = np.concatenate((points, np.full((1, 1, 2), np.inf)), axis=1)
    found = task.sector_ranges(points, 4, 2.0)
    expected = [math.hypot(1.0, 0.1), 2.0, math.hypot(0.5, 0.1), math.hypot(0.1, 1.5)]
    np.testing.assert_allclose(found, [expected])


def test_beams_end_where_the_lidar_sees_them() -> None:
    origin, directions = task.beams_of(
        np.array([0.0, 0.5 * math.pi, math.pi]), np.array([0.1, 0.2, 0.5 * math.pi])
    )
    points = task.scan_points(np.array([[1.0, np.inf, -np.inf]]), origin, directions)
    np.testing.assert_allclose(points[0, [0, 2]], [[0.1, 1.2], [0.1, 0.2]], atol=1e-12)
    assert np.isinf(points[0, 1]).all()


def test_goals_are_seen_from_the_robot_and_drawn_in_to_the_reach() -> None:
    poses = np.array([[1.0, 2.0, 0.5 * math.pi], [0.0, 0.0, 0.0]])
    found = task.goals_seen(poses, np.array([[1.0, 4.0], [3.0, 4.0]]), 2.5)
    np.testing.assert_allclose(found, [[2.0, 0.0], [1.5, 2.0]], atol=1e-12)


def test_a_batch_is_observed_as_each_of_its_robots() -> None:
    rng = np.random.default_rng(1)
    points, goals = rng.normal(0.0, 2.0, (5, 90, 2)), rng.normal(0.0, 1.0, (5, 2))
    velocities, bounds = rng.normal(0.0, 1.0, (5, 2)), np.array([1.0, 3.0])
    whole = task.observed(CONFIG, points, goals, velocities, bounds)
    for i in range(5):
        row = slice(i, i + 1)
        each = task.observed(CONFIG, points[row], goals[row], velocities[row], bounds)
        for name in whole:
            np.testing.assert_array_equal(whole[name][row], each[name])
    assert np.abs(whole["velocity"]).max(axis=0) == pytest.approx([1.0, 2.0], abs=1.0)
    assert whole["scan"].min() >= 0.0
    assert whole["scan"].max() <= 1.0


@pytest.mark.parametrize(
    ("after", "touched", "elapsed", "ends", "reward"),
    [
        (1.9, False, 1.0, (False, False, False), 0.1 - 0.01),
        (0.2, False, 60.0, (True, False, False), 1.8 - 0.01 + 10.0),
        (0.2, True, 60.0, (False, True, False), 1.8 - 0.01 - 10.0),
        (2.0, False, 60.0, (False, False, True), -0.01),
    ],
)
def test_an_episode_ends_at_the_goal_at_a_touch_or_in_time(
    after: float, touched: bool, elapsed: float, ends: tuple[bool, ...], reward: float
) -> None:
    before, now, nearest, time = (np.array([value]) for value in (2.0, after, 1.5, elapsed))
    out = task.judged(CONFIG, before, now, nearest, np.array([touched]), time, 0.3)
    assert (out.reached[0], out.touched[0], out.late[0]) == ends
    assert out.reward[0] == pytest.approx(reward)


def test_nearness_costs_the_more_the_nearer() -> None:
    nearest = np.array([1.0, 0.45, 0.375, 0.3, 0.1])
    away = np.full(5, 2.0)
    out = task.judged(CONFIG, away, away, nearest, np.repeat(NONE, 5), np.zeros(5), 0.3)
    np.testing.assert_allclose(out.reward, [-0.01, -0.01, -0.06, -0.11, -0.11])


def test_starts_and_goals_are_drawn_as_far_apart_as_asked_for() -> None:
    free = np.random.default_rng(2).uniform(-5.0, 5.0, (500, 2))
    rng = np.random.default_rng(3)
    for _ in range(100):
        start, goal = task.drawn(CONFIG, free, rng)
        assert CONFIG.shortest <= math.hypot(*(goal - start[:2])) <= CONFIG.longest
    with pytest.raises(ConfigError, match=r"no start and goal lie 1 to 10 m apart"):
        task.drawn(CONFIG, free[:1], rng)


def test_free_points_keep_their_room_inside_the_walls() -> None:
    points = task.free_points(surfaces(load_world(ROOM), 0.2), 0.5, 10.0)
    assert np.abs(points).max() <= 4.9 - 0.4
    assert np.hypot(*(points - (2.5, 0.0)).T).min() >= 0.25 + 0.4
    assert len(points) > 20_000


def test_a_world_without_walls_is_cut_to_a_square() -> None:
    points = task.free_points(surfaces(load_world(EMPTY), 0.2), 0.5, 8.0)
    np.testing.assert_allclose(np.abs(points).max(axis=0), 3.5, atol=0.11)
    with pytest.raises(ConfigError, match=r"no connected space that is 5\.00 m from all walls"):
        task.free_points(surfaces(load_world(EMPTY), 0.2), 5.0, 8.0)
