"""Sleeping: what lies still costs little until something touches it, and nothing else notices."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

_SIZES = {0: 7, 1: 4}  # of a free joint and a ball in qpos; others have one value


def let_sleep(model: Any, robots: Iterable[int]) -> None:
    """Let all that moves sleep but robots, of which the roots' bodies are given."""
    model.tree_sleep_policy[:] = int(mujoco.mjtSleepPolicy.mjSLEEP_ALLOWED)
    for root in robots:
        tree = model.body_treeid[root]
        model.tree_sleep_policy[tree] = int(mujoco.mjtSleepPolicy.mjSLEEP_NEVER)


class Stepper:
    """Runs a model's physics.

    MuJoCo 4.0 errs by some per cent of a step for all that is awake in the step in which something
    falls asleep. So those steps are taken again from their start, without what then sleeps.

    Args:
        model: The `mujoco.MjModel`.
        data: The `mujoco.MjData`.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._is_alone = model.ntree < 2
        sizes = [_SIZES.get(int(kind), 1) for kind in model.jnt_type]
        self._tree_of_rate = model.dof_treeid.copy()
        self._tree_of_position = np.repeat(model.dof_treeid[model.jnt_dofadr], sizes)

    def run(self, steps: int) -> None:
        """Run a number of steps."""
        model, data = self._model, self._data
        if self._is_alone:
            mujoco.mj_step(model, data, nstep=steps)
            return
        start = [each.copy() for each in (data.qpos, data.qvel, data.qacc_warmstart, data.act)]
        awake, time = data.tree_awake.copy(), data.time
        while True:
            mujoco.mj_step(model, data, nstep=steps)
            now = data.tree_awake.astype(bool)
            if not (awake.astype(bool) & ~now).any():
                return
            positions, rates = now[self._tree_of_position], now[self._tree_of_rate]
            data.qpos[positions] = start[0][positions]
            data.qvel[rates] = start[1][rates]
            data.qacc_warmstart[rates] = start[2][rates]
            data.act[:], data.time = start[3], time
            awake = now
