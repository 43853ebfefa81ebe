"""Odometry: where the wheels say that the robot is."""

import math
from contextlib import suppress

import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class OdomReader(Node):
    """Prints pose and speed; a quaternion's yaw is an arc tangent."""

    def __init__(self) -> None:
        super().__init__("odom_reader")
        self.create_subscription(Odometry, "/odom", self.on_odometry, 10)
        self.get_logger().info("listening to /odom")

    def on_odometry(self, message: Odometry) -> None:
        """Print one."""
        position, q = message.pose.pose.position, message.pose.pose.orientation
        yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        speed = message.twist.twist
        self.get_logger().info(
            f"x={position.x:.2f} y={position.y:.2f} yaw={math.degrees(yaw):.1f} deg"
            f" vx={speed.linear.x:.2f} wz={speed.angular.z:.2f}",
            throttle_duration_sec=0.5,
        )


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(OdomReader())


if __name__ == "__main__":
    main()
