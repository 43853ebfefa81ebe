"""Motors of wheels and steering, and the rollers of mecanum and omni wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Ints, Singles
from arjuna_core.config import duration_param, fixed
from arjuna_core.geodesy import GRAVITY
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.wheels import center

Rows = Singles | Floats


def add_rollers(body: Any, robot: RobotModel, joint: str) -> None:
    """Add the freedom of a wheel's rollers to its body, where it has any, before its own joint.

    Args:
        body: The spec's body; its frame is the wheel's link's.
    """
    drive, urdf = robot.drive, robot.urdf
    if not drive.grips:
        return
    T_link_root = urdf.T_root(urdf.joints[joint].child).inverse()
    along = np.array([*drive.grips[drive.wheels.index(joint)], 0.0])
    position = T_link_root.apply(center(urdf, joint)[None])[0]
    body.add_joint(name=_name(joint), axis=T_link_root.rotation() @ along, pos=position)


def roller_addresses(model: Any, robot: RobotModel) -> Ints:
    """Return the addresses in qpos of what rollers have turned, `(R,) int64`."""
    names = robot.drive.wheels if robot.drive.grips else ()
    return np.array([model.joint(_name(name)).qposadr[0] for name in names], np.int64)


def _name(joint: str) -> str:
    return f"{joint}//rollers"


@dataclass(frozen=True)
class ServoConfig:
    """Parameters of the motors of wheels."""

    response_time: float = duration_param(
        0.01,
        "Time in which the motors take up an error of speed, were their torque unlimited.",
        minimum=0.001,
        maximum=1.0,
        read_only=True,
    )
    integral_time: float = duration_param(
        0.05,
        "Time in which what the load holds back is made up for.",
        minimum=0.02,
        maximum=10.0,
        read_only=True,
    )
    armature: float = fixed(
        0.0,
        "Rotor inertia as the wheel feels it; at least what makes the time step stable.",
        unit="kg m^2",
        minimum=0.0,
    )


@dataclass(frozen=True)
class Servos:
    """The servos of all wheels, left ones first, and of the joints that steer.

    Each array is `(W,)`, that of the steering `(S,)`.

    Attributes:
        position: Addresses of the wheels in qpos.
        velocity: Addresses of the wheels in qvel.
        stiffness: Of the wheels' motors, to the wanted angle [N m/rad].
        damping: Of the wheels' joints by their file, which motors make up for [N m s/rad].
        lead: How far the wanted angle runs ahead of the wheel's, per speed [s].
        response_time: In which wheels follow: by so much they may be late without making up [s].
        reach: How far it may run ahead until the torque is at its limit [rad].
        steering: Addresses of the steering joints in qpos.
        motors: Which of all motors turn the wheels.
        steerers: Which of them steer.
        sums: Where MuJoCo keeps the wheels' wanted angles.
    """

    position: Ints
    velocity: Ints
    stiffness: Floats
    damping: Floats
    lead: Floats
    response_time: float
    reach: Floats
    steering: Ints
    motors: slice
    steerers: slice
    sums: slice

    def push(self, model: Any, torques: Floats | None) -> None:
        """Have wheels pushed by torques [N m]; servos turn those for whom there is no number."""
        given = np.full(len(self.stiffness), np.nan) if torques is None else torques
        follows = np.isnan(given)
        model.actuator_gainprm[self.motors, 0] = follows * self.stiffness
        bias = model.actuator_biasprm[self.motors]
        bias[:, 0], bias[:, 1] = np.nan_to_num(given), follows * -self.stiffness
        bias[:, 2] = np.where(follows, -self.stiffness * self.lead, -self.damping)

    def at(self, data: Any) -> ServosAt:
        """Return them at a model's data."""
        return ServosAt(self, data)


class ServosAt:
    """Servos at a model's data, whose arrays are looked up once and not every tick."""

    def __init__(self, servos: Servos, data: Any) -> None:
        self._servos, self._qpos = servos, data.qpos
        self._wanted, self._setpoint = data.act[servos.sums], data.ctrl[servos.motors]
        self._steered = data.ctrl[servos.steerers]
        self._state = data.qpos, data.qvel, self._wanted, self._setpoint
        self._limits = servos.position, servos.velocity, servos.lead, servos.reach

    def turn(self, speeds: Floats, angles: Floats) -> None:
        """Set the speeds of the wheels [rad/s] and the angles of the steering [rad].

        The wanted angle runs ahead by the wanted speed, and by what the load holds back as far as
        the torque goes: a wheel that was held does not make up for it.
        """
        _turn(*self._state, speeds, *self._limits, self._servos.response_time)
        if len(angles):
            self._steered[:] = angles

    def rest(self) -> None:
        """Let the wheels, which stand, stay where they are."""
        self._wanted[:] = self._qpos[self._servos.position]
        self._setpoint[:] = 0.0
        self._steered[:] = self._qpos[self._servos.steering]


