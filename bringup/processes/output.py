"""What a run shows: its processes' lines, merged, and how far the start-up is."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import time
from abc import ABC, abstractmethod
from typing import Any, Protocol

from bringup.processes.run_log import RunLog
from bringup.processes.status import StartUp, read_event
from bringup.terminal import show, write

PATIENCE = 3.0
"""How long something may be waited for before a line says so [s]."""
_LEVEL = re.compile(r"\[(DEBUG|INFO|WARN|ERROR|FATAL)\]")
_COLORS = {"DEBUG": "\033[32m", "WARN": "\033[33m", "ERROR": "\033[31m", "FATAL": "\033[31m"}
_PLAIN = "\033[0m"
_ERASE = "\r\033[K"
OWN = "bringup"
"""The name of the supervisor's own lines."""


class Output(Protocol):
    """Takes what a supervisor has to say."""

    def line(self, process: str, text: str) -> None:
        """Take a line that a process wrote."""

    def state(self, process: str, state: str, text: str = "") -> None:
        """Take a process's new state, and words for a person."""

    def tick(self) -> None:
        """Do what is due by time; called several times a second."""


class _Shown(ABC):
    """What the two ways to show a run share.

    Args:
        start_up: Follows the start-up.
        log: The run's file.
    """

    def __init__(self, start_up: StartUp, log: RunLog) -> None:
        self.start_up = start_up
        self._log = log

    def line(self, process: str, text: str) -> None:
        """Show a line of a log, or take the event that it is."""
        event = read_event(text)
        if event is None:
            level = _LEVEL.search(text)
            self._log.write(f"[{process}] {text}")
            self.show_line(process, text, level[1] if level else "")
        else:
            self.start_up.take(process, event)
            self.show_event(process, event)

    def state(self, process: str, state: str, text: str = "") -> None:
        """Show a process's new state."""
        if state == "started":
            self.start_up.restarted(process, time.monotonic())
        self.show_event(process, {"state": state})
        if text:
            self.line(OWN, text)

    def tick(self) -> None:
        """Say what has been waited for long, and when all are up."""
        now = time.monotonic()
        if (overdue := self.start_up.overdue(now, PATIENCE)) is not None:
            self.line(OWN, f"waiting for {overdue}")
        if (duration := self.start_up.came_up(now)) is not None:
            self.show_event(OWN, {"state": "active", "seconds": round(duration, 2)})
            self.line(OWN, f"{self.start_up.nodes} nodes active after {duration:.1f} s")

    @abstractmethod
    def show_line(self, process: str, text: str, level: str) -> None:
        """Show a line of a log, of a level as `INFO`; empty where it has none."""

    @abstractmethod
    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Show an event."""


class JsonOutput(_Shown):
    """Shows a run as JSON: an object a line."""

    def show_line(self, process: str, text: str, level: str) -> None:
        """Print a line of a log."""
        self.show_event(process, {"level": level.lower() or "info", "text": text})

    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Print an event."""
        show(json.dumps({"time": round(time.time(), 3), "process": process, **event}))


class TextOutput(_Shown):
    """Shows a run to a person; on a terminal with colours, and one line of progress at the end."""

    def __init__(self, start_up: StartUp, log: RunLog) -> None:
        super().__init__(start_up, log)
        self._live = sys.stdout.isatty()
        self._colored = self._live and not os.environ.get("NO_COLOR")
        self._progress = ""

    def show_line(self, process: str, text: str, level: str) -> None:
        """Print a line, above the progress."""
        color = _COLORS.get(level, "") if self._colored else ""
        shown = f"[{process}] {text}"
        if self._progress:
            write(_ERASE)
        show(f"{color}{shown}{_PLAIN}" if color else shown)
        write(self._progress)

    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Redraw the progress."""
        self._draw()

    def tick(self) -> None:
        """Redraw the progress also where nothing came."""
        super().tick()
        self._draw()

    def _draw(self) -> None:
        waiting = self.start_up.waiting
        if not self._live or not (waiting or self._progress):
            return
        elapsed = self.start_up.elapsed(time.monotonic())
        width = shutil.get_terminal_size().columns - 1
        self._progress = f"{elapsed:.1f} s, waiting for {waiting}"[:width] if waiting else ""
        write(_ERASE + self._progress)
