"""The guard that ends every callback's exception: logged with its cause, counted, survived."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.executors import ExternalShutdownException

from arjuna_core.errors import interrupted


@dataclass
class Tally:
    """The count of one kind of failure, with the latest's reason and time [s].

    Attributes:
        kind: `failed` where a callback raised, `refused` where a message was not valid.
        logged_at: Time of the last that was logged [s].
    """

    kind: str
    count: int = 0
    reason: str = ""
    at: float = 0.0
    logged_at: float = 0.0


class Guard:
    """Calls what may raise, and counts what was raised or refused, by node and source.

    Args:
        now: Returns the process's time [s].
        strict: Whether what a callback raises is raised on, so that a test shows the mistake.
    """

    def __init__(self, now: Callable[[], float], strict: bool = False) -> None:
        self.now, self.strict = now, strict
        self.tallies: dict[tuple[str, str], Tally] = {}

    def call(self, node: Any, source: str, callback: Callable[..., Any], *arguments: Any) -> None:
        """Call a node's callback, whose exceptions end here; the log names the source."""
        self.guarded(node, source, callback)(*arguments)

    def guarded(
        self,
        node: Any,
        source: str,
        callback: Callable[..., Any],
        otherwise: Callable[..., Any] = lambda reason, *arguments: None,
    ) -> Callable[..., Any]:
        """Return a node's callback whose exceptions end here.

        `otherwise` is called with the reason and the arguments where it raised, for what to return.
        """

        def run(*arguments: Any) -> Any:
            try:
                return callback(*arguments)
            except ExternalShutdownException:
                raise
            except Exception as error:
                if interrupted(error):
                    raise KeyboardInterrupt from error
                if self.strict:
                    raise
                reason = f"{type(error).__name__}: {error}"
                cause = "".join(traceback.format_exception(error))
                self._count(node, source, "failed", reason, cause)
                return otherwise(reason, *arguments)

        run.__wrapped__ = callback  # type: ignore[attr-defined]  # rclpy counts its arguments
        return run

    def refused(self, node: Any, source: str, reason: str) -> None:
        """Count and log a message, request or goal that was not taken."""
        self._count(node, source, "refused", reason, reason)

    def _count(self, node: Any, source: str, kind: str, reason: str, cause: str) -> None:
        """Count, and log the first in full, then one a minute."""
        key = (node.get_fully_qualified_name(), source)
        tally = self.tallies.setdefault(key, Tally(kind))
        tally.count += 1
        now = self.now()
        tally.kind, tally.reason, tally.at = kind, reason, now
        if tally.count == 1:
            text = f"{source} {kind}: {cause}"
        elif not 0.0 <= now - tally.logged_at < 60.0:
            text = f"{source} {kind}, {tally.count} times so far; the last: {reason}"
        else:
            return
        tally.logged_at = now
        if kind == "failed":
            node.get_logger().error(text)
        else:
            node.get_logger().warning(text)
