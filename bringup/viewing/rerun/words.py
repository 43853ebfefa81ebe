"""Messages that are words: states, logs."""

from __future__ import annotations

from typing import Any

import rerun as rr

from bringup.viewing.rerun.stream import Stream

_STATES = ("unknown", "accepted", "executing", "canceling", "succeeded", "canceled", "aborted")
_LEVELS = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "CRITICAL"}


def goal_status(stream: Stream, topic: str, message: Any) -> None:
    """Show an action's newest goal's state as a lane of the state timeline."""
    if message.status_list:
        code = max(message.status_list, key=_accepted).status
        state = _STATES[code] if 0 <= code < len(_STATES) else str(code)
        action = topic.removesuffix("/_action/status")
        stream.log(f"states{action}", rr.StateChange(state=state))


def _accepted(status: Any) -> tuple[int, int]:
    stamp = status.goal_info.stamp
    return stamp.sec, stamp.nanosec


def log(stream: Stream, topic: str, message: Any) -> None:
    """Show a line of a node's log."""
    level = _LEVELS.get(message.level, "INFO")
    stream.log(f"logs/{message.name or 'unnamed'}", rr.TextLog(message.msg, level=level))


def text(stream: Stream, topic: str, message: Any) -> None:
    """Show a text, such as the explorer's status."""
    if len(message.data) < 1000:  # no description of a robot under another name
        stream.log(f"logs{topic}", rr.TextLog(message.data, level="INFO"))
