"""The output of a run, merged, and its log file below `~/.arjuna/log`."""

from __future__ import annotations

import json
import os
import re
import select
import shutil
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime
from logging import Formatter, Logger
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import Any

from bringup.terminal import is_read, write

RUNS_KEPT = 20
_RUN = re.compile(r"\d{8}-\d{6}-[a-z-]+(-\d+)?")
_FILE = "log.txt"


class RunLog:
    """Writes the lines of a run with the time; the oldest runs' folders go.

    Args:
        root: The folder of all runs; `~/.arjuna/log` by default.

    Attributes:
        path: The file; None where it cannot be written.
    """

    def __init__(self, command: str, started: datetime, root: Path | None = None) -> None:
        root = Path.home() / ".arjuna" / "log" if root is None else root
        self._logger = Logger(command)
        self.path: Path | None = None
        try:
            self.path = _new_folder(root, f"{started:%Y%m%d-%H%M%S}-{command}") / _FILE
            handler = RotatingFileHandler(self.path, maxBytes=10_000_000, backupCount=1)
        except OSError:
            return  # a full disk or a foreign home must not stop the robot
        handler.setFormatter(Formatter("%(asctime)s.%(msecs)03d %(message)s", "%Y-%m-%d %H:%M:%S"))
        self._logger.addHandler(handler)
        _remove_old(root)

    def write(self, line: str) -> None:
        """Write a line."""
        self._logger.info("%s", line)

    def close(self) -> None:
        """Close the file."""
        for handler in list(self._logger.handlers):
            self._logger.removeHandler(handler)
            handler.close()


def _new_folder(root: Path, name: str) -> Path:
    """Make the folder of a run; a second one of the same second gets a number."""
    number, folder = 1, root / name
    while folder.exists():
        number += 1
        folder = root / f"{name}-{number}"
    folder.mkdir(parents=True)
    return folder


def _remove_old(root: Path) -> None:
    runs = sorted(folder for folder in root.iterdir() if _RUN.fullmatch(folder.name))
    for folder in runs[:-RUNS_KEPT]:
        shutil.rmtree(folder, ignore_errors=True)


OWN = "bringup"
"""The name of the supervisor's own lines."""
_MARK = "\x1e"
"""Begins an event among the lines of a log, as in JSON text sequences (RFC 7464)."""
_LEVEL = re.compile(r"\[(DEBUG|INFO|WARN|ERROR|FATAL)\]")
_COLORS = {"DEBUG": "\033[32m", "WARN": "\033[33m", "ERROR": "\033[31m", "FATAL": "\033[31m"}
_PLAIN = "\033[0m"
_ERASE = "\r\033[K"


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
class _Process:
    """A process in one of its lives: its nodes' states, and what it waits for."""

    nodes: dict[str, str] = field(default_factory=dict)
    waiting: str = "imports its nodes"
    up: bool = False


class StartUp:
    """Progress of the start-up at a time [s]: the processes with nodes that are up, and who waits.

    Events of other processes are left alone.
    """

    def __init__(self, names: Iterable[str], now: float) -> None:
        self._processes = {name: _Process() for name in names}
        self._since = self._changed = now
        self._reported = ""
        self._up = not self._processes

    def restarted(self, name: str, now: float) -> None:
        """Begin again with one process."""
        if name in self._processes:
            self._since = now if self._up else self._since
            self._up = False
            self._processes[name] = _Process()

    def take(self, name: str, event: dict[str, Any]) -> None:
        """Take an event of a process: a node's state, or what it waits for."""
        if (process := self._processes.get(name)) is None:
            return
        if "node" in event:
            process.nodes[event["node"]] = event["state"]
        process.waiting = event.get("waiting", process.waiting)
        states = process.nodes.values()
        if states and not process.waiting and all(state == "active" for state in states):
            process.up = True

    def was_up(self, name: str) -> bool:
        """Return whether all nodes of a process have been active since it started."""
        return name in self._processes and self._processes[name].up

    @property
    def waiting(self) -> str:
        """The things that are waited for, process by process; empty where all are up."""
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
        if waiting != self._reported:
            self._reported, self._changed = waiting, now
        elif waiting and self._changed <= now - patience:
            self._changed = float("inf")
            return waiting
        return None

    def elapsed(self, now: float) -> float:
        """Return the time since the start [s]."""
        return now - self._since


