"""The command line: its parser, and the run of a command, where errors become exit codes.

argparse only, and only the chosen command's, so that `--help` is instant.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from arjuna_core.errors import ArjunaError, closest, interrupted, nearest
from bringup.commands import COMMANDS, module_of
from bringup.interrupts import was_interrupted

_FIRST = """Arjuna: a ROS 2 robot to map, localize and navigate with, simulated or real.

New here? Type these, each in a terminal of its own:
  {prog} sim                                drives in its room
  {prog} nav --map maps/arjuna_room.yaml    knows where it is, takes goals"""
_LAST = "Each command has --help with its options."


class Parser(argparse.ArgumentParser):
    """Says in the first line what is wrong, with the nearest valid word, and the usage below."""

    _unknown: Sequence[str] = ()  # options that it has none of

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Read words as argparse does; one with commands below leaves options to them."""
        words = [word.partition("=")[0] for word in args or () if word.startswith("--")]
        if self._subparsers is None:
            valid = self._option_string_actions
            self._unknown = [w for w in words if not any(name.startswith(w) for name in valid)]
        found, rest = super().parse_known_args(args, namespace)
        if rest and self._unknown:
            self.error("")
        return found, rest

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = action.choices
        if choices is not None and value not in choices:
            near = nearest(str(value), map(str, choices))
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}; {near}")

    def error(self, message: str) -> NoReturn:
        """End with what is wrong; an option that does not exist explains all that follows."""
        if self._unknown:
            word = self._unknown[0]
            near = closest(word, self._option_string_actions)
            message = f"unrecognized arguments: {word}{near}"
        self.exit(2, f"error: {message}\n\n{self.format_usage()}")


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
    parser = Parser(
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


OK, REFUSED, INTERRUPTED = 0, 2, 130
EXTRAS = {
    "gymnasium": "learn",
    "mujoco_warp": "gpu",
    "optuna": "tune",
    "pyarrow": "campaign",
    "ray": "cluster",
    "rerun": "view",
}
"""The modules that not every command needs, and the extra of `make setup` that installs each."""


def run(arguments: argparse.Namespace) -> int:
    """Run a command; return 0 if done or stopped, 1 if it failed, 2 if it refuses an input."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if arguments.run is None:
        return OK
    if vars(arguments).get("domain_id") is not None:
        os.environ["ROS_DOMAIN_ID"] = str(arguments.domain_id)
    try:
        return int(arguments.run(arguments))
    except ArjunaError as error:
        sys.stderr.write(f"error: {error}\n")
    except ModuleNotFoundError as error:
        sys.stderr.write(f"error: {_lacking(error.name or '')}\n")
    except (KeyboardInterrupt, ImportError, SystemError) as error:
        if not interrupted(error) and not was_interrupted():
            raise
        sys.stderr.write("\nstopped\n")
        return INTERRUPTED
    return REFUSED


def _lacking(module: str) -> str:
    """Return what to say of a module that is not there, with the words that install it."""
    extra = EXTRAS.get(module.partition(".")[0])
    if extra is None:
        return f"the module {module} is not installed; run 'make setup'"
    return (
        f"the module {module} is not installed; run 'make setup EXTRAS={extra}',"
        " or 'make setup' for all there is"
    )
