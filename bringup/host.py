"""Starts a process that hosts a group of nodes: `python -m bringup.host GROUP`."""

from __future__ import annotations

import signal
import sys


def main() -> int:
    """Run a group of nodes; until they are there to end in order, Ctrl-C ends it at once."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # not with a traceback of what it imports
    from bringup.processes.host import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