class Output(ABC):
    """Takes what a supervisor and its processes report, and what waits for a patience [s].

    What nobody reads is left out, and said once somebody does: the robot does not wait for them.
    """

    def __init__(self, start_up: StartUp, log: RunLog, patience: float = 3.0) -> None:
        self.start_up = start_up
        self._log, self._patience = log, patience
        self._unread = 0

    def line(self, process: str, text: str) -> None:
        """Show a line of a process's log."""
        level = _LEVEL.search(text)
        self._log.write(f"[{process}] {text}")
        self.show_line(process, text, level[1] if level else "")

    def event(self, process: str, event: dict[str, Any]) -> None:
        """Take an event of a process."""
        self.start_up.take(process, event)
        self.show_event(process, event)

    def state(self, process: str, state: str, text: str = "") -> None:
        """Show a process's new state, and words for a person."""
        if state == "started":
            self.start_up.restarted(process, time.monotonic())
        self.show_event(process, {"state": state})
        if text:
            self.line(OWN, text)

    def tick(self) -> None:
        """Say what has been waited for long, and when all are up; called several times a second."""
        now = time.monotonic()
        if self._unread and is_read():
            unread, self._unread = self._unread, 0
            kept = "" if self._log.path is None else f"; log: {self._log.path}"
            self.line(OWN, f"{unread} lines that nobody read are left out{kept}")
        if (overdue := self.start_up.overdue(now, self._patience)) is not None:
            self.line(OWN, f"waiting for {overdue}")
        if (duration := self.start_up.came_up(now)) is not None:
            self.show_event(OWN, {"state": "active", "seconds": round(duration, 2)})
            self.line(OWN, f"{self.start_up.nodes} nodes active after {duration:.1f} s")

    def _print(self, text: str) -> None:
        """Print a text, in parts that a pipe takes whole (PIPE_BUF of pipe(7)), unless unread."""
        for start in range(0, len(text), select.PIPE_BUF // 4):
            if self._unread or not is_read():
                self._unread += text.endswith("\n")
                return
            write(text[start : start + select.PIPE_BUF // 4])

    @abstractmethod
    def show_line(self, process: str, text: str, level: str) -> None:
        """Show a line of a log, of a level as `INFO`; empty where it has none."""

    @abstractmethod
    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Show an event."""


class JsonOutput(Output):
    """Shows a run as JSON: an object a line."""

    def show_line(self, process: str, text: str, level: str) -> None:
        """Print a line of a log."""
        self.show_event(process, {"level": level.lower() or "info", "text": text})

    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Print an event."""
        self._print(json.dumps({"time": round(time.time(), 3), "process": process, **event}) + "\n")


class TextOutput(Output):
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
            self._print(_ERASE)
        self._print(f"{color}{shown}{_PLAIN}\n" if color else f"{shown}\n")
        self._print(self._progress)

    def show_event(self, process: str, event: dict[str, Any]) -> None:
        """Redraw the progress."""
        waiting = self.start_up.waiting
        if not self._live or not (waiting or self._progress):
            return
        elapsed = self.start_up.elapsed(time.monotonic())
        width = shutil.get_terminal_size().columns - 1
        self._progress = f"{elapsed:.1f} s, waiting for {waiting}"[:width] if waiting else ""
        self._print(_ERASE + self._progress)

    def tick(self) -> None:
        """Redraw the progress also where nothing came."""
        super().tick()
        self.show_event(OWN, {})
