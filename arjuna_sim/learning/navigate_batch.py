"""Gymnasium's vector environment `arjuna/NavigateBatch-v0`: many robots stepped together."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Singles
from arjuna_core.errors import ConfigError
from arjuna_sim.batch.batch import Batch, Variation
from arjuna_sim.learning.navigate import Navigate, Observed, numbers_of
from arjuna_sim.learning.task import goals_seen, judged, observed, scan_points


class NavigateBatch(VectorEnv[Observed, Singles, NDArray[Any]]):
    """`Navigate` for copies of one robot and world, in MuJoCo Warp on a GPU or on the CPU.

    Spaces, rewards and ends are those of `Navigate`, and so are its arguments. An episode that
    ended begins again with the next step, whose action does not count (`NEXT_STEP`). One of a robot
    whose physics could not be solved is truncated; `info["lost"]` says so.

    `reset(seed=...)` makes all that follows the same on the same device, bit by bit; frictions and
    masses stay. Its options `start` and `goal` have a row for each robot.

    Args:
        num_envs: How many.
        device: `cpu`, `cuda` or `cuda:1`.
        variation: How robots and floors differ; not at all by default.
        given: What `Navigate` takes.

    Raises:
        ConfigError: As `Navigate`, and where the device is not there.
        RobotError: As `Navigate`, and where a batch does not take the robot.
        WorldError: As `Navigate`, and where a batch does not take the world.
    """

    def __init__(
        self,
        num_envs: int = 1,
        device: str = "cpu",
        variation: Variation | None = None,
        **given: Any,
    ) -> None:
        if num_envs < 1:
            raise ConfigError(f"'num_envs' is {num_envs}; valid: 1 or more")
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}
        self.num_envs, self._one = num_envs, Navigate(**given)
        self.single_action_space = self._one.action_space
        self.single_observation_space = self._one.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        sim = self._one.simulation
        self._poses, self._goals = np.zeros((num_envs, 3)), np.zeros((num_envs, 2))
        self._velocities = np.zeros((num_envs, len(self._one.bounds)))
        self._elapsed, self._over = np.zeros(num_envs), np.ones(num_envs, np.bool_)
        robot, world = sim.robot.model, sim.world
        self._batch = Batch(robot, world, self._poses, sim.config, variation, device=device)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin an episode of each robot; see the class."""
        super().reset(seed=seed)
        self._batch.reseed(int(self.np_random.integers(2**31)))
        self._draw(np.ones(self.num_envs, np.bool_))
        given = dict(options or {})
        self._poses = numbers_of(given, "start", self._poses)
        self._goals = numbers_of(given, "goal", self._goals)
        if given:
            raise ConfigError(f"options {sorted(given)} are unknown; valid: 'start' and 'goal'")
        self._begin(np.ones(self.num_envs, np.bool_))
        none = np.zeros(self.num_envs, np.bool_)
        return self._look(), {"is_success": none, "touched": none, "lost": none}

    def _draw(self, which: Bools) -> None:
        for i in np.flatnonzero(which):
            self._poses[i], self._goals[i] = self._one.draw(self.np_random)

    def _begin(self, which: Bools) -> None:
        """Begin episodes of some robots, at the starts and goals that were drawn."""
        self._batch.put(self._poses, which)
        self._velocities[which] = 0.0
        self._elapsed[which] = 0.0
        self._over[which] = False

    def step(self, actions: Singles) -> tuple[Observed, Floats, Bools, Bools, dict[str, Any]]:
        """Drive all for a step; see the class."""
        begins, before = self._over.copy(), self._away()
        if begins.any():
            self._draw(begins)
            self._begin(begins)
        commands = np.zeros((self.num_envs, 3))
        commands[:, [0, 2]] = np.where(begins[:, None], 0.0, actions)
        touched, lost = np.zeros_like(begins), np.zeros_like(begins)
        for _ in range(self._one.ticks):
            state = self._batch.step(commands)
            touched |= state.touched
            lost |= state.lost
        self._poses = np.where(lost[:, None], self._poses, state.poses)
        self._velocities = np.where(lost[:, None], 0.0, state.measured[:, [0, 2]])
        config = self._one.config
        self._elapsed += np.where(begins, 0.0, config.step)
        seen = self._look()
        near = seen["scan"].min(axis=1) * config.scan_reach
        after, radius = self._away(), self._one.radius
        out = judged(config, before, after, near, touched, self._elapsed, radius)
        drives = ~begins
        reached, touched = out.reached & drives, out.touched & drives
        late = (out.late | lost) & drives & ~touched & ~reached
        self._over = reached | touched | late
        info = {"is_success": reached, "touched": touched, "lost": lost & drives}
        return seen, out.reward * drives, reached | touched, late, info

    def _away(self) -> Floats:
        away = self._goals - self._poses[:, :2]
        return np.hypot(away[:, 0], away[:, 1])

    def _look(self) -> Observed:
        """Return what the robots observe now."""
        one, ranges = self._one, self._batch.scan().astype(np.float64)
        goals = goals_seen(self._poses, self._goals, one.config.goal_reach)
        points = scan_points(ranges, *one.beams)
        return observed(one.config, points, goals, self._velocities, one.bounds)

    def close_extras(self, **given: Any) -> None:
        """Free what the simulation holds."""
        self._one.close()
