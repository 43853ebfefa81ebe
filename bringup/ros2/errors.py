"""The ends of a `ros2` command: its one error, and Ctrl-C, which Python drops in destructors."""

from __future__ import annotations

import signal

from arjuna_core.errors import ArjunaError


class Ros2Error(ArjunaError):
    """A command failed, in ros2cli's words."""


_seen = False


def watch_interrupts() -> None:
    """Keep in mind from now on that Ctrl-C came, beside raising KeyboardInterrupt."""
    global _seen
    _seen = False
    signal.signal(signal.SIGINT, _on_signal)


def check_interrupts() -> None:
    """Raise KeyboardInterrupt if Ctrl-C has come since `watch_interrupts`."""
    if _seen:
        raise KeyboardInterrupt


def _on_signal(number: int, frame: object) -> None:
    global _seen
    _seen = True
    raise KeyboardInterrupt
