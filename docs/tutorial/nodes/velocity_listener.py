"""A subscriber: prints what somebody commands."""

from contextlib import suppress

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class VelocityListener(Node):
    """Listens to /cmd_vel, as the robot does."""

    def __init__(self) -> None:
        super().__init__("velocity_listener")
        self.create_subscription(Twist, "/cmd_vel", self.on_command, 10)
        self.get_logger().info("listening to /cmd_vel")

    def on_command(self, message: Twist) -> None:
        """Print a command."""
        self.get_logger().info(
            f"linear.x={message.linear.x:.2f}  angular.z={message.angular.z:.2f}"
        )


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(VelocityListener())


if __name__ == "__main__":
    main()
