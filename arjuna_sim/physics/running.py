"""Running a compiled model, asleep where it rests, and carrying its state over to another."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from arjuna_core.arrays import Bytes

# Numbers that a joint has in qpos and in qvel, where it is not one each.
_SIZES = {
    int(mujoco.mjtJoint.mjJNT_FREE): (7, 6),
    int(mujoco.mjtJoint.mjJNT_BALL): (4, 3),
}


def saved(model: Any) -> Bytes:
    """Return a compiled model as MuJoCo saves it, `(N,) uint8`."""
    content = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content


def loaded(content: Bytes) -> Any:
    """Return the model that was `saved`."""
    return mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": content.tobytes()})


def let_sleep(model: Any, driven: Iterable[int]) -> None:
    """Let all that moves sleep but that of which motors turn some body."""
    model.tree_sleep_policy[:] = int(mujoco.mjtSleepPolicy.mjSLEEP_ALLOWED)
    for body in driven:
        tree = model.body_treeid[body]
        model.tree_sleep_policy[tree] = int(mujoco.mjtSleepPolicy.mjSLEEP_NEVER)


def in_single_precision(model: Any) -> Any:
    """Return a copy of a model that can be solved in 32 bits, in which nothing sleeps."""
    copied = copy.copy(model)
    copied.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    copied.tree_sleep_policy[:] = int(mujoco.mjtSleepPolicy.mjSLEEP_AUTO)
    # With `STICTION`, 1e6, 12 of 64 robots that run into things are lost, with 1e5 one; with this
    # none. A parked robot creeps a hundred times faster than it did: by less than 0.1 mm/min.
    copied.opt.impratio = min(copied.opt.impratio, 1e4)
    return copied


class Stepper:
    """Runs a model's physics.

    MuJoCo 4.0 errs by some per cent of a step for all that is awake in the step in which something
    falls asleep. So those steps are taken again from their start, without what then sleeps.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._is_alone = model.ntree < 2
        sizes = [_SIZES.get(int(kind), (1, 1))[0] for kind in model.jnt_type]
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


def carry_over(old: Any, old_data: Any, new: Any, data: Any) -> None:
    """Copy the state of all joints, motors and mocap bodies that both models have."""
    for i in range(new.njnt):
        name = new.joint(i).name
        j = mujoco.mj_name2id(old, mujoco.mjtObj.mjOBJ_JOINT, name)
        if j >= 0:
            to, of = _span(new, i), _span(old, j)
            data.qpos[to[0]] = old_data.qpos[of[0]]
            data.qvel[to[1]] = old_data.qvel[of[1]]
            data.qacc_warmstart[to[1]] = old_data.qacc_warmstart[of[1]]
    for i in np.flatnonzero(new.body_mocapid >= 0).tolist():
        j = mujoco.mj_name2id(old, mujoco.mjtObj.mjOBJ_BODY, new.body(i).name)
        if j >= 0 and old.body_mocapid[j] >= 0:
            to_id, of_id = new.body_mocapid[i], old.body_mocapid[j]
            data.mocap_pos[to_id] = old_data.mocap_pos[of_id]
            data.mocap_quat[to_id] = old_data.mocap_quat[of_id]
    for i in range(new.nu):
        name = new.actuator(i).name
        j = mujoco.mj_name2id(old, mujoco.mjtObj.mjOBJ_ACTUATOR, name)
        if j >= 0:
            data.ctrl[i] = old_data.ctrl[j]
            if new.actuator_actadr[i] >= 0:
                data.act[new.actuator_actadr[i]] = old_data.act[old.actuator_actadr[j]]
    data.time = old_data.time


def _span(model: Any, joint: int) -> tuple[slice, slice]:
    kind = int(model.jnt_type[joint])
    at, rate = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    positions, rates = _SIZES.get(kind, (1, 1))
    return slice(at, at + positions), slice(rate, rate + rates)
