"""Goals sent as any client would send them, by plain rclpy action clients."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from nav2_msgs.action import NavigateToPose, Spin
from rclpy.action import ActionClient

from arjuna_core.ros.convert import duration_msg, pose_stamped
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep

_ANSWER_TIMEOUT = 5.0


class Goals:
    """Sends goals to a lock-step robot and steps it until they end.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: LockStep) -> None:
        self._robot = robot
        self._navigate = ActionClient(robot.client, NavigateToPose, "navigate_to_pose")
        self._spin = ActionClient(robot.client, Spin, "spin")

    def navigate(self, goal: SE2, timeout: float) -> bool:
        """Drive to a pose in the map frame; tell whether it succeeded in time [s]."""
        request = NavigateToPose.Goal(pose=pose_stamped(goal, "map", self._robot.now))
        return self._run(self._navigate, request, timeout)

    def spin(self, angle: float, timeout: float) -> bool:
        """Turn on the spot by an angle [rad]; tell whether it succeeded in time [s]."""
        request = Spin.Goal(target_yaw=angle, time_allowance=duration_msg(timeout))
        return self._run(self._spin, request, timeout + _ANSWER_TIMEOUT)

    def _run(self, client: Any, request: Any, timeout: float) -> bool:
        robot = self._robot
        robot.run_until(client.server_is_ready, _ANSWER_TIMEOUT, "the action server")
        sent = client.send_goal_async(request)
        robot.run_until(sent.done, _ANSWER_TIMEOUT, "an answer to the goal")
        handle = sent.result()
        if not handle.accepted:
            return False
        result = handle.get_result_async()
        if not robot.run_until(result.done, timeout, required=False):
            cancelled = handle.cancel_goal_async()
            robot.run_until(cancelled.done, _ANSWER_TIMEOUT, "an answer to the cancellation")
            return False
        return bool(result.result().status == GoalStatus.STATUS_SUCCEEDED)
