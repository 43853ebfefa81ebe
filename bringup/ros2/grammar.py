"""The parser of `ros2`, built from `tables/`: a JSON file for each command, its verbs in it.

An argument has its names in one text, its type as `is`, what the shell completes it with as
`complete`, a key of the completion's `LIVE`, and what else `add_argument` takes. A text stands
for a `shared` argument, or several; those of a list exclude one another.
"""

from __future__ import annotations

import argparse
import builtins
import importlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from arjuna_core.files.input_file import read_json
from bringup.parameters.options import factor, positive

VERBS = "bringup.ros2.verbs"
BUFFERED = "--use-python-default-buffering"
FORWARDED = {
    "component": ("There are no containers: each node is a process", "daemon:component"),
    "daemon": ("There is no daemon: none is needed", "daemon:run"),
    "doctor": ("Check the system for what goes wrong", "doctor:run"),
    "launch": ("Start what a known launch file starts", "launch:run"),
    "run": ("Run a package specific executable", "run:run"),
    "test": ("Run a ROS 2 launch test", "forward:launch_test"),
    "wtf": ("The same as 'ros2 doctor'", "doctor:run"),
}
"""What is said of the commands without verbs, and `module:function` that takes their words."""
_GRAPH: tuple[dict[str, Any], ...] = (
    {
        "name": "--spin-time",
        "is": "float",
        "metavar": "N",
        "help": "seconds to wait for the graph at most",
    },
    {"name": "-s --use-sim-time", "is": "switch", "help": "take the time from /clock"},
    {
        "name": "--no-daemon",
        "is": "switch",
        "help": "accepted for ros2cli's sake: there is no daemon",
    },
)
"""The options of every verb that looks at the graph. Nothing here needs ros2cli's daemon."""


def _from(least: int, problem: str) -> Callable[[str], int]:
    """Return a type of argument: a whole number, not below the least."""

    def count(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(problem)
        return int(text)

    return count


def _readable(text: str) -> str:
    """Return the path of a file that can be read."""
    if not Path(text).is_file():
        raise argparse.ArgumentTypeError(f"can't open '{text}': it is no file")
    return text


_TYPES: dict[str, Callable[[str], float | str]] = {
    "int": int,
    "float": float,
    "from_zero": factor,
    "positive": positive,
    "count": _from(1, "value must be a positive integer"),
    "file": _readable,
    "unsigned": _from(0, "value must be non-negative integer"),
}


def build_parser() -> argparse.ArgumentParser:
    """Return the parser; what it parses has `run`, the `module:function` of the verb, or None."""
    parser = argparse.ArgumentParser(
        prog="ros2",
        description="ros2 is the command-line tool for ROS 2, as Arjuna brings it.",
        epilog="'ros2 --completion bash' (or zsh) prints what makes the shell complete it",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(BUFFERED, action="store_true", help="do not write out every line at once")
    tables: dict[str, Any] = {name: {"about": about} for name, (about, _) in FORWARDED.items()}
    for path in Path(__file__).parent.glob("tables/*.json"):
        tables[path.stem] = read_json(path)
    for command, child in _add_choices(parser, dict(sorted(tables.items()))):
        table = tables[command]
        verbs, shared = table.get("verbs", {}), table.get("shared", {})
        child.set_defaults(run=None, help=child.format_help)
        _add_arguments(child, table.get("arguments", ()), shared)
        for verb, leaf in _add_choices(child, verbs):
            suffix = "_" if hasattr(builtins, verb) else ""
            run = verbs[verb].get("run", f"{command}:{verb}{suffix}")
            leaf.set_defaults(run=run, command=command)
            _add_arguments(leaf, verbs[verb].get("arguments", ()), shared)
            _add_arguments(leaf, _GRAPH if table.get("graph") else (), shared)
    return parser


def _add_choices(
    parser: argparse.ArgumentParser, items: Mapping[str, Any]
) -> list[tuple[str, argparse.ArgumentParser]]:
    """Add a parser for each command or verb and return them; the help lists them as ros2cli's."""
    if not items:
        return []
    width = max(map(len, items))
    choices = parser.add_subparsers(
        title="Commands",
        description="".join(f"{name:{width}}  {one['about']}\n" for name, one in items.items()),
        metavar=f"Call `{parser.prog} <command> -h` for more detailed usage.",
    )
    style = argparse.RawDescriptionHelpFormatter
    return [
        (name, choices.add_parser(name, description=one["about"], formatter_class=style))
        for name, one in items.items()
    ]


def _add_arguments(parser: Any, items: Any, shared: Mapping[str, Any]) -> None:
    for item in items:
        if isinstance(item, str):
            found = shared[item]
            _add_arguments(parser, found if isinstance(found, list) else [found], shared)
        elif isinstance(item, list):
            _add_arguments(parser.add_mutually_exclusive_group(), item, shared)
        else:
            _add_argument(parser, **item)


def _add_argument(parser: Any, name: str, complete: str = "", **options: Any) -> None:
    kind = options.pop("is", "")
    if options.get("default") == argparse.SUPPRESS:
        options["default"] = argparse.SUPPRESS  # argparse wants the very object
    if isinstance(options.get("metavar"), list):
        options["metavar"] = tuple(options["metavar"])
    if kind == "switch":
        options["action"] = "store_true"
    elif kind:
        options["type"] = _TYPES[kind]
    parser.add_argument(*name.split(), **options).complete = complete


def choices_of(parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Yield the names and parsers of the commands, or of a command's verbs."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.items()


def load(run: str) -> Callable[..., int | None]:
    """Import and return the function that a table names as `module:function`."""
    module, function = run.split(":")
    loaded: Callable[..., int | None] = getattr(
        importlib.import_module(f"{VERBS}.{module}"), function
    )
    return loaded
