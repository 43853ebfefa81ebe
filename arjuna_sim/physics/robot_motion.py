"""A robot on the stage: its pose, its joints, and the setpoints of its wheels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.pose3 import Pose3, rpy_of
from arjuna_core.se2 import SE2
from arjuna_sim.devices.driving.joints import JointCommands
from arjuna_sim.physics.stage import Stage

_rpy_of = njit(cache=True)(rpy_of)


class JointStates(NamedTuple):
    """Positions [rad or m] and velocities of the moving joints, in the URDF's order."""

    names: tuple[str, ...]
    positions: Floats
    velocities: Floats

    def of(self, joints: Sequence[str]) -> tuple[Floats, Floats]:
        """Return positions and velocities of some joints; those that do not move stand at 0."""
        at = np.array([self.names.index(n) if n in self.names else -1 for n in joints], np.int64)
        padded = [np.append(values, 0.0) for values in (self.positions, self.velocities)]
        return padded[0][at], padded[1][at]


class Truth(NamedTuple):
    """The true pose and motion of the robot, which it cannot know.

    Attributes:
        pose: Of the robot's root in the world, seen from above.
        v: Speed along the robot's x axis [m/s].
        w: Turn rate [rad/s].
        z: Height of the robot's root [m].
        roll: [rad].
        pitch: [rad].
        side: Speed along the robot's y axis [m/s].
    """

    pose: SE2
    v: float
    w: float
    z: float
    roll: float
    pitch: float
    side: float = 0.0

    @property
    def pose3(self) -> Pose3:
        """The pose of the robot's root in the world."""
        x, y, yaw = self.pose.x, self.pose.y, self.pose.theta
        return Pose3.from_rpy((x, y, self.z), (self.roll, self.pitch, yaw))


class RobotMotion:
    """Reads and moves a robot of a stage, whatever model the stage holds at the time."""

    def __init__(self, stage: Stage, robot: str, joints: tuple[str, ...]) -> None:
        self._stage = stage
        self._robot = robot
        self._joints = joints
        self.rebind()

    def rebind(self) -> None:
        """Continue with the stage's new MuJoCo model."""
        self._found, self._data = self._stage.scene.robots[self._robot], self._stage.data
        self._qpos, self._qvel = self._data.qpos, self._data.qvel
        self._servos = self._found.servos.at(self._data)
        self._is_pushed = False

    def put(self, pose: Pose3) -> None:
        """Put the robot's root somewhere, with all joints at rest."""
        found = self._found
        at, _ = found.base
        self._data.qpos[at : at + 3] = pose.position
        self._data.qpos[at + 3 : at + 7] = pose.quaternion
        self._data.qvel[found.rates] = 0.0
        self._data.qacc_warmstart[found.rates] = 0.0
        self._servos.rest()
        self._stage.settle()

    def turn_wheels(self, speeds: Floats, angles: Floats, torques: Floats | None = None) -> None:
        """Set the speeds of the wheels' joints [rad/s] and the angles of the steering [rad].

        Args:
            speeds: In the order of `DriveSettings.wheels`, `(W,) float64`.
            angles: In the order of `DriveSettings.steering`, `(S,) float64`.
            torques: Of wheels that are pushed, whatever their speed; of others no number, `(W,)`.
        """
        self._servos.turn(speeds, angles)
        if torques is not None or self._is_pushed:
            self._found.servos.push(self._stage.scene.model, torques)
        self._is_pushed = torques is not None

    def drive_joints(self, commands: JointCommands) -> None:
        """Set what the driven joints do until the next call."""
        model = self._stage.scene.model
        self._found.joint_servos.drive(model, self._data, *commands)

    def driven_joints(self) -> Floats:
        """Return the positions of the driven joints, `(N,) float64` [rad or m]."""
        positions: Floats = self._qpos[self._found.joint_servos.position]
        return positions

    def set_joints(self, positions: Floats) -> None:
        """Put the driven joints somewhere, at rest [rad or m]."""
        servos = self._found.joint_servos
        self._qpos[servos.position], self._qvel[servos.velocity] = positions, 0.0
        self._data.act[servos.sums] = positions

    def wheel_angles(self) -> Floats:
        """Return how far the wheels' joints have turned, `(W,) float64` [rad]."""
        angles: Floats = self._qpos[self._found.servos.position]
        return angles

    def steering_angles(self) -> Floats:
        """Return where the steering joints stand, `(S,) float64` [rad]."""
        angles: Floats = self._qpos[self._found.servos.steering]
        return angles

    def joint_states(self) -> JointStates:
        """Return the moving joints' positions and velocities."""
        positions = self._qpos[self._found.joint_position]
        return JointStates(self._joints, positions, self._qvel[self._found.joint_velocity])

    def truth(self) -> Truth:
        """Return where the robot is and how it moves."""
        x, y, yaw, *rest = _truth(self._qpos, self._qvel, *self._found.base)
        return Truth(SE2(x, y, yaw), *rest)


@njit(cache=True)
def _truth(
    qpos: Floats, qvel: Floats, at: int, rate: int
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return x, y and yaw, and the other values of a `Truth` (`bench sim`: 3 us in Python)."""
    qw, qx, qy, qz = qpos[at + 3], qpos[at + 4], qpos[at + 5], qpos[at + 6]
    vx, vy, vz = qvel[rate], qvel[rate + 1], qvel[rate + 2]
    roll, pitch, yaw = _rpy_of(qw, qx, qy, qz)
    ahead = 1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy)
    left = 2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx)
    v = vx * ahead[0] + vy * ahead[1] + vz * ahead[2]
    side = vx * left[0] + vy * left[1] + vz * left[2]
    return qpos[at], qpos[at + 1], yaw, v, qvel[rate + 5], qpos[at + 2], roll, pitch, side


@njit(cache=True)
def truth_of_each(qpos: Floats, qvel: Floats, at: int, rate: int) -> Floats:
    """Return x, y, yaw and the other values of a `Truth` for robots of a row each, `(N, 9)`."""
    found = np.empty((len(qpos), 9))
    for i in range(len(qpos)):
        found[i] = _truth(qpos[i], qvel[i], at, rate)
    return found
