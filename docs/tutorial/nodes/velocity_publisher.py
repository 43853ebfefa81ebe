"""A publisher: forward at 0.2 m/s, ten times a second, for as long as it runs."""

from contextlib import suppress

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class VelocityPublisher(Node):
    """Drives the robot forward; it stops by itself half a second after the last command."""

    def __init__(self) -> None:
        super().__init__("velocity_publisher")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_timer(0.1, self.publish)
        self.get_logger().info("publishing on /cmd_vel")

    def publish(self) -> None:
        """Send the command once more."""
        message = Twist()
        message.linear.x = 0.2
        self.publisher.publish(message)


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(VelocityPublisher())


if __name__ == "__main__":
    main()
