"""The ends of an action that never block and may go at any time, on either transport."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle

from arjuna_core.ros import qos
from arjuna_core.ros.local.actions import LocalActionClient, LocalActionServer
from arjuna_core.ros.node import ManagedNode

_ENDS = {
    GoalStatus.STATUS_SUCCEEDED: "succeed",
    GoalStatus.STATUS_ABORTED: "abort",
    GoalStatus.STATUS_CANCELED: "canceled",
}
_PROFILES = {f"{part}_service_qos_profile": qos.SERVICES for part in ("goal", "result", "cancel")}
_OFF_THE_TICKS = 1e-6
"""rcl's expiry never ends in lock-step where a result is exactly as old as it may be [s]."""


def action_server(
    node: ManagedNode, action_type: Any, name: str, result_timeout: float, **callbacks: Any
) -> Any:
    """Return an action's server; a goal lasts until `finish`, a result is kept for a time [s]."""
    server: Any = DeferredActionServer if node.transport is None else LocalActionServer
    return server(
        node,
        action_type,
        name,
        execute_callback=lambda handle: None,
        result_timeout=result_timeout + _OFF_THE_TICKS,
        **callbacks,
        **_PROFILES,
    )


def action_client(node: ManagedNode, action_type: Any, name: str) -> Any:
    """Return an action's client."""
    if node.transport is not None:
        return LocalActionClient(node, action_type, name)
    return _SettlingActionClient(node, action_type, name, **_PROFILES)


def _retire(node: Any, waitable: Any, destroy: Callable[[], None], turns: int = 8) -> None:
    """Take an action's end out of the executor some turns from now, then destroy it.

    rclpy's EventsExecutor crashes the process (it drops a Python reference without the interpreter
    lock) where an event of a waitable comes between its removal and the executor's next turn.
    Eight turns cover a cancellation, its answer, the result, and their echoes.
    """
    if turns:
        node.executor.create_task(_retire, node, waitable, destroy, turns - 1)
        return
    node.remove_waitable(waitable)
    node.executor.create_task(destroy)


class DeferredActionServer(ActionServer):
    """An action server whose goals stay executing until `finish`.

    rclpy runs a goal inside its execute callback; a goal that lasts would have to block there.
    """

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Leave the goal executing."""

    def finish(self, handle: ServerGoalHandle, status: int, result: Any) -> None:
        """End a goal in a final state and send its result.

        It goes at once: rclpy would send it from a task, and a node that shuts down has destroyed
        its server by then.
        """
        getattr(handle, _ENDS[status])()
        response = self._action_type.Impl.GetResultService.Response(
            status=handle.status, result=result
        )
        self._result_futures[bytes(handle.goal_id.uuid)].set_result(response)

    def destroy(self) -> None:
        """Leave the graph once pending events were handled."""
        _retire(self._node, self, self._destroy_handles)

    def _destroy_handles(self) -> None:
        for handle in self._goal_handles.values():
            handle.destroy()
        self._handle.destroy_when_not_in_use()


class _SettlingActionClient(ActionClient):
    """An action client that may be destroyed while answers are pending."""

    def destroy(self) -> None:
        """Leave the graph once pending events were handled."""
        _retire(self._node, self, self._client_handle.destroy_when_not_in_use)
