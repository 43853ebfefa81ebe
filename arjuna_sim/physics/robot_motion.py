"""A robot on the stage: where it stands, how its joints are, and what its wheels are told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3, rpy_of
from arjuna_core.se2 import SE2
from arjuna_sim.physics.scene import RobotInScene
from arjuna_sim.physics.stage import Stage


@dataclass(frozen=True)
class JointStates:
    """Positions [rad or m] and velocities of the moving joints, in the URDF's order."""

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """Where the robot really is: what no robot knows.

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


class RobotMotion:
    """Reads and moves a robot of a stage, whatever model the stage holds at the time.

    Args:
        stage: The stage.
        robot: The robot's name.
        joints: Names of the robot's moving joints, in the URDF's order.
    """

    def __init__(self, stage: Stage, robot: str, joints: tuple[str, ...]) -> None:
        self._stage = stage
        self._robot = robot
        self._joints = joints

    @property
    def _found(self) -> RobotInScene:
        return self._stage.scene.robots[self._robot]

    @property
    def _data(self) -> Any:
        return self._stage.data

    def put(self, place: Pose3) -> None:
        """Put the robot's root somewhere, with all joints at rest."""
        found = self._found
        at, _ = found.base
        self._data.qpos[at : at + 3] = place.position
        self._data.qpos[at + 3 : at + 7] = place.quaternion
        self._data.qvel[found.rates] = 0.0
        self._data.qacc_warmstart[found.rates] = 0.0
        found.servos.rest(self._data)
        self._stage.settle()

    def turn_wheels(self, speeds: NDArray[np.float64], angles: NDArray[np.float64]) -> None:
        """Tell the wheels' joints how fast to turn [rad/s], and the steering where to stand [rad].

        Args:
            speeds: In the order of `DriveSettings.wheels`, `(W,) float64`.
            angles: In the order of `DriveSettings.steering`, `(S,) float64`.
        """
        self._found.servos.turn(self._data, speeds, angles)

    def wheel_angles(self) -> NDArray[np.float64]:
        """Return how far the wheels' joints have turned, `(W,) float64` [rad]."""
        angles: NDArray[np.float64] = self._data.qpos[self._found.servos.position]
        return angles

    def steering_angles(self) -> NDArray[np.float64]:
        """Return where the steering joints stand, `(S,) float64` [rad]."""
        angles: NDArray[np.float64] = self._data.qpos[self._found.servos.steering]
        return angles

    def joint_states(self) -> JointStates:
        """Return the moving joints' positions and velocities."""
        found, data = self._found, self._data
        positions, velocities = data.qpos[found.joint_position], data.qvel[found.joint_velocity]
        return JointStates(self._joints, positions, velocities)

    def truth(self) -> Truth:
        """Return where the robot is and how it moves."""
        at, rate = self._found.base
        x, y, z, qw, qx, qy, qz = self._data.qpos[at : at + 7].tolist()
        vx, vy, vz, _, _, w = self._data.qvel[rate : rate + 6].tolist()
        roll, pitch, yaw = rpy_of(qw, qx, qy, qz)
        ahead = 1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz), 2 * (qx * qz - qw * qy)
        left = 2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qw * qx)
        v = vx * ahead[0] + vy * ahead[1] + vz * ahead[2]
        side = vx * left[0] + vy * left[1] + vz * left[2]
        return Truth(SE2(x, y, yaw), v, w, z, roll, pitch, side)
