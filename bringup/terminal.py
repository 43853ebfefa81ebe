"""Lines for the person at the terminal, and the end that it asks for."""

from __future__ import annotations

import os
import signal
import sys
import threading


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
