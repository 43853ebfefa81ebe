"""Output that tests compare: filtered, and with what is expected."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from arjuna_core.files.input_file import read_text
from launch_testing.records import text_matcher


def get_default_filtered_prefixes() -> list[str]:
    """Return the beginnings of lines that tests leave out."""
    return ["pid", "rc"]


def get_default_filtered_patterns() -> list[Any]:
    """Return the patterns of lines that tests leave out."""
    return []


def get_expected_output(output_file: str) -> Any:
    """Return what `NAME.txt` holds, or the pattern of `NAME.regex`, line by line.

    Raises:
        FileNotFoundError: There is neither.
    """
    literal, pattern = (Path(f"{output_file}.{ending}") for ending in ("txt", "regex"))
    if literal.is_file():
        return read_text(literal).splitlines()
    if pattern.is_file():
        return [re.compile(line) for line in read_text(pattern).splitlines()]
    raise FileNotFoundError(f"neither {literal} nor {pattern} is there")


expected_output_from_file = get_expected_output


def basic_output_filter(
    *, filtered_prefixes: Iterable[str] = (), filtered_patterns: Iterable[Any] = ()
) -> Callable[[str], str]:
    """Return what drops lines that begin with a prefix, or that a compiled pattern matches."""
    prefixes, patterns = tuple(filtered_prefixes), list(filtered_patterns)

    def filtered(text: str) -> str:
        return "".join(
            line
            for line in text.splitlines(keepends=True)
            if not line.startswith(prefixes) and not any(one.match(line) for one in patterns)
        )

    return filtered


def expect_output(
    *,
    expected_text: Any = None,
    expected_lines: Any = None,
    text: str | None = None,
    lines: Any = None,
    strict: bool = False,
) -> bool:
    """Return whether a text, or lines, hold what is expected; with `strict` nothing else."""
    expected = expected_text if expected_lines is None else list(expected_lines)
    given = "\n".join(lines) if text is None else text
    if strict and not isinstance(expected, str):
        found = given.splitlines()
        pairs = zip(found, expected, strict=False)
        return len(found) == len(expected) and all(text_matcher(e)(line) for line, e in pairs)
    return given == expected if strict else text_matcher(expected)(given)
