"""A stand-in for a real robot's drivers: `python -m tests.helpers.real_robot SEED`.

It lives on the system's clock, its messages come up to 50 ms late, and of its scans 2 % are lost.
Topics and frames are not the usual ones. A line with its true pose is printed twice a second.
"""

from __future__ import annotations

import heapq
import math
import sys
import time
from itertools import count
from typing import Any

import numpy as np
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.raycast import cast
from arjuna_core.ros import qos
from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import header, pose_msg, scan_msg, transform_msg
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from bringup.terminal import show

BASE, LASER, ODOM = "chassis", "laser_frame", "odom_combined"
_RESOLUTION, _WIDTH, _HEIGHT = 0.05, 8.0, 6.0  # [m] the room, the robot starts in its middle
_TICK, _SWEEP, _REPORT = 0.02, 0.1, 0.5  # [s]
_JITTER, _LOST = 0.05, 0.02  # [s], share
_SLIP = 0.98  # of what the wheels report, the robot does
_BEARINGS = np.linspace(-math.pi, math.pi, 360, endpoint=False)

OPTIONS = (
    *("--scan-topic", "laser", "--odom-topic", "wheels/odom", "--cmd-vel-topic", "base/cmd_vel"),
    *("--base-frame", "chassis", "--odom-frame", "odom_combined"),
)
"""The options that `robot` needs for it."""
_MARGIN = 0.5  # of a free pose to what stands there [m]


def room() -> NDArray[np.bool_]:
    """Return the walls and two boxes, `(height, width) bool`."""
    blocked = np.zeros((round(_HEIGHT / _RESOLUTION), round(_WIDTH / _RESOLUTION)), bool)
    blocked[[0, 1, -2, -1]], blocked[:, [0, 1, -2, -1]] = True, True
    blocked[80:100, 30:40], blocked[15:30, 110:140] = True, True
    return blocked


def free_poses(rng: np.random.Generator, count: int) -> list[SE2]:
    """Return poses by chance at which the robot may stand, in its map's coordinates."""
    poses, blocked, cells = list[SE2](), room(), round(_MARGIN / _RESOLUTION)
    while len(poses) < count:
        x, y = rng.uniform((0.0, 0.0), (_WIDTH, _HEIGHT))
        i, j = int(y / _RESOLUTION), int(x / _RESOLUTION)
        around = blocked[max(i - cells, 0) : i + cells + 1, max(j - cells, 0) : j + cells + 1]
        if not around.any():
            theta = rng.uniform(-math.pi, math.pi)
            poses.append(SE2(x - _WIDTH / 2, y - _HEIGHT / 2, theta))
    return poses


class Drivers:
    """The base and the lidar."""

    def __init__(self, seed: int) -> None:
        self._rng, self._room = np.random.default_rng(seed), room()
        self.pose, self._odometry, self._command = IDENTITY, IDENTITY, (0.0, 0.0)
        self._late: list[tuple[float, int, Any, Any]] = []
        self._numbers, self._last = count(), dict[Any, float]()
        context = new_context()
        self.node = Node("drivers", context=context)
        self._executor = EventsExecutor(context=context)
        self._executor.add_node(self.node)
        self._scans = self.node.create_publisher(LaserScan, "laser", qos.SENSOR_PUBLISHER)
        self._odometries = self.node.create_publisher(Odometry, "wheels/odom", qos.DEFAULT)
        self._transforms = self.node.create_publisher(TFMessage, "/tf", qos.TF)
        self._static = self.node.create_publisher(TFMessage, "/tf_static", qos.TF_STATIC)
        self.node.create_subscription(Twist, "base/cmd_vel", self._on_command, qos.DEFAULT)
        self._static.publish(TFMessage(transforms=[self._mount()]))

    def _mount(self) -> TransformStamped:
        return transform_msg(SE2(0.1, 0.0, 0.0), BASE, LASER, self._now())

    def _now(self) -> float:
        return float(self.node.get_clock().now().nanoseconds) / 1e9

    def _on_command(self, message: Any) -> None:
        self._command = (message.linear.x, message.angular.z)

    def run(self) -> None:
        """Drive, sense and report until killed."""
        start = time.monotonic()
        for tick in count():
            while (left := start + tick * _TICK - time.monotonic()) > 0.0:
                self._executor.spin_once(timeout_sec=left)
            self._drive()
            if tick % round(_SWEEP / _TICK) == 0 and self._rng.random() >= _LOST:
                self._send(self._scans, self._scan())
            if tick % round(_REPORT / _TICK) == 0:
                show(f"at {self.pose.x:.3f} {self.pose.y:.3f} {self.pose.theta:.3f}")
            while self._late and self._late[0][0] <= time.monotonic():
                _, _, publisher, message = heapq.heappop(self._late)
                publisher.publish(message)

    def _drive(self) -> None:
        v, w = self._command
        self.pose = self.pose @ SE2(v * _TICK * _SLIP, 0.0, w * _TICK * _SLIP)
        self._odometry = self._odometry @ SE2(v * _TICK, 0.0, w * _TICK)
        now = self._now()
        message = Odometry(header=header(ODOM, now), child_frame_id=BASE)
        message.pose.pose = pose_msg(self._odometry)
        message.twist.twist.linear.x, message.twist.twist.angular.z = v, w
        self._send(self._odometries, message)
        T = transform_msg(self._odometry, ODOM, BASE, now)
        self._send(self._transforms, TFMessage(transforms=[T]))

    def _scan(self) -> LaserScan:
        laser = self.pose @ SE2(0.1, 0.0, 0.0)
        x, y = laser.x + _WIDTH / 2, laser.y + _HEIGHT / 2
        ranges = cast(self._room, _RESOLUTION, x, y, _BEARINGS + laser.theta, 12.0)
        ranges = ranges + self._rng.normal(0.0, 0.01, len(ranges))
        step = float(_BEARINGS[1] - _BEARINGS[0])
        scan = Scan(ranges, float(_BEARINGS[0]), step, 0.1, 12.0, stamp=self._now())
        return scan_msg(scan, LASER, _SWEEP)

    def _send(self, publisher: Any, message: Any) -> None:
        """Hold a message back, behind those of the same topic."""
        due = time.monotonic() + self._rng.uniform(0.0, _JITTER)
        due = self._last[publisher] = max(due, self._last.get(publisher, 0.0))
        heapq.heappush(self._late, (due, next(self._numbers), publisher, message))


if __name__ == "__main__":
    Drivers(int(sys.argv[1])).run()
