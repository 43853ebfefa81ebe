"""`python -m bringup sim|slam|nav|demo`."""

from __future__ import annotations

import sys

from bringup.cli_parser import parse


def main() -> int:
    """Run a command and return its exit code; what it needs is imported only then."""
    arguments = parse()
    from bringup.cli import run

    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())
