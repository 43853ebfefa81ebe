"""Runs `ros2` commands, each in a process of its own that is forked with all modules loaded.

In one process, a new participant replaces the last and is not discovered for seconds.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from tests.helpers.processes import DEADLINE

_CONTEXT = multiprocessing.get_context("forkserver")
_VERBS = ("echo", "goal", "interface", "lifecycle", "names", "node", "param", "send")
_CONTEXT.set_forkserver_preload([f"bringup.ros2.verbs.{name}" for name in _VERBS])


class Outcome(NamedTuple):
    """A command's exit code and output."""

    code: int
    out: str
    err: str


def run_ros2(words: list[str], folder: Path, environment: Mapping[str, str]) -> Outcome:
    """Run a command to its end.

    Args:
        words: What stands after `ros2`.
        environment: What its environment has beside this process's.
    """
    out, err = folder / "out", folder / "err"
    arguments = (words, str(out), str(err), dict(environment))
    process = _CONTEXT.Process(target=_child, args=arguments)
    process.start()
    process.join(DEADLINE)
    assert process.exitcode is not None, f"{words} did not end; {out.read_text()}"
    return Outcome(process.exitcode, out.read_text(), err.read_text())


def _child(words: list[str], out: str, err: str, environment: dict[str, str]) -> None:
    for path, descriptor in ((out, 1), (err, 2)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), descriptor)
    os.environ.update(environment)
    from bringup.ros2.main import main
    from bringup.ros2.verbs.forward import LAUNCHED

    os.environ.pop(LAUNCHED, None)  # a test of `launch` leaves it: it waits 20 s for who may start
    sys.exit(main(words))
