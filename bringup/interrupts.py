"""Ctrl-C, which Python drops in destructors, and C extensions where they import."""

from __future__ import annotations

import math
import signal
import time

AGAIN = 1.0  # [s] from a signal to the next that is meant: `timeout` and launches send one twice
_seen_at = -math.inf  # [s]


def watch_interrupts() -> None:
    """Keep in mind from now on that Ctrl-C came, beside raising KeyboardInterrupt."""
    global _seen_at
    _seen_at = -math.inf
    signal.signal(signal.SIGINT, _on_signal)


def ignore_interrupts() -> None:
    """Let Ctrl-C have no effect any more: what ends must not be interrupted on its way out."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def check_interrupts() -> None:
    """Raise KeyboardInterrupt if Ctrl-C has come since `watch_interrupts`."""
    if was_interrupted():
        raise KeyboardInterrupt


def was_interrupted() -> bool:
    """Return whether Ctrl-C has come since `watch_interrupts`."""
    return _seen_at > -math.inf


def _on_signal(number: int, frame: object) -> None:
    global _seen_at
    again, _seen_at = time.monotonic() - _seen_at < AGAIN, time.monotonic()
    if not again:
        raise KeyboardInterrupt
