"""A buffer that other processes ask, by an action."""

from __future__ import annotations

from functools import partial
from typing import Any

from rclpy.action import ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_py import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

from tf2_ros.buffer import Buffer

KINDS: dict[int, type[TransformException]] = {
    TF2Error.LOOKUP_ERROR: LookupException,
    TF2Error.CONNECTIVITY_ERROR: ConnectivityException,
    TF2Error.EXTRAPOLATION_ERROR: ExtrapolationException,
    TF2Error.INVALID_ARGUMENT_ERROR: InvalidArgumentException,
    TF2Error.TIMEOUT_ERROR: TimeoutException,
    TF2Error.TRANSFORM_ERROR: TransformException,
}
"""The exception of each code."""


class BufferServer:
    """Answers as soon as a transform is known, or its time is over.

    Args:
        ns: The action's name.
        check_period: From one look at what is not known yet to the next.
    """

    def __init__(
        self,
        buffer: Buffer,
        node: Node,
        ns: str,
        check_period: Duration = Duration(seconds=0.01),  # noqa: B008 - the original's signature
    ) -> None:
        self._buffer, self._node = buffer, node
        self._waiting: list[tuple[Any, Time]] = []
        group = ReentrantCallbackGroup()
        self._server = ActionServer(
            node,
            LookupTransform,
            ns,
            LookupTransform.Result,  # never called: each goal is ended by its own result
            callback_group=group,
            handle_accepted_callback=self._accept,
        )
        self._timer = node.create_timer(check_period.nanoseconds / 1e9, self._check, group)
        self._timer.cancel()  # until somebody waits

    def _accept(self, handle: Any) -> None:
        end = self._node.get_clock().now() + Duration.from_msg(handle.request.timeout)
        self._waiting.append((handle, end))
        self._timer.reset()
        self._check()

    def _check(self) -> None:
        waiting, self._waiting = self._waiting, []
        for handle, end in waiting:
            result = self._looked_up(handle.request)
            known = result.error.error == TF2Error.NO_ERROR
            if known or self._node.get_clock().now() >= end:
                handle.execute(partial(_end, result))
            else:
                self._waiting.append((handle, end))
        if not self._waiting:
            self._timer.cancel()

    def _looked_up(self, goal: Any) -> Any:
        result, target = LookupTransform.Result(), goal.target_frame
        source, time = goal.source_frame, Time.from_msg(goal.source_time)
        try:
            if goal.advanced:
                at = Time.from_msg(goal.target_time)
                fixed = goal.fixed_frame
                found = self._buffer.lookup_transform_full(target, at, source, time, fixed)
            else:
                found = self._buffer.lookup_transform(target, source, time)
            result.transform = found
        except TransformException as error:
            codes = {kind: code for code, kind in KINDS.items()}
            result.error.error = codes.get(type(error), TF2Error.TRANSFORM_ERROR)
            result.error.error_string = str(error)
        return result

    def destroy(self) -> None:
        self._node.destroy_timer(self._timer)
        self._server.destroy()


def _end(result: Any, handle: Any) -> Any:
    """End a goal with its result."""
    if result.error.error == TF2Error.NO_ERROR:
        handle.succeed()
    else:
        handle.abort()
    return result
