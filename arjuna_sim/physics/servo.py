"""Wheel servos: the motors that make the wheels follow the speeds they are told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_sim.model.robot import Robot


@dataclass(frozen=True)
class ServoConfig:
    """How a wheel follows its commanded speed."""

    response_time: float = param(
        0.005,
        "Time in which the motors take up an error of speed, were their torque unlimited.",
        unit="s",
        minimum=0.001,
        maximum=1.0,
        read_only=True,
    )
    integral_time: float = param(
        0.1,
        "Time in which what the load holds back is made up for.",
        unit="s",
        minimum=0.02,
        maximum=10.0,
        read_only=True,
    )
    armature: float = param(
        0.0,
        "Rotor inertia as the wheel feels it.",
        unit="kg m^2",
        minimum=0.0,
        read_only=True,
    )


@dataclass(frozen=True)
class Servos:
    """The servos of all wheels, left ones first; each array is `(W,)`.

    Attributes:
        position: Addresses of the wheels in qpos.
        velocity: Addresses of the wheels in qvel.
        lead: How far the wanted angle runs ahead of the wheel's, per speed [s].
        reach: How far it may run ahead until the torque is at its limit [rad].
    """

    position: NDArray[np.int64]
    velocity: NDArray[np.int64]
    lead: NDArray[np.float64]
    reach: NDArray[np.float64]

    def turn(self, data: Any, speeds: NDArray[np.float64]) -> None:
        """Tell the wheels how fast to turn [rad/s], `(W,) float64`.

        The wanted angle runs ahead by the wanted speed, and by what the load holds back as far as
        the torque goes: a wheel that was held does not make up for it.
        """
        angle = data.qpos[self.position]
        room = self.reach - self.lead * np.abs(speeds - data.qvel[self.velocity])
        behind = data.act - self.lead * data.ctrl - angle
        behind = np.clip(behind, -np.maximum(room, 0.0), np.maximum(room, 0.0))
        data.act[:] = angle + behind + self.lead * speeds
        data.ctrl[:] = speeds

    def rest(self, data: Any) -> None:
        """Tell the wheels, which stand, to stay where they are."""
        data.act[:] = data.qpos[self.position]
        data.ctrl[:] = 0.0


def add_servo(spec: Any, joint: str, torque: float) -> None:
    """Add a motor to a wheel's joint, with a torque limit [N m]."""
    motor = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
    motor.gaintype, motor.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    motor.forcelimited, motor.forcerange = True, [-torque, torque]


def tune_servos(model: Any, robot: Robot, config: ServoConfig) -> Servos:
    """Set the gains of a compiled model's motors by what they move.

    A wheel moves itself and its share of the robot. Its motor is a proportional-integral control of
    speed, written as a damped spring to the angle that the wanted speed sums up to: it holds a
    parked wheel. The damping is implicit in MuJoCo's step, so that no inertia is too light for it.

    Args:
        model: The `mujoco.MjModel`, which is changed.
        robot: The robot.
        config: How fast they are.
    """
    names = robot.wheel_joints
    joints = [model.joint(name) for name in names]
    velocity = np.array([joint.dofadr[0] for joint in joints], np.int64)
    share = robot.urdf.mass * robot.drive.radius**2 / max(1, len(names))
    damping = (model.dof_M0[velocity] + share) / config.response_time
    stiffness = damping / config.integral_time
    model.actuator_gainprm[:, 0] = stiffness
    model.actuator_biasprm[:, 1], model.actuator_biasprm[:, 2] = -stiffness, -damping
    return Servos(
        np.array([joint.qposadr[0] for joint in joints], np.int64),
        velocity,
        np.full(len(names), config.integral_time),
        robot.drive.torque / stiffness,
    )
