"""Expanding xacro macros, where a robot's file has them."""

from __future__ import annotations

import importlib.util
import json
import re
import shlex
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.errors import ConfigError, RobotError
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.notes import Note, NoteKind

_MARK = b"xmlns:xacro"
_MACRO = re.compile(rb"<xacro:|\$[{(]")
_ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class Expanded:
    """A robot's file after its macros.

    Attributes:
        notes: What was missing, and what stands for it.
        files: The files that it includes.
        off: Its arguments that are false by default, and were not given.
    """

    text: bytes
    notes: tuple[Note, ...] = ()
    files: tuple[Path, ...] = ()
    off: tuple[str, ...] = ()


def has_macros(path: Path, text: bytes) -> bool:
    """Return whether a robot's file has to be expanded."""
    return path.suffix == ".xacro" or (_MARK in text and _MACRO.search(text) is not None)


def parse_arguments(words: list[str]) -> dict[str, str]:
    """Read xacro arguments, each `name:=value`."""
    for word in words:
        if not word.partition(":=")[0].isidentifier() or ":=" not in word:
            raise ConfigError(f"{word!r} is no argument of a robot; valid: name:=value")
    return {name: value for name, _, value in (word.partition(":=") for word in words)}


def split(text: str) -> dict[str, str]:
    """Read xacro arguments written as in a shell, `name:=value 'other:=two words'`.

    Raises:
        ConfigError: A word is no argument, or a quote is not closed.
    """
    try:
        return parse_arguments(shlex.split(text))
    except ValueError as error:
        raise ConfigError(f"'robot_arguments' {text!r}: {error}") from error


def expand(path: Path, search: SearchPath, arguments: Mapping[str, str]) -> Expanded:
    """Expand a robot's macros, in a process of its own whose time and memory are limited.

    What is missing (an include, a package, the value of an argument) is left out and noted.

    Args:
        search: Where `$(find package)` looks, before the folders around the file.

    Raises:
        RobotError: It cannot be expanded.
    """
    if importlib.util.find_spec("xacro") is None:
        problem = "has xacro macros, and the package xacro is not installed; a plain URDF is valid"
        raise RobotError(path, problem)
    request = {
        "path": str(path.resolve()),
        "arguments": dict(arguments),
        "packages": [str(folder.resolve()) for folder in search.packages],
        "models": [str(folder.resolve()) for folder in search.models],
    }
    answer = _ask(path, request)
    if "error" in answer:
        raise RobotError(path, f"xacro cannot expand it: {answer['error']}")
    files = tuple(Path(name) for name in answer["files"])
    notes = tuple(Note(NoteKind(kind), note) for kind, note in answer["notes"])
    return Expanded(answer["text"].encode(), notes, files, tuple(answer["off"]))


def _ask(path: Path, request: dict[str, Any]) -> dict[str, Any]:
    """Have a process expand a file; one that dies has hit a limit."""
    try:
        done = subprocess.run(
            [sys.executable, "-m", "arjuna_sim.files.urdf.xacro_child"],
            cwd=_ROOT,
            input=json.dumps(request).encode(),
            stdout=subprocess.PIPE,
            timeout=20.0,  # [s] of a machine under load: what it computes is limited to 1 s
            start_new_session=True,  # Ctrl-C is for us
        )
    except subprocess.TimeoutExpired as error:
        problem = f"xacro cannot expand it: no end after {error.timeout:g} s"
        raise RobotError(path, problem) from error
    if done.returncode:
        problem = "xacro cannot expand it: it takes more than 1 s of computing, or too much memory"
        raise RobotError(path, problem)
    found: dict[str, Any] = json.loads(done.stdout)
    return found
