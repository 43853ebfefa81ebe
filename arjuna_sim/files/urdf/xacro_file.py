"""Expanding xacro macros, where a robot's file has them."""

from __future__ import annotations

import atexit
import importlib.util
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from select import select
from threading import Lock
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
        "environment": dict(os.environ),
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
        answer = EXPANDER.ask(json.dumps(request).encode())
    except TimeoutError as error:
        raise RobotError(path, f"xacro cannot expand it: {error}") from error
    if not answer.strip():
        problem = "xacro cannot expand it: it takes more than 1 s of computing, or too much memory"
        raise RobotError(path, problem)
    found: dict[str, Any] = json.loads(answer)
    return found


class Expander:
    """A process that has imported xacro and forks for each file; it ends with ours.

    Attributes:
        patience: For a fork that waits; one that computes is stopped by its own limit [s].
    """

    def __init__(self) -> None:
        self.patience, self._lock = 20.0, Lock()
        # By our own: a fork of ours does not share the pipes.
        self._processes: dict[int, subprocess.Popen[bytes]] = {}

    def ask(self, request: bytes) -> bytes:
        """Return the answer to a request, a line; none of one that has hit a limit.

        Raises:
            TimeoutError: There is no answer in time.
        """
        with self._lock:
            process, answer = self.process, b""
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                process.stdin.write(request + b"\n")
                process.stdin.flush()
                if not select([process.stdout], [], [], self.patience)[0]:
                    raise TimeoutError(f"no end after {self.patience:g} s")
                answer = process.stdout.readline()
            except BrokenPipeError:  # it was killed
                pass
            finally:
                if not answer:  # what it says later answers no other request
                    self.close()
            return answer

    @property
    def process(self) -> subprocess.Popen[bytes]:
        """The process; it is started where it does not run."""
        process = self._processes.get(os.getpid())
        if process is None or process.poll() is not None:
            process = subprocess.Popen(
                [sys.executable, "-m", "arjuna_sim.files.urdf.xacro_child"],
                cwd=_ROOT,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C is for us
            )
            self._processes[os.getpid()] = process
        return process

    def close(self) -> None:
        """End the process and its fork, if there is one."""
        process = self._processes.pop(os.getpid(), None)
        if process is None:
            return
        with process:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


EXPANDER = Expander()
atexit.register(EXPANDER.close)
