"""The command line; argparse only, and only the chosen command's, so that `--help` is instant."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from bringup.commands import COMMANDS, module_of

_FIRST = """Arjuna: a ROS 2 robot to map, localize and navigate with, simulated or real.

New here? Type these, each in a terminal of its own:
  {prog} sim                                drives in its room
  {prog} nav --map maps/arjuna_room.yaml    knows where it is, takes goals"""
_LAST = "Each command has --help with its options."


def parse(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Read the command line.

    Returns:
        `command`, what it runs (`run`; None for the first page, printed by now) and its options.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    parser = _parser(next((word for word in words if not word.startswith("-")), None))
    if not words:
        parser.print_help()
    return parser.parse_args(words)


def parser_of(command: str) -> argparse.ArgumentParser:
    """Return the parser of one command's own options."""
    groups = _parser(command)._subparsers
    assert groups is not None
    chosen: argparse.ArgumentParser = groups._group_actions[0].choices[command]  # type: ignore[index]
    return chosen


def _parser(chosen: str | None) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=_prog(), formatter_class=argparse.RawDescriptionHelpFormatter, usage="%(prog)s COMMAND"
    )
    parser.description = "\n\n".join([_FIRST.format(prog=parser.prog), *map(_page, COMMANDS)])
    parser.epilog = _LAST
    parser.set_defaults(run=None)
    commands = parser.add_subparsers(
        dest="command", metavar="COMMAND", prog=parser.prog, help=argparse.SUPPRESS
    )
    for group in COMMANDS.values():
        for name, about in group.items():
            command = commands.add_parser(name, description=f"{about[0].upper()}{about[1:]}.")
            if name == chosen:
                module = module_of(name)
                module.configure(command)
                command.set_defaults(run=module.run)
                command.formatter_class = argparse.RawDescriptionHelpFormatter
                lines = [f"  {parser.prog} {line}" for line in module.EXAMPLES]
                parts = "\n".join(["examples:", *lines]), command.epilog
                command.epilog = "\n\n".join(filter(None, parts))
    return parser


def _prog() -> str:
    called = sys.argv[0].rsplit("/", maxsplit=1)[-1]
    return called if called == "arjuna" else "python -m bringup"


def _page(heading: str) -> str:
    rows = [f"  {name:14}{about}" for name, about in COMMANDS[heading].items()]
    return "\n".join([f"{heading}:", *rows])
