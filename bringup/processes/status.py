"""What the processes of a run say about themselves: events on their output, and what is missing."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

_MARK = "\x1e"
"""Begins an event among the lines of a log, as in JSON text sequences (RFC 7464)."""
ACTIVE = "active"


def event_line(**event: Any) -> str:
    """Return an event as a line of output."""
    return _MARK + json.dumps(event)


def read_event(line: str) -> dict[str, Any] | None:
    """Return the event that a line of output is; None for a line of a log."""
    if not line.startswith(_MARK):
        return None
    try:
        event = json.loads(line[1:])
    except json.JSONDecodeError:
        return None
    return event if isinstance(event, dict) else None


@dataclass
class ProcessState:
    """A process in one of its lives, as it tells it.

    Attributes:
        nodes: Its nodes' states.
        waiting: What it waits for.
        up: Whether all its nodes were active once.
    """

    nodes: dict[str, str] = field(default_factory=dict)
    waiting: str = "imports its nodes"
    up: bool = False

    def take(self, event: dict[str, Any]) -> None:
        """Take an event: a node's state, or what is waited for."""
        if "node" in event:
            self.nodes[event["node"]] = event["state"]
        self.waiting = event.get("waiting", self.waiting)
        states = self.nodes.values()
        if states and not self.waiting and all(state == ACTIVE for state in states):
            self.up = True


class StartUp:
    """Whether all processes are up and, if not, what they wait for.

    Args:
        names: The processes that hold nodes.
        now: The time [s], on any steady clock.
    """

    def __init__(self, names: Iterable[str], now: float) -> None:
        self._processes = {name: ProcessState() for name in names}
        self._since = self._changed = now
        self._said = ""
        self._up = not self._processes

    def restarted(self, name: str, now: float) -> None:
        """Begin anew with one process."""
        if name not in self._processes:
            return
        if self._up:
            self._since = now
        self._up = False
        self._processes[name] = ProcessState()

    def take(self, name: str, event: dict[str, Any]) -> None:
        """Take an event of a process: a node's state, or what it waits for."""
        if name in self._processes:
            self._processes[name].take(event)

    @property
    def waiting(self) -> str:
        """What is waited for, process by process; empty where all are up."""
        missing: dict[str, list[str]] = {}
        for name, process in self._processes.items():
            if not process.up:
                missing.setdefault(process.waiting or "its nodes", []).append(name)
        return "; ".join(f"{', '.join(names)}: {what}" for what, names in missing.items())

    @property
    def nodes(self) -> int:
        """The number of nodes."""
        return sum(len(process.nodes) for process in self._processes.values())

    def came_up(self, now: float) -> float | None:
        """Return how long it took [s] once all are up, and None ever after."""
        if self._up or self.waiting:
            return None
        self._up = True
        return now - self._since

    def overdue(self, now: float, patience: float) -> str | None:
        """Return what has been waited for as long as a patience [s], once each."""
        waiting = self.waiting
        if waiting != self._said:
            self._said, self._changed = waiting, now
        elif waiting and self._changed <= now - patience:
            self._changed = float("inf")
            return waiting
        return None

    def elapsed(self, now: float) -> float:
        """Return the time since the start [s]."""
        return now - self._since
