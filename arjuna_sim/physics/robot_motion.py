"""The robot on the stage: where it stands, how its joints are, and what its wheels are told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.physics.scene import Scene
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
    """

    pose: SE2
    v: float
    w: float
    z: float
    roll: float
    pitch: float


class RobotMotion:
    """Reads and moves the robot of a stage, whatever model the stage holds at the time.

    Args:
        stage: The stage.
        joints: Names of the robot's moving joints, in the URDF's order.
    """

    def __init__(self, stage: Stage, joints: tuple[str, ...]) -> None:
        self._stage = stage
        self._joints = joints

    @property
    def _scene(self) -> Scene:
        return self._stage.scene

    @property
    def _data(self) -> Any:
        return self._stage.data

    def put(self, place: Pose3) -> None:
        """Put the robot's root somewhere, with all joints at rest."""
        at, _ = self._scene.base
        self._data.qpos[at : at + 3] = place.position
        self._data.qpos[at + 3 : at + 7] = place.quaternion
        self._data.qvel[: self._scene.rates] = 0.0
        self._data.qacc_warmstart[: self._scene.rates] = 0.0
        self._scene.servos.rest(self._data)
        self.refresh()

    def turn_wheels(self, left: float, right: float) -> None:
        """Tell the left and the right wheels how fast to turn forward [rad/s]."""
        scene = self._scene
        speeds = np.concatenate((left * scene.left_sign, right * scene.right_sign))
        scene.servos.turn(self._data, speeds)

    def refresh(self) -> None:
        """Bring places and velocities up to the joints' state."""
        mujoco.mj_kinematics(self._scene.model, self._data)
        mujoco.mj_comPos(self._scene.model, self._data)
        mujoco.mj_comVel(self._scene.model, self._data)

    def wheel_angles(self) -> tuple[float, float]:
        """Return how far the left and the right wheels have turned forward, in the mean [rad]."""
        scene, angles = self._scene, self._data.qpos
        return (
            float(angles[scene.left] @ scene.left_sign) / max(1, len(scene.left)),
            float(angles[scene.right] @ scene.right_sign) / max(1, len(scene.right)),
        )

    def joint_states(self) -> JointStates:
        """Return the moving joints' positions and velocities."""
        scene, data = self._scene, self._data
        positions, velocities = data.qpos[scene.joint_position], data.qvel[scene.joint_velocity]
        return JointStates(self._joints, positions, velocities)

    def truth(self) -> Truth:
        """Return where the robot is and how it moves."""
        at, rate = self._scene.base
        x, y, z, *quaternion = self._data.qpos[at : at + 7].tolist()
        pose = Pose3((x, y, z), (quaternion[0], quaternion[1], quaternion[2], quaternion[3]))
        forward = pose.rotation()[:, 0]
        roll, pitch, yaw = pose.rpy()
        v = float(forward @ self._data.qvel[rate : rate + 3])
        return Truth(SE2(x, y, yaw), v, float(self._data.qvel[rate + 5]), z, roll, pitch)
