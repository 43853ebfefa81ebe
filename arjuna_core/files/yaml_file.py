"""YAML files read safely, with one error for all that can be wrong with them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.whole_file import read_bytes

_LARGEST = 2**20  # [bytes]
_DEEPEST = 50
_MOST = 200_000  # values, those that aliases stand for too
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_yaml(path: Path, error: type[InputFileError] = InputFileError) -> Any:
    """Return a YAML file's content.

    Raises:
        InputFileError: It cannot be read or is no YAML; of the kind given as `error`.
    """
    try:
        return plain(read_bytes(path, _LARGEST, error).decode("utf-8"))
    except UnicodeDecodeError as reason:
        raise error(path, "is no UTF-8 text") from reason
    except yaml.YAMLError as reason:
        raise error(path, *_described(reason)) from reason


def read_nodes(path: Path) -> yaml.Node | None:
    """Return the nodes of a YAML file that `read_yaml` reads, each with its line."""
    return yaml.compose(read_bytes(path, _LARGEST, InputFileError).decode("utf-8"), Loader=_LOADER)


def plain(text: str) -> Any:
    """Return what a YAML text says, in values of Python's own types.

    Raises:
        yaml.YAMLError: It is no YAML, is nested too deeply, grows too large by its aliases, or
            holds a value that cannot be.
    """
    _check_growth(yaml.parse(text, Loader=_LOADER))
    try:
        return yaml.load(text, Loader=_LOADER)  # noqa: S506 - a safe one
    except (ValueError, OverflowError) as error:  # as of the date 2000-99-99
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


def _described(reason: yaml.YAMLError) -> tuple[str, str]:
    if isinstance(reason, yaml.MarkedYAMLError) and reason.problem_mark is not None:
        mark = reason.problem_mark
        return f"is no YAML: {reason.problem}", f"line {mark.line + 1}, column {mark.column + 1}"
    return f"is no YAML: {' '.join(str(reason).split())}", "text"
