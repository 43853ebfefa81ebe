"""The state of navigation and of the nodes, as the panel's text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

_ENDS = {4: "arrived", 5: "cancelled", 6: "failed"}  # of action_msgs/GoalStatus
_MARKS = {"active": "●", "inactive": "○", "unconfigured": "·"}


@dataclass(frozen=True)
class Navigation:
    """What is known of the goal that was given last, by whomever.

    Attributes:
        state: What is going on.
        distance: Left to drive [m].
        time: Since it started [s].
        recoveries: How often it had to recover.
        error: Why it failed, or what was refused.
    """

    state: str = "no goal"
    distance: float | None = None
    time: float | None = None
    recoveries: int = 0
    error: str = ""

    def driving(self, distance: float, time: float, recoveries: int) -> Navigation:
        """Return the state with feedback taken in."""
        return replace(self, state="driving", distance=distance, time=time, recoveries=recoveries)

    def ended(self, status: int, code: int, message: str) -> Navigation:
        """Return the state after a goal's end: a GoalStatus, the action's code and its reason."""
        reason = message or ("" if code == 0 else f"error code {code}")
        return replace(self, state=_ENDS.get(status, "over"), distance=None, error=reason)

    def text(self) -> str:
        """Return it as Markdown."""
        lines = [f"**{self.state}**"]
        if self.distance is not None:
            lines.append(f"{self.distance:.2f} m to go")
        if self.time is not None:
            lines.append(f"{self.time:.0f} s, recoveries: {self.recoveries}")
        text = " · ".join(lines)
        return f"{text}\n\n⚠ {self.error}" if self.error else text


def nodes_text(states: Mapping[str, str]) -> str:
    """Return the lifecycle states of nodes as a Markdown table."""
    if not states:
        return "no managed nodes found"
    rows = [f"| {_MARKS.get(s, '✖')} | {name} | {s} |" for name, s in sorted(states.items())]
    return "\n".join(["| | node | state |", "|-|-|-|", *rows])
