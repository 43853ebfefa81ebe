"""Keys pressed in a terminal, one by one."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from typing import Any


class Keys:
    """Reads single keys from standard input where that is a terminal; a context manager.

    Attributes:
        live: Whether there is a terminal.
    """

    def __init__(self) -> None:
        self._descriptor = -1
        self._before: list[Any] = []
        self.live = sys.stdin is not None and sys.stdin.isatty()

    def __enter__(self) -> Keys:
        if self.live:
            self._descriptor = sys.stdin.fileno()
            self._before = termios.tcgetattr(self._descriptor)
            tty.setcbreak(self._descriptor)
        return self

    def __exit__(self, *ended: object) -> None:
        if self.live:
            termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def wait(self, timeout: float) -> str:
        """Return the key that is pressed within a time [s], "" where there is none."""
        inputs = [self._descriptor] if self.live else []
        if not select.select(inputs, [], [], timeout)[0]:
            return ""
        return os.read(self._descriptor, 1).decode(errors="replace")
