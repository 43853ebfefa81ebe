"""The robot's posture as its IMU's messages tell it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from sensor_msgs.msg import Imu

from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_nav.safety.posture import Posture

_PERIOD = 0.1  # [s] from one reading to the next: an IMU sends a hundred and more a second


class PostureWatch:
    """Listens to the IMU of a node's robot, in its `configure`.

    The node has the parameters of `PostureConfig` and a `robot_base_frame`. A robot that lies on
    its side from the start is taken to stand, with an IMU that is mounted otherwise than the frames
    say: many are.
    """

    def __init__(self, node: ManagedNode) -> None:
        self._node, self._posture, self._stood = node, Posture(), False
        if node.config.imu_topic:
            node.subscribe(Imu, node.config.imu_topic, self._on_imu, qos.SENSOR_SUBSCRIPTION)

    def problem(self) -> str:
        """Return how far the robot has overturned; empty where it has not, or no IMU says it."""
        config, tilt = self._node.config, self._posture.tilt(self._node.now)
        if tilt is None:
            return ""
        stood, self._stood = self._stood, True
        if not 0.0 < config.overturned_tilt <= tilt:
            return ""
        angle = f"'{config.imu_topic}' feels it tilted by {math.degrees(tilt):.0f} degrees"
        if stood:
            return f"the robot has overturned: {angle}; set it on its wheels"
        self._posture.take_as_upright()
        text = f"{angle} from the start: taken for upright, the IMU's frame is mounted otherwise"
        self._node.get_logger().warning(text)
        return ""

    def _on_imu(self, message: Any) -> None:
        if 0.0 <= self._node.now - self._posture.felt_at < _PERIOD:
            return
        felt, frame = message.linear_acceleration, message.header.frame_id.lstrip("/")
        try:
            mount = self._node.transforms.mount(self._node.config.robot_base_frame, frame)
        except TransformError:
            return  # how it is mounted is not known yet
        force = mount.rotation() @ np.array([felt.x, felt.y, felt.z])
        self._posture.feel(force, self._node.now)
