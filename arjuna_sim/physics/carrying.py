"""Carrying the state of a simulation over to a model that was compiled anew."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

# Numbers that a joint has in qpos and in qvel, where it is not one each.
_SIZES = {
    int(mujoco.mjtJoint.mjJNT_FREE): (7, 6),
    int(mujoco.mjtJoint.mjJNT_BALL): (4, 3),
}


def carry_over(old: Any, old_data: Any, new: Any, data: Any) -> None:
    """Copy the state of all joints, motors and mocap bodies that both models have.

    Args:
        old: The `mujoco.MjModel` that was simulated.
        old_data: Its `mujoco.MjData`.
        new: The model to go on with.
        data: Its data, which is changed.
    """
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
    """Return where a joint is in qpos and in qvel."""
    kind = int(model.jnt_type[joint])
    at, rate = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    positions, rates = _SIZES.get(kind, (1, 1))
    return slice(at, at + positions), slice(rate, rate + rates)
