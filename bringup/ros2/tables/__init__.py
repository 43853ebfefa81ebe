"""The commands of `ros2`: a JSON file for each has its verbs and arguments.

An argument has its names in one text, its type as `is`, and what else `add_argument` takes, but for
`complete`. A text stands for a `shared` argument, or several; those of a list exclude one another.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from arjuna_core.files.input_file import read_json
from bringup.parameters.options import factor, positive
from bringup.ros2.grammar import Argument, Command, Verb, switch

_FORWARDED = (
    Command("daemon", "There is no daemon: none is needed", forward="forward:daemon"),
    Command("doctor", "Check the system for what goes wrong", forward="forward:doctor"),
    Command("launch", "Start what a known launch file starts", forward="launch:run"),
    Command("run", "Run a package specific executable", forward="forward:run"),
    Command("wtf", "The same as 'ros2 doctor'", forward="forward:doctor"),
)


def _from(least: int, problem: str) -> Callable[[str], int]:
    """Return a type of argument: a whole number, not below the least."""

    def count(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(problem)
        return int(text)

    return count


_TYPES: dict[str, Callable[[str], float]] = {
    "int": int,
    "float": float,
    "from_zero": factor,
    "positive": positive,
    "count": _from(1, "value must be a positive integer"),
    "unsigned": _from(0, "value must be non-negative integer"),
}


def _argument(given: dict[str, Any]) -> Argument:
    options: dict[str, Any] = {
        k: tuple(v) if k == "metavar" and isinstance(v, list) else v for k, v in given.items()
    }
    names, kind = options.pop("name"), options.pop("is", "")
    if options.get("default") == argparse.SUPPRESS:
        options["default"] = argparse.SUPPRESS  # argparse wants the very object
    if kind == "switch":
        return switch(names, options.pop("help"), **options)
    if kind:
        options["type"] = _TYPES[kind]
    return Argument(tuple(names.split()), options, options.pop("complete", ""))


def _arguments(
    items: list[Any], shared: dict[str, Any]
) -> Iterator[Argument | tuple[Argument, ...]]:
    for item in items:
        if isinstance(item, str):
            found = shared[item]
            yield from _arguments(found if isinstance(found, list) else [found], shared)
        else:
            yield _argument(item) if isinstance(item, dict) else tuple(map(_argument, item))


def _command(path: Path) -> Command:
    table = read_json(path)
    shared = table.get("shared", {})
    verbs = (
        Verb(
            name,
            one["about"],
            tuple(_arguments(one.get("arguments", []), shared)),
            one.get("run", ""),
        )
        for name, one in table["verbs"].items()
    )
    own = tuple(map(_argument, table.get("arguments", [])))
    graph = table.get("graph", False)
    return Command(path.stem, table["about"], tuple(verbs), own, graph=graph)


_OWN = map(_command, Path(__file__).parent.glob("*.json"))
COMMANDS = tuple(sorted((*_OWN, *_FORWARDED), key=lambda command: command.name))
