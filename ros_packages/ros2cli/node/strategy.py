"""The node that a command has: here always one of its own, as there is no daemon to ask."""

from __future__ import annotations

import argparse

from ros2cli.node.direct import DirectNode


class NodeStrategy(DirectNode):
    """A hidden node; a context manager."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--spin-time", type=float, help="how long to look about [s]")
    parser.add_argument("-s", "--use-sim-time", action="store_true", help="accepted")
    parser.add_argument("--no-daemon", action="store_true", help="accepted: there is none")
