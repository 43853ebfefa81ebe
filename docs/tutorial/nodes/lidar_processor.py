"""Quality of service and the LaserScan: what is ahead, and what is nearest."""

import math
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan

# What a sensor sends: no scan is sent twice, and who comes late gets no old one.
SENSOR = QoSProfile(
    reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE, depth=10
)


class LidarProcessor(Node):
    """Says how far it is ahead; the bearing counts, not the beam's number."""

    def __init__(self) -> None:
        super().__init__("lidar_processor")
        self.create_subscription(LaserScan, "/scan", self.on_scan, SENSOR)
        self.get_logger().info("listening to /scan")

    def on_scan(self, scan: LaserScan) -> None:
        """Print the two distances; beams that hit nothing are inf."""
        seen = [
            (distance, scan.angle_min + i * scan.angle_increment)
            for i, distance in enumerate(scan.ranges)
            if scan.range_min < distance < scan.range_max
        ]
        if not seen:
            return
        closest = min(distance for distance, _ in seen)
        front = min((d for d, bearing in seen if math.cos(bearing) > 0.99), default=math.inf)
        self.get_logger().info(f"Front: {front:.2f}m  Closest: {closest:.2f}m")
        if front < 0.5:
            self.get_logger().warning("Obstacle ahead!")


def main() -> None:
    """Run until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(LidarProcessor())


if __name__ == "__main__":
    main()
