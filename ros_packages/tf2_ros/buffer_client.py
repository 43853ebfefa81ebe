"""A buffer in another process, asked through the action that a buffer server offers."""

from __future__ import annotations

import threading
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_py import TimeoutException, TransformException

from tf2_ros.buffer_interface import BufferInterface
from tf2_ros.buffer_server import KINDS


class BufferClient(BufferInterface):
    """Asks a buffer server; another thread must spin the node.

    Args:
        ns: The server's action, such as `tf2_buffer_server`.
        check_frequency: Has no effect.
        timeout_padding: How much longer than a question's own timeout an answer may take.
    """

    def __init__(
        self,
        node: Node,
        ns: str,
        check_frequency: float = 10.0,
        timeout_padding: Duration = Duration(seconds=2.0),  # noqa: B008 - the original's signature
    ) -> None:
        super().__init__()
        self.node = node
        self.action_client: Any = ActionClient(node, LookupTransform, ns)
        self.check_frequency = check_frequency
        self.timeout_padding = timeout_padding

    def wait_for_server(self, timeout: Duration = Duration()) -> bool:  # noqa: B008
        """Return whether the server is there, at the latest after a time."""
        found = self.action_client.wait_for_server(timeout_sec=timeout.nanoseconds / 1e9)
        return bool(found)

    def lookup_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008
    ) -> TransformStamped:
        """Return the transform that maps source into target at a time; `Time()` is the latest.

        Raises:
            TransformException: It is not known in time, or nobody answers.
        """
        goal = LookupTransform.Goal(target_frame=target_frame, source_frame=source_frame)
        goal.source_time, goal.timeout = _stamp(time), timeout.to_msg()
        return self._ask(goal)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Time,
        source_frame: str,
        source_time: Time,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
    ) -> TransformStamped:
        """Return the transform between two times, through a frame that does not move."""
        goal = LookupTransform.Goal(target_frame=target_frame, source_frame=source_frame)
        goal.source_time, goal.timeout = _stamp(source_time), timeout.to_msg()
        goal.target_time, goal.fixed_frame = _stamp(target_time), fixed_frame
        goal.advanced = True
        return self._ask(goal)

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008
    ) -> bool:
        """Return whether a transform is known, waiting up to a time for it."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except TransformException:
            return False
        return True

    def _ask(self, goal: Any) -> TransformStamped:
        patience = Duration.from_msg(goal.timeout).nanoseconds + self.timeout_padding.nanoseconds
        answered = threading.Event()
        answers: list[Any] = []

        def finish(future: Any) -> None:
            answers.append(future.result().result)
            answered.set()

        def accepted(future: Any) -> None:
            future.result().get_result_async().add_done_callback(finish)

        self.action_client.send_goal_async(goal).add_done_callback(accepted)
        if not answered.wait(patience / 1e9):
            name = self.action_client._action_name
            raise TimeoutException(f"no answer from {name} within {patience / 1e9:g} s")
        (result,) = answers
        if result.error.error != TF2Error.NO_ERROR:
            kind = KINDS.get(result.error.error, TransformException)
            raise kind(result.error.error_string)
        return result.transform


def _stamp(time: Any) -> Any:
    """Return a time as a message, which the stamp of one is already."""
    return time.to_msg() if isinstance(time, Time) else time
