"""A transform, looked up: where the laser is in the odometry's frame."""

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from tf2_ros import Buffer, TransformException, TransformListener


class TFListener(Node):
    """Looks each second; there is no transform before all frames were received."""

    def __init__(self) -> None:
        super().__init__("tf_listener")
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.create_timer(1.0, self.look)
        self.get_logger().info("looking for odom -> laser_link")

    def look(self) -> None:
        """Print where the laser is."""
        try:
            t = self.buffer.lookup_transform("odom", "laser_link", rclpy.time.Time())
        except TransformException as error:
            self.get_logger().warning(f"TF not available: {error}")
            return
        position = t.transform.translation
        self.get_logger().info(
            f"Laser at odom: x={position.x:.2f} y={position.y:.2f} z={position.z:.2f}"
        )


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(TFListener())


if __name__ == "__main__":
    main()
