"""Action servers that never block: one goal at a time, the newest wins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from unique_identifier_msgs.msg import UUID

from arjuna_core.config import duration_param
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.actions import action_server
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.reports import invalid_code

_SUCCEEDED, _ABORTED = GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_ABORTED
_CANCELED = GoalStatus.STATUS_CANCELED


class GoalError(ArjunaError):
    """A goal cannot be reached."""

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(reason)
        self.code = int(code)


def chosen(kind: str, name: str, names: Sequence[str], code: int) -> str:
    """Return the plug-in that a goal names, the first where it names none.

    Raises:
        GoalError: There is none of that name.
    """
    if name not in ("", *names):
        message = f"{kind} '{name}' does not exist; valid: {', '.join(names)}"
        raise GoalError(code, message)
    return name or names[0]


YIELDING = UUID(uuid=list(b"arjuna: it yields"[:16]))
"""The id of a goal that never preempts another."""


class GoalServer:
    """One goal at a time, the newest wins: nav2_util::SimpleActionServer's contract.

    A new goal while one runs waits as pending (an older pending one is aborted); the node sees
    `preempt_requested` and calls `accept_pending`, which aborts the running goal, or keeps it.

    Args:
        on_goal: Called after a goal became current or pending, to act on it at once; a GoalError
            that it raises ends the goal, as `fail` does.
        admit: Given a goal, says why it is rejected, or None.
        on_cancel: Called after a cancellation was accepted, to act on it at once.
        unknown: Error code of an unknown failure, where the action itself names none.
        invalid: Error code of a goal that cannot be used, where none of the action's is for that.
        result_timeout: How long a result is kept for a client that has not asked for it yet [s].
    """

    def __init__(
        self,
        node: ManagedNode,
        action_type: Any,
        name: str,
        on_goal: Callable[[], None] | None = None,
        admit: Callable[[Any], str | None] | None = None,
        on_cancel: Callable[[], None] | None = None,
        unknown: int = 0,
        invalid: int = 0,
        result_timeout: float = 10.0,
    ) -> None:
        self._node = node
        self._name = name
        self._action_type = action_type
        self._on_goal = on_goal
        self._admit = admit
        self._on_cancel = on_cancel
        self._unknown = unknown
        self._invalid_code = invalid
        self._destroyed = False
        self._current: ServerGoalHandle | None = None
        self._pending: ServerGoalHandle | None = None
        self._server = action_server(
            node,
            action_type,
            name,
            goal_callback=node.guarded(name, self._on_request, lambda *why: GoalResponse.REJECT),
            handle_accepted_callback=node.guarded(name, self._on_accepted, self._failed),
            cancel_callback=self._on_cancel_request,
            result_timeout=result_timeout,
        )

    @property
    def goal(self) -> Any | None:
        """The running goal, or None."""
        return self._current.request if self._current is not None else None

    @property
    def newest(self) -> Any | None:
        """The goal that waits, or else the running one, or None."""
        return self._pending.request if self._pending is not None else self.goal

    @property
    def preempt_requested(self) -> bool:
        """True while a newer goal waits."""
        return self._pending is not None

    @property
    def cancel_requested(self) -> bool:
        """True where the client asked to cancel the running goal and no newer one waits."""
        return self._current is not None and bool(self._current.is_cancel_requested)

    def _on_request(self, goal: Any) -> GoalResponse:
        idle = self._destroyed or not self._node.active
        reason = "the node is not active" if idle else None
        if reason is None and self._admit is not None:
            reason = self._admit(goal)
        if reason is not None:
            self._node.get_logger().warning(f"{self._name}: goal rejected: {reason}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _on_cancel_request(self, handle: ServerGoalHandle) -> CancelResponse:
        cancelled = self._node.guarded(self._name, self._after_cancel_request, self._failed)
        self._node.process.later(cancelled)  # when the goal's state says so
        return CancelResponse.ACCEPT

    def _after_cancel_request(self) -> None:
        """End the pending goal if it was cancelled; the running one is its node's to end."""
        if self._pending is not None and self._pending.is_cancel_requested:
            handle, self._pending = self._pending, None
            self._end(handle, self._action_type.Result(), _CANCELED)
        if self._on_cancel is not None:
            self._on_cancel()

    def _on_accepted(self, handle: ServerGoalHandle) -> None:
        handle.execute()
        problem = self._node.problem_of(self._name, handle.request)
        if problem is not None:
            self._end(handle, self._invalid(problem), _ABORTED)
            return
        if self._current is None:
            self._current = handle
        elif handle.goal_id == YIELDING:
            self._end(handle, self.explained("another goal has come before it"), _ABORTED)
            return
        else:
            if self._pending is not None:
                self.abort_pending(self._replaced())
            self._pending = handle
        try:
            if self._on_goal is not None:
                self._on_goal()
        except GoalError as error:
            self.fail(error)

    def _failed(self, reason: str, *handle: ServerGoalHandle) -> None:
        self.abort_all(f"the node failed: {reason}")

    def explained(self, reason: str, code: int | None = None, **fields: Any) -> Any:
        """Return a result that says why a goal failed; without a code it is the unknown's."""
        result = self._action_type.Result
        unknown = getattr(result, "UNKNOWN", self._unknown)
        answer = result(**fields)
        if hasattr(answer, "error_code"):  # a Create 3's actions have none
            answer.error_code = unknown if code is None else code
        if hasattr(answer, "error_msg"):  # the routes' actions have none
            answer.error_msg = reason
        if hasattr(answer, "success"):
            answer.success = False  # it is true in a fresh result of docking
        return answer

    def _invalid(self, problem: str) -> Any:
        """Return a result that says what cannot be used of a goal, with the action's code."""
        result = self.explained(problem)
        if hasattr(result, "error_code"):  # simulate_steps has another field for it
            result.error_code = self._invalid_code or invalid_code(result, result.error_code)
        return result

    def _replaced(self) -> Any:
        return self.explained(f"replaced by a newer goal at {self._node.now:.2f} s")

    def accept_pending(self) -> Any:
        """Abort the running goal, make the pending one current and return it.

        Raises:
            RuntimeError: No goal is pending.
        """
        if self._pending is None:
            raise RuntimeError("no goal is pending")
        if self._current is not None:
            self._finish(self._replaced(), _CANCELED if self.cancel_requested else _ABORTED)
        self._current, self._pending = self._pending, None
        goal: Any = self._current.request
        return goal

    def take_newest(self) -> Any:
        """Make the goal that waits, if there is one, the running one; return the running goal."""
        return self.accept_pending() if self.preempt_requested else self.goal

    def feedback(self, message: Any) -> None:
        """Publish feedback on the running goal."""
        if self._current is not None:
            self._current.publish_feedback(message)

    def succeed(self, result: Any) -> None:
        """End the running goal as succeeded."""
        self._finish(result, _SUCCEEDED)

    def abort(self, result: Any) -> None:
        """End the running goal as aborted."""
        self._finish(result, _ABORTED)

    def cancel(self, result: Any) -> None:
        """End the running goal as cancelled, after the client asked for it."""
        self._finish(result, _CANCELED)

    def abort_pending(self, result: Any) -> None:
        """End the pending goal as aborted; the running one continues."""
        if self._pending is not None:
            handle, self._pending = self._pending, None
            self._end(handle, result, _ABORTED)

    def fail(self, error: GoalError, **fields: Any) -> None:
        """End the goal that waits, or else the running one, as aborted with a code and a reason."""
        self._node.get_logger().warning(f"{self._name}: goal aborted: {error}")
        result = self.explained(str(error), error.code, **fields)
        (self.abort_pending if self.preempt_requested else self.abort)(result)

    def abort_all(self, reason: str = "the node was deactivated") -> None:
        """End the running and the pending goal as aborted."""
        result = self.explained(f"{reason} at {self._node.now:.2f} s")
        self.abort_pending(result)
        self._finish(result, _ABORTED)

    def _finish(self, result: Any, status: int) -> None:
        if self._current is not None:
            handle, self._current = self._current, None
            self._end(handle, result, status)

    def _end(self, handle: ServerGoalHandle, result: Any, status: int) -> None:
        if status == _CANCELED and not handle.is_cancel_requested:
            status = _ABORTED
        self._server.finish(handle, status, result)

    def destroy(self) -> None:
        """End what is left and leave the graph; no goal is accepted any more."""
        self._destroyed = True
        self.abort_all("the node was shut down")
        self._server.destroy()


