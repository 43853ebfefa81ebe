"""Action clients that never block: goals are answered by callbacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus

from arjuna_core.ros.actions import action_client
from arjuna_core.ros.goal_server import YIELDING
from arjuna_core.ros.node import ManagedNode


@dataclass(frozen=True)
class GoalOutcome:
    """A goal's end as its client sees it.

    Attributes:
        status: A GoalStatus constant.
        result: The action's result message; None if it was not accepted.
    """

    accepted: bool
    status: int
    result: Any | None

    @property
    def succeeded(self) -> bool:
        """True where the goal was reached."""
        return bool(self.status == GoalStatus.STATUS_SUCCEEDED)


class GoalClient:
    """Sends goals and hands back outcomes by callback; only the newest goal's outcome counts."""

    def __init__(self, node: ManagedNode, action_type: Any, name: str) -> None:
        self.name = name
        self._node = node
        self._client = action_client(node, action_type, name)
        self._running: dict[int, Any] = {}
        self._cancels: list[tuple[float, Any]] = []
        self._sequence = self._cancelled_up_to = self._acknowledged = 0
        self._destroyed = False

    @property
    def ready(self) -> bool:
        """True where a server is there."""
        return bool(self._client.server_is_ready())

    @property
    def acknowledged(self) -> bool:
        """True where the server has taken the newest goal, or refused it."""
        return self._acknowledged == self._sequence

    def send(
        self,
        goal: Any,
        on_outcome: Callable[[GoalOutcome], None],
        on_feedback: Callable[[Any], None] | None = None,
        yields: bool = False,
    ) -> None:
        """Send a goal; an earlier goal's outcome is no longer reported.

        Args:
            yields: Whether a goal server of ours drops it where another goal runs.
        """
        self._sequence += 1
        sequence = self._sequence

        def feedback(message: Any) -> None:
            if on_feedback is not None and sequence == self._sequence:
                on_feedback(message.feedback)

        def outcome(value: GoalOutcome) -> None:
            self._running.pop(sequence, None)
            if sequence == self._sequence:
                on_outcome(value)

        future = self._client.send_goal_async(
            goal, feedback_callback=self._guarded(feedback), goal_uuid=YIELDING if yields else None
        )
        future.add_done_callback(
            self._guarded(lambda done: self._on_response(done.result(), sequence, outcome))
        )

    def _guarded(self, callback: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return a callback that ends what the node was doing where it raises."""
        failed = self._node.on_failure
        return self._node.guarded(self.name, callback, lambda reason, _: failed(reason))

    def _on_response(
        self, handle: Any, sequence: int, outcome: Callable[[GoalOutcome], None]
    ) -> None:
        if self._destroyed:
            return
        self._acknowledged = max(self._acknowledged, sequence)
        if not handle.accepted:
            outcome(GoalOutcome(False, GoalStatus.STATUS_UNKNOWN, None))
            return
        self._running[sequence] = handle
        if sequence <= self._cancelled_up_to:
            self._cancel(handle)
        future = handle.get_result_async()
        future.add_done_callback(
            self._guarded(
                lambda done: outcome(GoalOutcome(True, done.result().status, done.result().result))
            )
        )

    def cancel(self) -> None:
        """Ask the server to cancel what runs; the newest goal's outcome is still reported."""
        self._cancel_up_to(self._sequence)

    def cancel_replaced(self) -> None:
        """Cancel what the newest goal was to replace, and could not where the server refused it."""
        self._cancel_up_to(self._sequence - 1)

    def _cancel_up_to(self, sequence: int) -> None:
        self._cancelled_up_to = sequence
        for number, handle in self._running.items():
            if number <= sequence:
                self._cancel(handle)

    def _cancel(self, handle: Any) -> None:
        self._cancels.append((self._node.now, handle.cancel_goal_async()))

    def take_late_cancels(self, limit: float) -> int:
        """Return, once, how many cancels are not answered after a limit [s]."""
        waiting = [each for each in self._cancels if not each[1].done()]
        self._cancels = [each for each in waiting if self._node.now - each[0] <= limit]
        return len(waiting) - len(self._cancels)

    def destroy(self) -> None:
        """Leave the graph; no outcome is reported any more."""
        self._destroyed = True
        self._sequence += 1
        self._client.destroy()
