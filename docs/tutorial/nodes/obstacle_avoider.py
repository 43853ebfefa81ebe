"""An emergency stop: slower from 0.70 m before an obstacle, no closer than 0.35 m.

Commands of /cmd_vel_raw are passed to /cmd_vel: a node that only publishes zeros beside the
driver's commands would lose to them half of the time.
"""

import math
from contextlib import suppress

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

STOP, SLOW = 0.35, 0.70
"""Distances from the laser at which to stop, and to begin to go slower [m]."""
ARC = math.radians(30.0)
"""To either side of straight ahead."""


def nearest_ahead(scan: LaserScan) -> float:
    """Return the nearest distance within the arc, inf where nothing is [m]."""
    near = math.inf
    for i, distance in enumerate(scan.ranges):
        bearing = scan.angle_min + i * scan.angle_increment
        bearing = math.atan2(math.sin(bearing), math.cos(bearing))
        if abs(bearing) <= ARC and scan.range_min < distance < scan.range_max:
            near = min(near, distance)
    return near


def limited(forward: float, near: float) -> float:
    """Return how fast may be driven with something so near [m/s]; backward always."""
    if forward <= 0.0 or near >= SLOW:
        return forward
    return forward * max(0.0, (near - STOP) / (SLOW - STOP))


class ObstacleAvoider(Node):
    """Passes commands as fast as the space ahead allows; says on /emergency_stop when it stops."""

    def __init__(self) -> None:
        super().__init__("obstacle_avoider")
        self.near, self.stopped = math.inf, False
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_subscription(Twist, "/cmd_vel_raw", self.on_command, 10)
        self.commands = self.create_publisher(Twist, "/cmd_vel", 10)
        self.stops = self.create_publisher(Bool, "/emergency_stop", 10)
        self.get_logger().info("watching /scan, commands on /cmd_vel_raw")

    def on_scan(self, scan: LaserScan) -> None:
        """Look ahead; say when that changes whether the robot may drive."""
        self.near = nearest_ahead(scan)
        if (self.near < STOP + 0.02) != self.stopped:
            self.stopped = not self.stopped
            text = (
                f"ESTOP! Obstacle at {self.near:.2f}m" if self.stopped else "Path clear, resuming."
            )
            self.get_logger().warning(text)
            self.stops.publish(Bool(data=self.stopped))

    def on_command(self, command: Twist) -> None:
        """Hand a command on."""
        command.linear.x = limited(command.linear.x, self.near)
        self.commands.publish(command)


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(ObstacleAvoider())


if __name__ == "__main__":
    main()
