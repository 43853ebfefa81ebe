"""Claims: many robots observe, earn and end as one does, repeat themselves, and begin again."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import ConfigError, RobotError
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.devices.sensors.lidar import LidarConfig, LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from tests.sim.builders import ROBOT, first
from tests.sim.drive_cases import mecanum

gymnasium = pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
pytest.importorskip("warp", reason="the extra 'gpu' is not installed")

# One process for all: each would compile Warp's kernels, for up to a minute, where none has yet.
pytestmark = pytest.mark.xdist_group("batch")
ID = "arjuna/NavigateBatch-v0"
QUIET = SimulatorConfig(lidar=LidarConfig(noise=0.0))
STARTS = np.array([[0.0, 0.0, 0.0], [1.3, 0.0, 0.0]])
GOALS = np.array([[1.0, 0.5], [4.0, 0.0]])  # the second behind the box at 2.5 m
AHEAD = np.array([[0.4, 0.3], [0.5, 0.0]], np.float32)


@pytest.fixture(scope="module", autouse=True)
def registered() -> None:
    importlib.import_module("arjuna")


@pytest.fixture(scope="module")
def envs(registered: None) -> Any:
    made = gymnasium.make_vec(ID, num_envs=2, simulator=QUIET, time_limit=3.0)
    yield made
    made.close()


def test_each_robot_observes_earns_and_ends_as_one_that_is_alone(envs: Any) -> None:
    seen, _ = envs.reset(seed=1, options={"start": STARTS, "goal": GOALS})
    assert seen in envs.observation_space
    alone = [
        gymnasium.make("arjuna/Navigate-v0", simulator=QUIET, time_limit=3.0) for _ in range(2)
    ]
    running = [True, True]
    for k, env in enumerate(alone):
        env.reset(seed=1, options={"start": STARTS[k], "goal": GOALS[k]})
    for _ in range(30):
        seen, reward, terminated, truncated, info = envs.step(AHEAD)
        for k in np.flatnonzero(running).tolist():
            expected = alone[k].step(AHEAD[k])
            for name, values in expected[0].items():
                # A tick of an encoder is 0.0064 rad/s.
                within = 0.015 if name == "velocity" else 2e-3
                np.testing.assert_allclose(seen[name][k], values, atol=within)
            assert reward[k] == pytest.approx(expected[1], abs=5e-3)
            assert (terminated[k], truncated[k]) == expected[2:4]
            for name in ("is_success", "touched"):
                assert info[name][k] == expected[4][name]
            running[k] = not (terminated[k] or truncated[k])
    assert running == [False, False]


def test_who_touched_something_begins_again_at_rest_with_the_next_step(envs: Any) -> None:
    envs.reset(seed=1, options={"start": STARTS, "goal": GOALS})
    for _ in range(30):
        _, _, terminated, _, info = envs.step(AHEAD)
        if terminated[1]:
            break
    assert info["touched"].tolist() == [False, True]
    seen, reward, terminated, truncated, _ = envs.step(AHEAD)
    assert reward[1] == 0.0
    assert not terminated[1]
    assert not truncated[1]
    np.testing.assert_allclose(seen["velocity"][1], 0.0, atol=0.02)
    assert np.hypot(*seen["goal"][1]) >= 0.99  # drawn anew, a metre away at least
    _, reward, *_ = envs.step(AHEAD)
    assert reward[1] != 0.0


def test_the_same_seed_brings_the_same_bytes() -> None:
    envs = gymnasium.make_vec(ID, num_envs=2, time_limit=1.0)

    def drive(seed: int) -> list[bytes]:
        rng, brought = np.random.default_rng(3), []
        seen, _ = envs.reset(seed=seed)
        for _ in range(15):  # each robot begins again once at least
            actions = rng.uniform(0.0, 0.5, (2, 2)).astype(np.float32)
            brought += [values.tobytes() for values in seen.values()]
            seen, *ends, _ = envs.step(actions)
            brought += [values.tobytes() for values in ends]
        return brought

    first = drive(5)
    assert drive(6) != first
    assert drive(5) == first


def test_a_lost_robots_episode_is_cut_short(envs: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from arjuna_sim.batch.batch import Batch

    envs.reset(seed=1, options={"start": STARTS, "goal": GOALS})
    step = Batch.step

    def losing(batch: Batch, commands: Any) -> Any:
        state = step(batch, commands)
        poses = state.poses.copy()
        poses[0] = np.nan
        return state._replace(poses=poses, lost=np.array([True, False]))

    with monkeypatch.context() as patch:
        patch.setattr(Batch, "step", losing)
        seen, reward, terminated, truncated, info = envs.step(AHEAD)
    assert seen in envs.observation_space
    assert np.isfinite(reward).all()
    assert terminated.tolist() == [False, False]
    assert truncated.tolist() == info["lost"].tolist() == [True, False]
    assert not envs.step(AHEAD)[4]["lost"].any()


def test_what_it_cannot_do_is_refused(envs: Any, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="options \\['pose'\\] are unknown; valid: 'start'"):
        envs.reset(options={"pose": STARTS})
    with pytest.raises(ConfigError, match=r"option 'goal' is .*; valid: 2 x 2 numbers"):
        envs.reset(options={"goal": STARTS})
    with pytest.raises(ConfigError, match="'num_envs' is 0; valid: 1 or more"):
        gymnasium.make_vec(ID, num_envs=0)
    base = load_robot(mecanum().write(tmp_path))
    lidar = replace(first(load_robot(ROBOT), LidarSettings), link=base.urdf.root)
    robot = replace(base, settings=replace(base.settings, sensors=(lidar,)))
    with pytest.raises(RobotError, match="mecanum wheels; valid: differential"):
        gymnasium.make_vec(ID, num_envs=1, robot=robot)
