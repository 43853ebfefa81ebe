"""`explore`: drive to the edges of the map until all is seen (beside nav --slam)."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = ("explore", "explore --timeout 300")


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.NODES, *options.ROBOT_CHOICE, "--base-frame")
    options.add(parser, "--timeout", default=1800.0)


def run(arguments: argparse.Namespace) -> int:
    """Explore; return 0 where all was seen, 1 where the time is over."""
    from bringup.parameters.inputs import gather
    from bringup.processes.host import Host
    from bringup.stack import EXPLORER_GROUP
    from bringup.terminal import show

    options.extend_search(arguments)
    host = Host(EXPLORER_GROUP, gather(arguments, ask=True), arguments.namespace)
    host.stop_on_signals()
    done = host.run_until_done(arguments.timeout)
    show("explored" if done else "ended before all was seen")
    return 0 if done else 1
