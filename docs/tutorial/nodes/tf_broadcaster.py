"""A transform, broadcast: a second laser 0.15 m ahead of base_link and 0.20 m above it."""

from contextlib import suppress

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from tf2_ros import TransformBroadcaster


class TFBroadcaster(Node):
    """Says twenty times a second where top_laser is."""

    def __init__(self) -> None:
        super().__init__("tf_broadcaster")
        self.broadcaster = TransformBroadcaster(self)
        self.create_timer(0.05, self.broadcast)
        self.get_logger().info("base_link -> top_laser")

    def broadcast(self) -> None:
        """Say it once more, as of now."""
        t = TransformStamped()
        t.header.stamp = self.get_clock().now().to_msg()
        t.header.frame_id = "base_link"
        t.child_frame_id = "top_laser"
        t.transform.translation.x = 0.15
        t.transform.translation.z = 0.20
        t.transform.rotation.w = 1.0
        self.broadcaster.sendTransform(t)


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(TFBroadcaster())


if __name__ == "__main__":
    main()
