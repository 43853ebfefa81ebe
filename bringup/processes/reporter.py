"""Tells the supervisor about a host: that it lives, its nodes' states, what they wait for."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from numba.core import event as numba_event

from arjuna_core.ros.process import Process
from bringup.processes.heartbeat import PATIENCE, PERIOD
from bringup.processes.status import event_line

_PERIOD = 0.1
_COMPILATION = 90.0  # [s] at most of one function, on a busy machine


class _Compilations(numba_event.Listener):
    """Tells before Numba compiles a function, which it does where it is first used, and no later.

    Args:
        expect: Told how long the process may be silent [s].
    """

    def __init__(self, expect: Callable[[float], None]) -> None:
        self._expect = expect

    def on_start(self, event: Any) -> None:
        """Expect a long silence."""
        self._expect(_COMPILATION)

    def on_end(self, event: Any) -> None:
        """Leave it at that: the next sign of life ends the silence."""


class Reporter:
    """Writes what changed.

    Args:
        process: The host's process.
        nodes: Its nodes.
        write: Takes events as lines.
    """

    def __init__(
        self, process: Process, nodes: Sequence[Any], write: Callable[[str], None]
    ) -> None:
        self._process = process
        self._nodes = nodes
        self._write = write
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
        """Say that the next sign of life may take a time [s]."""
        self._alive_due = 0.0
        self._write(event_line(alive=patience))

    def wait_for(self, what: str) -> None:
        """Say what the lifecycle manager waits for, nothing if empty; before a node holds it up."""
        self._manager_waits = what
        self._say_waiting()

    def update(self, now: float) -> None:
        """Report what changed by a time on a steady clock [s], if that is due."""
        if now < self._due:
            return
        self._due = now + _PERIOD
        if now >= self._alive_due:
            self._alive_due = now + PERIOD
            self._write(event_line(alive=PATIENCE))
        for node in self._nodes:
            name = self._process.plain_name(node)
            state = node.state_label
            if self._states.get(name) != state:
                self._states[name] = state
                self._write(event_line(node=name, state=state))
        self._say_waiting()

    def _say_waiting(self) -> None:
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
