"""The grammar of `ros2`: commands, verbs and arguments as values, and the parser of them."""

from __future__ import annotations

import argparse
import builtins
import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

VERBS = "bringup.ros2.verbs"
BUFFERED = "--use-python-default-buffering"


@dataclass(frozen=True)
class Argument:
    """One argument, as `argparse.ArgumentParser.add_argument` takes it.

    Attributes:
        names: Its flags, or the one name of a positional.
        complete: What the shell completes it with, a key of the completion's `LIVE`.
    """

    names: tuple[str, ...]
    options: Mapping[str, Any]
    complete: str = ""


@dataclass(frozen=True)
class Verb:
    """One verb of a command.

    Attributes:
        arguments: Its arguments; a tuple of them excludes one another.
        run: `module:function` among the verbs, imported only when it runs; by default the
            command's module and the verb's name, with an underscore where Python has that name.
    """

    name: str
    about: str
    arguments: tuple[Argument | tuple[Argument, ...], ...] = ()
    run: str = ""


@dataclass(frozen=True)
class Command:
    """One command.

    Attributes:
        forward: `module:function` that takes all words after the command instead of verbs.
        graph: Whether its verbs look at the graph and so take `GRAPH` too.
    """

    name: str
    about: str
    verbs: tuple[Verb, ...] = ()
    arguments: tuple[Argument, ...] = ()
    forward: str = ""
    graph: bool = False

    def runs(self, verb: Verb) -> str:
        """Return `module:function` of one of its verbs."""
        suffix = "_" if hasattr(builtins, verb.name) else ""
        return verb.run or f"{self.name}:{verb.name}{suffix}"


def switch(names: str, about: str, **options: Any) -> Argument:
    """Return an option that is on or off."""
    return Argument(tuple(names.split()), {"action": "store_true", "help": about, **options})


GRAPH = (
    Argument(
        ("--spin-time",),
        {"type": float, "metavar": "N", "help": "seconds to wait for the graph at most"},
    ),
    switch("-s --use-sim-time", "take the time from /clock"),
    switch("--no-daemon", "accepted for ros2cli's sake: there is no daemon"),
)
"""The options of every verb that looks at the graph. Nothing here needs ros2cli's daemon."""


def build_parser(commands: tuple[Command, ...]) -> argparse.ArgumentParser:
    """Return the parser of the commands that do not forward their words."""
    parser = argparse.ArgumentParser(
        prog="ros2",
        description="ros2 is the command-line tool for ROS 2, as Arjuna brings it.",
        epilog="'ros2 --completion bash' (or zsh) prints what makes the shell complete it",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(BUFFERED, action="store_true", help="do not write out every line at once")
    children = _add_choices(parser, commands)
    for command, child in zip(commands, children, strict=True):
        child.set_defaults(run=None, help=child.format_help)
        _add_arguments(child, command.arguments)
        for verb, leaf in zip(command.verbs, _add_choices(child, command.verbs), strict=True):
            leaf.set_defaults(run=command.runs(verb), command=command.name)
            _add_arguments(leaf, verb.arguments + (GRAPH if command.graph else ()))
    return parser


def _add_choices(
    parser: argparse.ArgumentParser, items: tuple[Command, ...] | tuple[Verb, ...]
) -> list[argparse.ArgumentParser]:
    """Add a parser for each command or verb and return them; the help lists them as ros2cli's."""
    if not items:
        return []
    width = max(len(item.name) for item in items)
    choices = parser.add_subparsers(
        title="Commands",
        description="".join(f"{item.name:{width}}  {item.about}\n" for item in items),
        metavar=f"Call `{parser.prog} <command> -h` for more detailed usage.",
    )
    style = argparse.RawDescriptionHelpFormatter
    return [
        choices.add_parser(item.name, description=item.about, formatter_class=style)
        for item in items
    ]


def _add_arguments(
    parser: argparse.ArgumentParser, arguments: tuple[Argument | tuple[Argument, ...], ...]
) -> None:
    for item in arguments:
        if isinstance(item, Argument):
            parser.add_argument(*item.names, **item.options)
        else:
            group = parser.add_mutually_exclusive_group()
            for one in item:
                group.add_argument(*one.names, **one.options)


def load(run: str) -> Callable[..., int | None]:
    """Import and return the function that a table names as `module:function`."""
    module, function = run.split(":")
    loaded: Callable[..., int | None] = getattr(
        importlib.import_module(f"bringup.ros2.verbs.{module}"), function
    )
    return loaded
