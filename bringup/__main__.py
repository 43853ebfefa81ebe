"""`python -m bringup sim|slam|nav|demo`."""

from __future__ import annotations

import gc
import os
import signal
import sys


def main() -> int:
    """Run a command and return its exit code; what it needs is imported only then."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads only wait, on small matrices
    gc.set_threshold(100_000, 20, 20)  # imports leave none; to look takes a fifth of their time
    try:
        from bringup.interrupts import check_interrupts, watch_interrupts

        watch_interrupts()
        from bringup.cli import parse, run

        arguments = parse()
        check_interrupts()
        arguments.main = main  # for commands that run others in forks of this process
        return run(arguments)
    except KeyboardInterrupt:  # while it imports; commands that run have handlers of their own
        return 128 + signal.SIGINT  # as POSIX shells report it


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that what was started ends too
    sys.exit(main())
