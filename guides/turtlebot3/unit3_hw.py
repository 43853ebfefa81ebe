"""The homework: goal points one after the other by odometry, and a stop at the last."""

import rclpy
from direct_pose import DirectPose
from geometry_msgs.msg import Twist

GOALS = [(0.6, 0.0), (0.6, 0.6), (0.0, 0.6), (0.0, 0.0)]
"""x [m], y [m] in the odometry's frame."""


def main() -> None:
    """Drive them all."""
    rclpy.init()
    node = DirectPose(*GOALS[0])
    for number, goal in enumerate(GOALS, 1):
        node.goal, node.rho = goal, float("inf")
        while node.rho > node.tolerance:
            rclpy.spin_once(node, timeout_sec=0.1)
        node.get_logger().info(f"Goal {number} of {len(GOALS)} reached")
    node.commands.publish(Twist())
    node.get_logger().info(f"Stopped, {node.rho:.2f}m from the last goal")


if __name__ == "__main__":
    main()
