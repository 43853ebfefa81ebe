"""`top`: the nodes: state, CPU, rate of the main topic, last warning."""

from __future__ import annotations

import argparse

from bringup.parameters import options

EXAMPLES = ("top",)

_CLEAR = "\033[2J\033[H"


def configure(parser: argparse.ArgumentParser) -> None:
    options.add(parser, *options.ROBOT_CHOICE)
    parser.add_argument(
        "--period",
        type=options.positive,
        default=2.0,
        metavar="S",
        help="from one table to the next [s]",
    )
    parser.add_argument("--count", type=int, metavar="N", help="end after so many tables")


def run(arguments: argparse.Namespace, pipe_width: int = 160) -> int:
    """Show the table until Ctrl-C, or as often as asked; return 1 where no robot ran at the end.

    Into a file or pipe it is so many characters wide.
    """
    import shutil
    import sys
    from contextlib import closing

    from bringup.client.session import Connection
    from bringup.doctor.observer import Watcher
    from bringup.doctor.table import table_text
    from bringup.terminal import show

    remaining, found = arguments.count, []
    with closing(Connection("arjuna_top", arguments.namespace)) as session:
        watcher = Watcher(session)
        while remaining is None or remaining > 0:
            found = watcher.rows(arguments.period)
            live = sys.stdout.isatty()
            width = shutil.get_terminal_size().columns if live else pipe_width
            text = table_text(found, width) if found else "no robot runs; doctor says more"
            show(f"{_CLEAR if live else ''}{text}")
            remaining = None if remaining is None else remaining - 1
    return 0 if found else 1
