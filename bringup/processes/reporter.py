"""A host's reports to its supervisor, and its warning of nodes whose names are taken twice."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from numba.core import event as numba_event

from arjuna_core.ros.context import full_names
from arjuna_core.ros.process import Process
from bringup.processes.health import PATIENCE, PERIOD
from bringup.processes.output import event_line
from bringup.ros2.discovery import any_dead


class _Compilations(numba_event.Listener):
    """Reports that Numba begins to compile a function, which it does where it is first used."""

    def __init__(self, expect: Callable[[float], None]) -> None:
        self._expect = expect

    def on_start(self, event: Any) -> None:
        """Expect a long silence."""
        self._expect(90.0)  # [s] a function takes at most, on a busy machine

    def on_end(self, event: Any) -> None:
        """Leave it at that: the next sign of life ends the silence."""


class Reporter:
    """Writes that a host lives, its nodes' states and what they wait for, each 0.1 s."""

    def __init__(
        self, process: Process, nodes: Sequence[Any], write: Callable[[str], None]
    ) -> None:
        self._process, self._nodes, self._write = process, nodes, write
        self._states: dict[str, str] = {}
        self._waiting: str | None = None
        self._manager_waits = "the start"
        self._due = self._alive_due = 0.0
        process.on_long_step = self._expect_long
        self._compilations = _Compilations(self._expect_long)
        numba_event.register("numba:compile", self._compilations)

    def close(self) -> None:
        """Say no more when something is compiled."""
        numba_event.unregister("numba:compile", self._compilations)

    def _expect_long(self, patience: float) -> None:
        self._alive_due = 0.0
        self._write(event_line(alive=patience))

    def wait_for(self, what: str) -> None:
        """Say what the lifecycle manager waits for, nothing if empty; before a node holds it up."""
        self._manager_waits = what
        self._write_waiting()

    def update(self, now: float) -> None:
        """Report what changed by a time on a steady clock [s], if that is due."""
        if now < self._due:
            return
        self._due = now + 0.1
        if now >= self._alive_due:
            self._alive_due = now + PERIOD
            self._write(event_line(alive=PATIENCE))
        for node in self._nodes:
            name, state = self._process.plain_name(node), node.state_label
            if self._states.get(name) != state:
                self._states[name] = state
                self._write(event_line(node=name, state=state))
        self._write_waiting()

    def _write_waiting(self) -> None:
        waiting = self._manager_waits or self._missing_clock()
        if waiting != self._waiting:
            self._waiting = waiting
            self._write(event_line(waiting=waiting))

    def _missing_clock(self) -> str:
        if not self._process.use_sim_time or self._process.now > 0.0:
            return ""
        topic = self._process.absolute("/clock")
        where = f"ROS_DOMAIN_ID={os.environ.get('ROS_DOMAIN_ID', '0')}"
        if self._process.namespace:
            where += f", --namespace {self._process.namespace}"
        return (
            f"{topic}: is 'python -m bringup sim' running? ({where} here; a real robot"
            " has no clock: use_sim_time: false under /**)"
        )


class Twins:
    """Warns once of names that the graph has twice: both nodes answer, and time runs twice."""

    def __init__(self, node: Any, names: Iterable[str]) -> None:
        self._node, self._names = node, set(names)
        self._due = 0.0
        self._since: float | None = None
        self._warned = False

    def look(self, now: float) -> None:
        """Look, if that is due by a time on a steady clock [s]."""
        if now < self._due:
            return
        self._due = now + 1.0
        every = full_names(self._node)
        twice = sorted(name for name in self._names if every.count(name) > 1)
        if not twice:
            self._since, self._warned = None, False
            return
        self._since = now if self._since is None else self._since
        # A participant that died without a word is forgotten by then [s].
        patience = 25.0 if any_dead(self._node) else 0.0
        if not self._warned and now >= self._since + patience:
            self._warned = True
            own = "; the simulator's own gives way to 'sim --params FILE' of the other's parameters"
            self._node.get_logger().warning(
                f"another process has {', '.join(twice)} too: end one of the two, or give one a"
                f" --namespace or another --domain-id (here {os.environ.get('ROS_DOMAIN_ID', '0')})"
                f"{own if any(name.endswith('/ekf_filter_node') for name in twice) else ''}"
            )
