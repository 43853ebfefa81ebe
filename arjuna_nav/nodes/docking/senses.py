"""Inputs that show the docking server where the dock is, and contact with it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import BatteryState, JointState

from arjuna_core.pose3 import Pose3, unit_quaternion
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_nav.docking.dock_types import DockSenses


class DockSensors:
    """Listens to detected_dock_pose, in the docks' frame, battery_state and joint_states."""

    def __init__(self, node: ManagedNode, frame: str) -> None:
        self._node = node
        self._frame = frame
        self._detection: Any | None = None
        self._believed: tuple[float, SE2] | None = None
        self._current: float | None = None
        self._joints: dict[str, tuple[float, float]] = {}
        node.subscribe(PoseStamped, "detected_dock_pose", self._on_detection, qos.LATEST)
        node.subscribe(BatteryState, "battery_state", self._on_battery, qos.SENSOR_SUBSCRIPTION)
        node.subscribe(JointState, "joint_states", self._on_joints, qos.SENSOR_SUBSCRIPTION)

    def forget(self) -> None:
        """Forget what was detected: another dock may be meant from now on."""
        self._detection = self._believed = None

    def _on_detection(self, message: Any) -> None:
        self._detection = message

    def _on_battery(self, message: Any) -> None:
        self._current = message.current

    def _on_joints(self, message: Any) -> None:
        joint_states = zip(message.name, message.velocity, message.effort, strict=False)
        self._joints.update({name: (velocity, effort) for name, velocity, effort in joint_states})

    def detected(self, config: Any) -> SE2 | None:
        """Return where the dock is by what was detected, None where that is too old."""
        if self._detection is not None:
            self._believe(self._detection, config)
            self._detection = None
        if self._believed is None:
            return None
        stamp, pose = self._believed
        if self._node.now - stamp > config.external_detection_timeout:
            return None
        ahead = config.external_detection_translation_x
        return pose @ SE2(ahead, config.external_detection_translation_y, 0.0)

    def _believe(self, message: Any, config: Any) -> None:
        """Filter a detection, of any frame of the robot, as a camera's that looks along z."""
        stamp, source = seconds(message.header.stamp), message.header.frame_id.lstrip("/")
        transforms = self._node.transforms
        root = transforms.rigid_root(source)  # all that moves about it is seen from above
        T = transforms.try_lookup(self._frame, root, stamp)
        T = transforms.try_lookup(self._frame, root) if T is None else T
        if T is None or self._node.now - stamp > config.external_detection_timeout:
            return
        pose = T @ _level(transforms.mount(root, source), message.pose, config)
        before = self._believed
        if before is not None and stamp - before[0] <= config.external_detection_timeout:
            pose = before[1].interpolate(pose, config.filter_coef or 1.0)
        self._believed = stamp, pose

    def senses(self, distance: float | None, joints: Sequence[str]) -> DockSenses:
        """Return the signs of contact and charging, a distance [m] or None from the dock's pose."""
        joint_states = [self._joints[name] for name in joints if name in self._joints]
        if not joint_states:
            return DockSenses(distance, current=self._current)
        speed = sum(abs(velocity) for velocity, _ in joint_states) / len(joint_states)
        effort = sum(abs(effort) for _, effort in joint_states) / len(joint_states)
        return DockSenses(distance, effort, speed, self._current)


def _level(mount: Pose3, message: Any, config: Any) -> SE2:
    """Return a detection's position and, turned as the dock type says, its heading.

    Args:
        mount: Pose of the detection's frame.

    Source: opennav_docking, SimpleChargingDock::getRefinedPose.
    """
    at, q = message.position, message.orientation
    seen = mount @ Pose3((at.x, at.y, at.z), unit_quaternion(q.w, q.x, q.y, q.z))
    turn = Pose3.from_rpy(
        (0.0, 0.0, 0.0),
        (
            config.external_detection_rotation_roll,
            config.external_detection_rotation_pitch,
            config.external_detection_rotation_yaw,
        ),
    )
    return (seen @ turn).planar()
