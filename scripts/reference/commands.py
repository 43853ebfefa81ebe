"""The page of commands, from their argument parsers."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from bringup.cli import parser_of
from bringup.commands import COMMANDS, module_of
from scripts.reference import NOTE, cell, code

_INTRO = f"""# Commands

`python -m bringup COMMAND`, or `arjuna COMMAND`, by the headings of the first page. Every command
has `--help`, which says the same.

{NOTE}
"""


def page() -> str:
    """Return the page."""
    lines = [_INTRO]
    for heading, group in COMMANDS.items():
        lines.append(f"## {heading}\n")
        for name, about in group.items():
            lines += [f"### `{name}`\n", f"{about[0].upper()}{about[1:]}.\n"]
            lines += [*_of(parser_of(name), name), *_examples(name)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _of(parser: argparse.ArgumentParser, name: str) -> Iterator[str]:
    actions = [one for one in parser._actions if one.help != argparse.SUPPRESS]
    rows = [row for one in actions if (row := _row(one))]
    if rows:
        yield "| option | meaning |"
        yield "|---|---|"
        yield from rows
        yield ""
    for action in actions:
        if isinstance(action, argparse._SubParsersAction):
            about = {one.dest: one.help or "" for one in action._choices_actions}
            for word, below in action.choices.items():
                yield f"`{name} {word}`: {cell(about.get(word, ''))}.\n"
                yield from _of(below, f"{name} {word}")


def _row(action: argparse.Action) -> str:
    if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):
        return ""
    values = {**vars(action), "prog": "python -m bringup"}
    about = (action.help or "") % values
    value = _value(action)
    if not action.option_strings:
        return f"| {code(value)} | {cell(about)} |"
    names = ", ".join(code(f"{name} {value}".strip()) for name in action.option_strings)
    return f"| {names} | {cell(about)} |"


def _value(action: argparse.Action) -> str:
    """Return what stands for an argument's value, empty where it takes none."""
    if action.nargs == 0:
        return ""
    if isinstance(action.metavar, tuple):
        return " ".join(action.metavar)
    if action.metavar is None and action.choices is not None:
        name = "|".join(map(str, action.choices))
    else:
        name = action.metavar or (action.dest.upper() if action.option_strings else action.dest)
    count = action.nargs
    if isinstance(count, int):
        return " ".join([name] * count)
    optional = f"[{name}]" if count in ("?", "*", argparse.REMAINDER) else name
    return optional + (" ..." if count in ("*", "+", argparse.REMAINDER) else "")


def _examples(name: str) -> Iterator[str]:
    yield "```"
    yield from (f"python -m bringup {line}" for line in module_of(name).EXAMPLES)
    yield "```"
    yield ""
