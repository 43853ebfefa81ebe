"""An action's client: a square of goals, one after the other, with feedback."""

import math
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.node import Node

GOALS = [(2.0, 0.0, 0.0), (2.0, 2.0, 90.0), (0.0, 2.0, 180.0), (0.0, 0.0, 0.0)]
"""x [m], y [m] and heading [deg] in the map."""


class GoalSender(Node):
    """Sends the next goal when the last has ended."""

    def __init__(self) -> None:
        super().__init__("goal_sender")
        self.client = ActionClient(self, NavigateToPose, "navigate_to_pose")
        self.number = 0
        self.reported = math.inf
        self.done = False
        self.get_logger().info("waiting for navigate_to_pose")
        self.client.wait_for_server()
        self.send_next()

    def send_next(self) -> None:
        """Send the next goal, or be done."""
        if self.number == len(GOALS):
            self.get_logger().info("All goals completed! Tour done.")
            self.done = True
            return
        x, y, heading = GOALS[self.number]
        self.number += 1
        self.get_logger().info(f"Sending goal {self.number}: ({x}, {y})")
        pose = PoseStamped()
        pose.header.frame_id = "map"
        pose.pose.position.x, pose.pose.position.y = x, y
        pose.pose.orientation.z = math.sin(math.radians(heading) / 2.0)
        pose.pose.orientation.w = math.cos(math.radians(heading) / 2.0)
        sent = self.client.send_goal_async(NavigateToPose.Goal(pose=pose), self.on_feedback)
        sent.add_done_callback(self.on_answer)

    def on_feedback(self, message: Any) -> None:
        """Say so each half metre."""
        remaining = message.feedback.distance_remaining
        if abs(self.reported - remaining) > 0.5:
            self.reported = remaining
            self.get_logger().info(f"  Distance remaining: {remaining:.2f}m")

    def on_answer(self, future: Any) -> None:
        """Wait for the result of a goal that was taken."""
        handle = future.result()
        if not handle.accepted:
            self.get_logger().error("Goal rejected!")
            self.done = True
            return
        handle.get_result_async().add_done_callback(self.on_result)

    def on_result(self, future: Any) -> None:
        """Send the next goal, however this one ended."""
        reached = future.result().status == GoalStatus.STATUS_SUCCEEDED
        text = "reached!" if reached else f"failed: {future.result().result.error_msg}"
        self.get_logger().info(f"Goal {self.number} {text}")
        self.send_next()


def main() -> None:
    """Run until the tour is done."""
    rclpy.init()
    node = GoalSender()
    while not node.done:
        rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == "__main__":
    main()
