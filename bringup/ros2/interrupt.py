"""Ctrl-C that is not lost where Python drops an exception: in destructors and weak references."""

from __future__ import annotations

import signal

_seen = False


def watch() -> None:
    """Keep in mind from now on that Ctrl-C came, beside raising KeyboardInterrupt."""
    global _seen
    _seen = False
    signal.signal(signal.SIGINT, _on_signal)


def check() -> None:
    """Raise KeyboardInterrupt if Ctrl-C has come since `watch`."""
    if _seen:
        raise KeyboardInterrupt


def _on_signal(number: int, frame: object) -> None:
    global _seen
    _seen = True
    raise KeyboardInterrupt
