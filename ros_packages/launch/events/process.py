"""Events of processes."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

from launch.event_handler import Event


class ProcessEvent(Event):
    """Something that a process did.

    Attributes:
        action: The action whose process it is.
    """

    name = "launch.events.process.ProcessEvent"

    def __init__(
        self,
        *,
        action: Any,
        name: str = "",
        cmd: list[str] | None = None,
        cwd: str | None = None,
        env: dict[str, str] | None = None,
        pid: int = 0,
    ) -> None:
        self.action, self.process_name, self.cmd = action, name, cmd or []
        self.cwd, self.env, self.pid = cwd, env, pid


class ProcessStarted(ProcessEvent):
    """It has started."""


class ProcessExited(ProcessEvent):
    """It has ended."""

    def __init__(self, *, returncode: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.returncode = returncode


class ProcessIO(ProcessEvent):
    """It has written something."""

    def __init__(self, *, text: bytes, fd: int, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.text, self.fd = text, fd
        self.from_stdin, self.from_stdout, self.from_stderr = fd == 0, fd == 1, fd == 2


class ProcessStdout(ProcessIO):
    """It has written to standard output."""


class ProcessStderr(ProcessIO):
    """It has written to standard error."""


class SignalProcess(Event):
    """A process is to get a signal."""

    name = "launch.events.process.SignalProcess"

    def __init__(self, *, signal_number: int | str, process_matcher: Callable[[Any], bool]) -> None:
        number = signal_number
        self.signal = signal.Signals[number] if isinstance(number, str) else signal.Signals(number)
        self.process_matcher = process_matcher


class ShutdownProcess(Event):
    """A process is to end."""

    name = "launch.events.process.ShutdownProcess"

    def __init__(self, *, process_matcher: Callable[[Any], bool]) -> None:
        self.process_matcher = process_matcher
