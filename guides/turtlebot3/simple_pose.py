"""The simple goal mover: turns until it faces the goal, then drives straight; `simple_pose.py X Y`.

It turns one way only and drives at one speed, so it swings about the line and stops early.
"""

import math
import sys

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node


class SimplePose(Node):
    """Drives to a point of the odometry's frame.

    Args:
        x: [m].
        y: [m].

    Attributes:
        rho: How far it is yet [m].
        tolerance: How near is near enough [m].
    """

    tolerance = 0.2

    def __init__(self, x: float, y: float) -> None:
        super().__init__("simple_pose")
        self.goal, self.rho = (x, y), math.inf
        self.commands = self.create_publisher(Twist, "/cmd_vel", 1)
        self.create_subscription(Odometry, "/odom", self.on_odometry, 10)
        self.get_logger().info(f"to ({x:.2f}, {y:.2f})")

    def on_odometry(self, message: Odometry) -> None:
        """Take the next step."""
        position, q = message.pose.pose.position, message.pose.pose.orientation
        theta = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        dx, dy = self.goal[0] - position.x, self.goal[1] - position.y
        self.rho = math.hypot(dx, dy)
        self.get_logger().info(f"Distance to goal= {self.rho:.2f}m", throttle_duration_sec=1.0)
        if self.rho > self.tolerance:
            self.commands.publish(self.command(math.atan2(dy, dx) - theta))

    def command(self, alpha: float) -> Twist:
        """Return what to do with the goal at a bearing [rad]."""
        twist = Twist()
        if abs(alpha) > 0.1:
            twist.angular.z = 0.3
        else:
            twist.linear.x = 0.22
        return twist


def main(kind: type[SimplePose] = SimplePose) -> None:
    """Drive there and stop."""
    x, y = (float(word) for word in sys.argv[1:3])
    rclpy.init()
    node = kind(x, y)
    while node.rho > node.tolerance:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.commands.publish(Twist())
    node.get_logger().info(f"Final position error: {node.rho:.2f}m")


if __name__ == "__main__":
    main()