@njit(cache=True)
def _turn(
    qpos: Floats,
    qvel: Floats,
    wanted: Floats,
    setpoint: Floats,
    speeds: Floats,
    position: Ints,
    velocity: Ints,
    lead: Floats,
    reach: Floats,
    response_time: float,
) -> None:
    """Set the wheels' wanted angles and speeds, in place (`bench sim`: 9 us of a tick in NumPy)."""
    for i in range(len(speeds)):
        angle, turning = qpos[position[i]], qvel[velocity[i]]
        room = max(reach[i] - lead[i] * abs(speeds[i] - turning), 0.0)
        behind = wanted[i] - lead[i] * setpoint[i] - angle
        behind -= response_time * (speeds[i] - setpoint[i])
        wanted[i] = angle + min(max(behind, -room), room) + lead[i] * speeds[i]
        setpoint[i] = speeds[i]


@njit(cache=True)
def turn_each(
    qpos: Rows,
    qvel: Rows,
    wanted: Rows,
    setpoint: Rows,
    speeds: Floats,
    position: Ints,
    velocity: Ints,
    lead: Floats,
    reach: Floats,
    response_time: float,
) -> None:
    """Do as `ServosAt.turn` for robots that have a row each."""
    limits = position, velocity, lead, reach, response_time
    for i in range(len(speeds)):
        _turn(qpos[i], qvel[i], wanted[i], setpoint[i], speeds[i], *limits)


def armature(robot: RobotModel, config: ServoConfig, timestep: float) -> float:
    """Return the rotor inertia of a wheel's motor, as the wheel feels it [kg m^2].

    A motor at its greatest torque pushes the same for a whole time step. A wheel that slips must be
    heavy enough not to be pushed from one side of its speed to as far beyond it.
    """
    return max(config.armature, _share(robot) * timestep / (2.0 * config.response_time))


def _share(robot: RobotModel) -> float:
    """Return what of the robot's inertia a wheel moves [kg m^2]."""
    return robot.urdf.mass * robot.drive.radius**2 / max(1, len(robot.drive.wheels))


def add_servo(spec: Any, joint: str, torque: float | None = None) -> None:
    """Add a motor to a joint: of a speed, within a torque [N m]; without one of a position."""
    motor = spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    motor.gaintype, motor.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    if torque is not None:
        motor.dyntype = mujoco.mjtDyn.mjDYN_INTEGRATOR
        motor.forcelimited, motor.forcerange = True, [-torque, torque]


def tune_servos(model: Any, robot: RobotModel, config: ServoConfig) -> Servos:
    """Set the gains of a compiled model's motors by what they move.

    A wheel moves itself and its share of the robot. Its motor is a proportional-integral control of
    speed, written as a damped spring to the angle that the wanted speed sums up to: it holds a
    parked wheel. The damping is implicit in MuJoCo's step, so that no inertia is too light for it.
    """
    names = robot.drive.wheels
    joints = [model.joint(name) for name in names]
    velocity = np.array([joint.dofadr[0] for joint in joints], np.int64)
    damping = (model.dof_M0[velocity] + _share(robot)) / config.response_time
    stiffness = damping / config.integral_time
    motors, sums = actuators(model, names)
    steerers, _ = actuators(model, robot.drive.steering)
    model.actuator_gainprm[motors, 0] = stiffness
    model.actuator_biasprm[motors, 1], model.actuator_biasprm[motors, 2] = -stiffness, -damping
    steering = [model.joint(name) for name in robot.drive.steering]
    moved = model.dof_M0[[joint.dofadr[0] for joint in steering]]
    times = _steering_times(robot, moved)
    moved = moved + robot.urdf.mass * robot.drive.radius**2 / max(1, len(steering))
    model.actuator_gainprm[steerers, 0] = moved / times**2
    model.actuator_biasprm[steerers, 1] = -moved / times**2
    model.actuator_biasprm[steerers, 2] = -2.0 * moved / times
    return Servos(
        np.array([joint.qposadr[0] for joint in joints], np.int64),
        velocity,
        stiffness,
        np.array([robot.urdf.joints[name].damping for name in names]),
        np.full(len(names), config.integral_time),
        config.response_time,
        robot.drive.torque / stiffness,
        np.array([joint.qposadr[0] for joint in steering], np.int64),
        motors,
        steerers,
        sums,
    )


def _steering_times(robot: RobotModel, moved: Floats) -> Floats:
    """Return the times in which joints reach their setpoints, critically damped [s].

    Steering pushes back on the robot: heavy wheels are turned no faster than the ground holds the
    others, with a tenth of the robot's weight at the distance of its wheels, for 1 rad.

    Args:
        moved: Inertia of what each turns [kg m^2].
    """
    positions = np.array([center(robot.urdf, name)[:2] for name in robot.drive.rolling])
    reach = float(np.linalg.norm(np.ptp(positions, axis=0))) if len(positions) else 0.0
    held = 0.1 * robot.urdf.mass * GRAVITY * max(reach, robot.drive.radius)
    return np.maximum(0.018, np.sqrt(moved * len(moved) / held))


def actuators(model: Any, joints: Sequence[str]) -> tuple[slice, slice]:
    """Return which of all motors, and of their sums, are those of joints added in a row."""
    first = int(model.actuator(joints[0]).id) if joints else 0
    start = int(model.actuator_actadr[first]) if joints else 0
    return slice(first, first + len(joints)), slice(start, start + len(joints))
