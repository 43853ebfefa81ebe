"""Learning: the task and its environment."""

from __future__ import annotations

import gc
import importlib
import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError, RobotError
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.learning import task
from arjuna_sim.learning.task import TaskConfig
from arjuna_sim.model.geometry.walls import surfaces
from tests.sim.builders import EMPTY, ROBOT, ROOM, first
from tests.sim.drive_cases import mecanum

gymnasium = pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
ID = "arjuna/Navigate-v0"


@pytest.fixture(scope="module", autouse=True)
def registered() -> None:
    importlib.import_module("arjuna")


def drive(env: Any, steps: int, seed: int) -> list[bytes]:
    """Return all that random actions bring, episodes and all, as bytes."""
    rng = np.random.default_rng(seed)
    seen, _ = env.reset(seed=seed)
    brought = [value.tobytes() for value in seen.values()]
    low, high = env.action_space.low, env.action_space.high
    for _ in range(steps):
        action = rng.uniform(low, high).astype(np.float32)
        seen, reward, terminated, truncated, _ = env.step(action)
        brought += [value.tobytes() for value in seen.values()]
        brought.append(np.array([reward, terminated, truncated], np.float64).tobytes())
        if terminated or truncated:
            seen, _ = env.reset()
            brought += [value.tobytes() for value in seen.values()]
    return brought


def test_gymnasiums_checker_has_nothing_to_refuse() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # v and w have units of their own, as those of a command.
        warnings.filterwarnings("ignore", message=".*recommend using a symmetric")
        check_env(gymnasium.make(ID).unwrapped)


def test_the_same_seed_brings_the_same_bytes_whatever_was_before() -> None:
    env = gymnasium.make(ID, time_limit=2.0)
    first = drive(env, 60, 7)
    other = drive(env, 60, 8)
    assert drive(env, 60, 7) == first
    assert drive(gymnasium.make(ID, time_limit=2.0), 60, 7) == first
    assert other != first


def test_environments_in_processes_bring_what_each_brings_alone() -> None:
    gc.collect()  # in a fork, what other tests left of the middleware cannot be freed
    made = gymnasium.make_vec(ID, 2, "async", time_limit=1.0, vector_kwargs={"shared_memory": True})
    alone = [gymnasium.make(ID, time_limit=1.0) for _ in range(2)]
    try:
        seen, _ = made.reset(seed=5)
        each = [env.reset(seed=5 + i)[0] for i, env in enumerate(alone)]
        for _ in range(9):
            actions = np.array([[0.4, 0.5], [0.2, -0.5]], np.float32)
            for i in range(2):
                for name in seen:
                    np.testing.assert_array_equal(seen[name][i], each[i][name])
            seen, rewards, *_ = made.step(actions)
            stepped = [env.step(action) for env, action in zip(alone, actions, strict=True)]
            each = [one[0] for one in stepped]
            assert rewards.tolist() == [one[1] for one in stepped]
    finally:
        made.close()


def test_a_robot_that_drives_at_its_goal_reaches_it() -> None:
    env = gymnasium.make(ID, world=str(EMPTY)).unwrapped
    seen, _ = env.reset(seed=0, options={"start": (0.0, 0.0, 1.0), "goal": (1.5, -0.5)})
    angle = math.atan2(-0.5, 1.5) - 1.0
    expected = math.hypot(1.5, 0.5) * np.array([math.cos(angle), math.sin(angle)])
    np.testing.assert_allclose(seen["goal"], expected, atol=1e-3)
    assert (seen["scan"] == 1.0).all()
    rewards = []
    for _ in range(150):
        bearing = math.atan2(seen["goal"][1], seen["goal"][0])
        action = np.array([0.4 if abs(bearing) < 0.3 else 0.0, np.clip(2 * bearing, -1.5, 1.5)])
        seen, reward, terminated, _, info = env.step(action.astype(np.float32))
        rewards.append(reward)
        if terminated:
            break
    assert info == {"is_success": True, "touched": False}
    assert rewards[-1] > 9.0
    assert sum(rewards) == pytest.approx(
        10.0 + math.hypot(1.5, 0.5) - 0.25 - 0.01 * len(rewards), abs=0.1
    )


def test_a_robot_that_runs_into_a_box_ends_there() -> None:
    env = gymnasium.make(ID).unwrapped
    env.reset(seed=0, options={"start": (1.5, 0.0, 0.0), "goal": (4.0, 0.0)})
    for _ in range(60):
        seen, reward, terminated, truncated, info = env.step(np.array([0.5, 0.0], np.float32))
        if terminated:
            break
    assert info == {"is_success": False, "touched": True}
    assert not truncated
    assert reward < -9.0
    assert seen["scan"].argmin() in (17, 18)
    assert seen["velocity"][0] < 0.5


def test_an_episode_is_cut_short_in_time() -> None:
    env = gymnasium.make(ID, time_limit=0.5, step=0.06, simulator=None).unwrapped
    env.reset(seed=0)
    ends = [env.step(np.zeros(2, np.float32))[2:4] for _ in range(9)]
    assert ends[:8] == [(False, False)] * 8
    assert ends[8] == (False, True)


def test_what_is_wrong_is_named() -> None:
    with pytest.raises(ConfigError, match=r"unknown parameter 'sectrs'.*sectors"):
        gymnasium.make(ID, sectrs=3)
    with pytest.raises(ConfigError, match=r"'step' is 0\.05 s; valid: a whole number of ticks"):
        gymnasium.make(ID, step=0.05)
    env = gymnasium.make(ID)
    with pytest.raises(ConfigError, match=r"option 'goal' is \[1\.0\]; valid: 2 numbers"):
        env.reset(options={"goal": (1.0,)})
    with pytest.raises(ConfigError, match=r"options \['gaol'\] are unknown; valid: 'start'"):
        env.reset(options={"gaol": (1.0, 2.0)})


def test_a_robot_without_lidar_is_refused() -> None:
    robot = load_robot(ROBOT)
    blind = replace(robot, settings=replace(robot.settings, sensors=()))
    with pytest.raises(RobotError, match=r"arjuna\.urdf: has no lidar"):
        gymnasium.make(ID, robot=blind)


def test_a_robot_that_moves_sideways_is_driven_so(tmp_path: Path) -> None:
    base = load_robot(mecanum().write(tmp_path))
    lidar = replace(first(load_robot(ROBOT), LidarSettings), link=base.urdf.root)
    robot = replace(base, settings=replace(base.settings, sensors=(lidar,)))
    env = gymnasium.make(ID, world=EMPTY, robot=robot).unwrapped
    env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (0.0, 3.0)})
    for _ in range(20):
        seen, *_ = env.step(np.array([0.0, 0.3, 0.0], np.float32))
    np.testing.assert_allclose(seen["velocity"], [0.0, 0.3, 0.0], atol=0.05)
    np.testing.assert_allclose(seen["goal"], [0.0, 2.4], atol=0.1)


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
