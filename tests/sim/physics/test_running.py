"""The state of a model carried over to another."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from arjuna_sim.physics.running import carry_over

BALL = "<geom size='0.1'/>"
PARTS = {
    "slide": f"<body pos='3 0 1'><joint name='slide' type='slide'/>{BALL}</body>",
    "turn": f"<body pos='4 0 1'><joint name='turn' type='ball'/>{BALL}</body>",
    "free": f"<body name='free' pos='1 0 1'><freejoint name='free'/>{BALL}</body>",
    "put": f"<body name='put' mocap='true' pos='2 0 1'>{BALL}</body>",
    "still": f"<body name='still' pos='5 0 1'>{BALL}</body>",
    "hinge": f"<body pos='6 0 1'><joint name='hinge'/>{BALL}</body>",
}
MOTORS = {
    "slide": "<motor name='slide' joint='slide'/>",
    "hinge": "<general name='hinge' joint='hinge' dyntype='integrator'/>",
}


def model_of(*names: str) -> Any:
    bodies = "".join(PARTS[name] for name in names)
    motors = "".join(MOTORS[name] for name in names if name in MOTORS)
    text = f"<worldbody>{bodies}</worldbody><actuator>{motors}</actuator>"
    return mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")


def test_what_two_models_have_keeps_its_state_and_all_else_its_start() -> None:
    old, new = (
        model_of("slide", "turn", "put", "hinge"),
        model_of("free", "hinge", "still", "put", "slide", "turn"),
    )
    before, rng = mujoco.MjData(old), np.random.default_rng(1)
    for values in (before.qpos, before.qvel, before.qacc_warmstart, before.ctrl, before.act):
        values[:] = rng.random(len(values))
    before.mocap_pos[:], before.mocap_quat[:] = rng.random((1, 3)), rng.random((1, 4))
    before.time = 7.0
    data, start = mujoco.MjData(new), mujoco.MjData(new)
    carry_over(old, before, new, data)
    for name in ("slide", "turn", "hinge"):
        for value in ("qpos", "qvel", "qacc_warmstart"):
            given, found = (getattr(each.joint(name), value) for each in (before, data))
            np.testing.assert_array_equal(found, given)
    np.testing.assert_array_equal(data.joint("free").qpos, start.joint("free").qpos)
    for name in ("slide", "hinge"):
        assert data.actuator(name).ctrl == before.actuator(name).ctrl
    assert data.act.tolist() == before.act.tolist()
    assert data.mocap_pos.tolist() == before.mocap_pos.tolist()
    assert data.mocap_quat.tolist() == before.mocap_quat.tolist()
    assert data.time == 7.0
