"""The end of an action's server or client, which rclpy's executor must survive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_TURNS_TO_SETTLE = 8  # of the executor: a cancellation, its answer, the result, and their echoes


def retire(
    node: Any, waitable: Any, destroy: Callable[[], None], turns: int = _TURNS_TO_SETTLE
) -> None:
    """Take an action's end out of the executor some turns from now, then destroy it.

    rclpy's EventsExecutor crashes the process (it drops a Python reference without the interpreter
    lock) where an event of a waitable comes between its removal and the executor's next turn.
    """
    if turns:
        node.executor.create_task(retire, node, waitable, destroy, turns - 1)
        return
    node.remove_waitable(waitable)
    node.executor.create_task(destroy)
