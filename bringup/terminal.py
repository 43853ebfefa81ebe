"""The terminal: lines for its user, and the keys and signals that come from there."""

from __future__ import annotations

import os
import select
import signal
import sys
import termios
import threading
import tty
from typing import Any


def show(line: str) -> None:
    """Print a line; where nobody reads any more, as after `| head`, stop."""
    write(f"{line}\n")


def write(text: str) -> None:
    """Print a text without a line's end; where nobody reads any more, stop."""
    try:
        print(text, end="", flush=True)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123 - for the rest of the process
        os.kill(os.getpid(), signal.SIGTERM)


def stopped_by_signals() -> threading.Event:
    """Return an event that Ctrl-C and a request to terminate set, from now on."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    return stop


class Keys:
    """Reads single keys from standard input where that is a terminal; a context manager.

    Args:
        raw: Whether keys that send signals, such as Ctrl-C, are read as keys too.

    Attributes:
        live: Whether there is a terminal.
    """

    def __init__(self, raw: bool = False) -> None:
        self._set_mode = tty.setraw if raw else tty.setcbreak
        self._descriptor = -1
        self._before: list[Any] = []
        self.live = sys.stdin is not None and sys.stdin.isatty()

    def __enter__(self) -> Keys:
        if self.live:
            self._descriptor = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._descriptor)
            self._set_mode(self._descriptor)
        return self

    def __exit__(self, *ended: object) -> None:
        if self.live:
            termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def waits(self, timeout: float = 0.0) -> bool:
        """Return whether a key has been pressed, at the latest after a time [s]."""
        inputs = [self._descriptor] if self.live else []
        return bool(select.select(inputs, [], [], timeout)[0])

    def wait(self, timeout: float) -> str:
        """Return the key that is pressed within a time [s], "" where there is none."""
        return os.read(self._descriptor, 1).decode("latin-1") if self.waits(timeout) else ""