def result_timeout(default: float) -> Any:
    """Declare Nav2's parameter `action_server_result_timeout` with a default [s]."""
    what = "How long a result is kept for a client that has not asked for it yet."
    return duration_param(default, what, read_only=True)


class GoalNode(ManagedNode):
    """Stops and aborts every goal where the node is deactivated or time is set back."""

    def offer(
        self, action: Any, name: str, on_goal: Callable[[], None], **options: Any
    ) -> GoalServer:
        """Serve an action; `action_server_result_timeout` says how long results are kept."""
        options["result_timeout"] = getattr(self.config, "action_server_result_timeout", 10.0)
        server: GoalServer = self.keep(GoalServer(self, action, name, on_goal, **options))
        return server

    def halt(self) -> None:
        """Stop what the goals set in motion; they are aborted next."""

    def deactivate(self) -> None:
        """Stop and abort what is asked for."""
        self._abort("the node was deactivated")

    def on_time_jump(self) -> None:
        """Stop and abort: what was asked for belongs to another time."""
        if self.active:
            self._abort("time was set back")

    def on_failure(self, reason: str) -> None:
        """Stop and abort: what the goals were to do cannot be done."""
        if self.active:
            self._abort(f"the node failed: {reason}")

    def _abort(self, reason: str) -> None:
        self.halt()
        for server in self.kept(GoalServer):
            server.abort_all(reason)
