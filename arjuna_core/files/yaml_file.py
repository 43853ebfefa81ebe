"""YAML files read safely, with one error for all that can be wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.errors import InputFileError, nearest, shortened
from arjuna_core.files.input_file import read_text

_DEEPEST = 50
_MOST = 200_000  # values, those that aliases stand for too
_SAFE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_TAG = "tag:yaml.org,2002:"


class _Loader(_SAFE):
    """Makes values of the kinds that ROS' own files have; a date is the text that it is."""

    yaml_constructors = {  # noqa: RUF012 - as PyYAML has it
        tag: make
        for tag, make in _SAFE.yaml_constructors.items()
        if tag not in {f"{_TAG}{kind}" for kind in ("binary", "omap", "pairs", "set")}
    }

    def construct_integer(self, node: yaml.ScalarNode) -> int:
        """Return a whole number of 64 bits, as ROS has them."""
        number = int(self.construct_yaml_int(node))
        if not -(2**63) <= number < 2**64:
            raise ValueError(f"{shortened(node.value, 40)}, a whole number of more than 64 bits")
        return number


_Loader.add_constructor(f"{_TAG}int", _Loader.construct_integer)
_Loader.add_constructor(f"{_TAG}timestamp", _SAFE.construct_scalar)
# 1e-9 is a number for rcl, which reads YAML 1.2
_EXPONENT = re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+$")
_Loader.add_implicit_resolver(f"{_TAG}float", _EXPONENT, list("-+0123456789"))


def read_yaml(path: Path, error: type[InputFileError] = InputFileError) -> Any:
    """Return a YAML file's content.

    Raises:
        InputFileError: It cannot be read or is no YAML; of the kind given as `error`.
    """
    text = read_text(path, error=error)
    try:
        return plain(text)
    except yaml.YAMLError as reason:
        raise error(path, *_described(reason, text)) from reason


def check_keys(
    path: Path,
    content: Any,
    valid: Sequence[str],
    needed: Iterable[str],
    error: type[InputFileError] = InputFileError,
    empty: bool = False,
) -> None:
    """Refuse a file's content that is no mapping of valid keys, or lacks one that is needed.

    Args:
        empty: Whether what is needed may be there without a value.

    Raises:
        InputFileError: All wrong and missing keys; of the kind given as `error`.
    """
    if not isinstance(content, dict):
        raise error(path, f"is no mapping; valid keys: {', '.join(valid)}")
    problems = [f"'{key}': {nearest(str(key), valid)}" for key in content if key not in valid]
    given = content if empty else {key for key, value in content.items() if value}
    problems += [f"'{key}' is missing" for key in needed if key not in given]
    if problems:
        raise error(path, "; ".join(problems))


def read_nodes(path: Path) -> yaml.Node | None:
    """Return the nodes of a YAML file that `read_yaml` reads, each with its line."""
    return yaml.compose(read_text(path), Loader=_Loader)


def plain(text: str) -> Any:
    """Return what a YAML text says, in values of Python's own types.

    Raises:
        yaml.YAMLError: It is no YAML, is nested too deeply, grows too large by its aliases, or
            holds a value that cannot be.
    """
    _check_growth(yaml.parse(text, Loader=_Loader))
    try:
        return yaml.load(text, Loader=_Loader)  # noqa: S506 - a safe one
    except (ValueError, LookupError, OverflowError) as error:  # as of `!!int x` and `!!bool x`
        raise yaml.YAMLError(f"holds a value that cannot be: {error}") from error


def _check_growth(events: Iterable[Any]) -> None:
    """Refuse what is nested too deeply, or would not end once its aliases are followed."""
    opened: list[tuple[str | None, int]] = []
    sizes: dict[str | None, int] = {}
    count = 0
    for event in events:
        if isinstance(event, yaml.AliasEvent):
            if event.anchor in (anchor for anchor, _ in opened):
                raise yaml.YAMLError(f"*{event.anchor} stands in itself")
            count += sizes.get(event.anchor, 0)
        elif isinstance(event, yaml.CollectionStartEvent):
            opened.append((event.anchor, count))
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, before = opened.pop()
            sizes[anchor] = count - before
        count += 1
        if len(opened) > _DEEPEST:
            raise yaml.YAMLError(f"is nested deeper than {_DEEPEST} levels")
        if count > _MOST:
            raise yaml.YAMLError(f"holds more than {_MOST} values")


def _described(reason: yaml.YAMLError, text: str) -> tuple[str, str]:
    if isinstance(reason, yaml.MarkedYAMLError) and reason.problem_mark is not None:
        mark, problem = reason.problem_mark, str(reason.problem)
        line = "".join(text.splitlines()[mark.line : mark.line + 1])
        if line[mark.column :].startswith("\t"):
            problem = "a tab indents; valid: spaces"
        return f"is no YAML: {problem}", f"line {mark.line + 1}, column {mark.column + 1}"
    return f"is no YAML: {' '.join(str(reason).split())}", "text"
