"""A node with a timer: the smallest program that lives in the ROS graph."""

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node


class MinimalNode(Node):
    """Says something each second."""

    def __init__(self) -> None:
        super().__init__("minimal_node")
        self.get_logger().info("Node is alive!")
        self.create_timer(1.0, self.tick)

    def tick(self) -> None:
        """Say so."""
        self.get_logger().info("Tick!")


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(MinimalNode())


if __name__ == "__main__":
    main()
