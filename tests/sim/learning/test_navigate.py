"""Claims: the environment keeps Gymnasium's contract, repeats itself, and ends as documented."""

from __future__ import annotations

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
from tests.sim.builders import EMPTY, ROBOT, first
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
