"""Everything that SECURITY.md promises, attacked in one run: a table, and failure by any row."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, redirect_stdout
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError
from tests.bench import fuzz, messages

ROOT = Path(__file__).resolve().parents[2]
_TEST_DEADLINE = 300.0  # [s, wall] of the tests of a row
_TESTS = {
    "files": ("no file, bombs, holes x readers", "tests/fuzz/test_attacks.py"),
    "models": ("hostile robots, worlds, meshes", "tests/fuzz/test_models.py"),
    "doors": ("files opened in another way", "tests/core/test_door.py"),
    "sockets": ("sockets beyond 127.0.0.1", "tests/nodes/core/test_process.py"),
    "client": ("what a client once ended a robot with", "tests/system/test_hostile_client.py"),
    "extremes": (
        "numbers at their bounds, a goal after",
        "tests/system/test_parameter_extremes.py",
    ),
}


class BreachError(ArjunaError):
    """A row is not within its bar."""


@dataclass(frozen=True)
class Row:
    """The result of one kind of attack.

    Attributes:
        bar: What was to come.
        held: Whether it did; None where this machine cannot try.
        seconds: It took [s, wall].
    """

    what: str
    count: str
    bar: str
    held: bool | None
    seconds: float = 0.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--only", nargs="+", choices=_rows(), default=list(_rows()), help="rows")
    parser.add_argument("--sessions", type=int, default=200, help="of transforms (%(default)s)")
    parser.add_argument("--messages", type=int, default=2000, help="of noise (%(default)s)")
    parser.add_argument("--seconds", type=float, default=60.0, help="of changed files (60)")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Run each attack.

    Returns:
        Of each row what was done, the `count`, the `bar`, whether it `held` (None where this
        machine cannot try it) and its `seconds`.

    Raises:
        BreachError: A row is not within its bar.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity.FATAL)
    rows: dict[str, Row] = {}
    for name in arguments.only:
        started = time.monotonic()
        with redirect_stdout(sys.stderr):  # their progress
            row = _rows()[name](arguments)
        rows[name] = row = replace(row, seconds=time.monotonic() - started)
        verdict = {True: "held", False: "FAILED", None: "not tried"}[row.held]
        print(f"{name:11}{row.what:42}{verdict:10}{row.seconds:5.0f} s  {row.count} ({row.bar})")
    failed = [name for name, row in rows.items() if row.held is False]
    held = sum(row.held is True for row in rows.values())
    print(f"{held} of {len(rows)} held, {sum(row.seconds for row in rows.values()):.0f} s")
    if failed:
        raise BreachError(f"not within the bar: {', '.join(failed)}")
    return {name: asdict(row) for name, row in rows.items()}


def _rows() -> dict[str, Callable[[argparse.Namespace], Row]]:
    tests = {name: partial(_tests, *one) for name, one in _TESTS.items()}
    return {
        "forged": _forged,
        "paths": _paths,
        "transforms": _transforms,
        "messages": _messages,
        "fuzz": _fuzz,
        **tests,
    }


def _forged(arguments: argparse.Namespace) -> Row:
    """Announce a participant of another host, to a robot as it is and to one that is open."""
    from tests.fuzz.forged import attack

    what, bar = "forged participant of another host", "0, and some of an open one"
    closed, opened = attack(""), attack("SUBNET")
    if isinstance(closed, str) or isinstance(opened, str):
        return Row(what, str(closed), bar, None)
    return Row(what, f"{closed} answers, {opened} of an open robot", bar, closed == 0 < opened)


def _paths(arguments: argparse.Namespace) -> Row:
    """Set every parameter that is a path, of every node, as a client does."""
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged, shipped_parameters
    from bringup.stack import SIM_GROUP
    from tests.fuzz.barrage import STACKS
    from tests.helpers.robots import ON_MAP

    answers: dict[str, bool] = {}
    for groups in STACKS.values():
        with closing(LockStep(merged(shipped_parameters(), ON_MAP))) as robot:
            robot.start(SIM_GROUP, *groups)
            for node in robot.nodes.values():
                answers |= _set_paths(robot, node)
    accepted = [name for name, taken in answers.items() if taken]
    count = f"{len(accepted)} of {len(answers)} accepted {' '.join(accepted)}".strip()
    return Row("paths set by a client", count, "0", len(answers) > 15 and not accepted)


def _set_paths(robot: Any, node: Any) -> dict[str, bool]:
    """Ask a node to take another path for each that it has; return whether it did, by name."""
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    from tests.bringup.parameters.test_checking import PATH

    values = {Parameter.Type.STRING: "/", Parameter.Type.STRING_ARRAY: ["/"]}
    name, answers = node.get_fully_qualified_name(), {}
    for key, known in sorted(node._parameters.items()):
        if known.type_ in values and PATH.search(key):
            other = Parameter(key, value=values[known.type_]).to_parameter_msg()
            request = SetParameters.Request(parameters=[other])
            answer = robot.call(SetParameters, f"{name}/set_parameters", request)
            answers[f"{name} {key}"] = bool(answer.results[0].successful)
    return answers


def _transforms(arguments: argparse.Namespace) -> Row:
    """Send hostile transforms, session after session, and a goal after each."""
    from tests.fuzz.transforms import Sessions

    sessions = Sessions()
    missed = sessions.run(range(arguments.seed, arguments.seed + arguments.sessions))
    reached = arguments.sessions - len(missed)
    count = f"{reached} of {arguments.sessions}, {sessions.refused} refused {' '.join(missed)}"
    return Row("hostile transforms, a goal after each", count, "all", not missed)


def _messages(arguments: argparse.Namespace) -> Row:
    given = argparse.Namespace(count=arguments.messages, seed=arguments.seed)
    found = messages.run(given)
    kinds = ("died", "timed_out", "goals_missed", "failed")
    bad = ", ".join(f"{len(found[kind])} {kind}" for kind in kinds)
    count = f"{found['sent']} sent, {found['refused']} refused, {bad}"
    held = not any(found[kind] for kind in kinds)
    return Row("random messages, requests, transitions", count, "0 of each", held)


def _fuzz(arguments: argparse.Namespace) -> Row:
    given = argparse.Namespace(
        seconds=arguments.seconds, seed=arguments.seed, count=None, only=(), keep=None
    )
    found = fuzz.run(given)
    count = f"{found['inputs']} files, {len(found['findings'])} findings"
    return Row("changed files x readers", count, "0 findings", not found["findings"])


def _tests(what: str, path: str, arguments: argparse.Namespace) -> Row:
    """Run the tests that hold a promise, each attack a test."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", path]
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=os.environ,
            capture_output=True,
            text=True,
            timeout=_TEST_DEADLINE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Row(what, f"no end within {_TEST_DEADLINE:.0f} s", "all pass", False)
    lines = done.stdout.strip().splitlines() or ["nothing"]
    failed = [line.split("::")[-1] for line in lines if line.startswith(("FAILED", "ERROR"))]
    passed = re.search(r"(\d+) passed", lines[-1])
    count = " ".join([lines[-1].split(" in ")[0], *failed])
    return Row(what, count, "all pass", done.returncode == 0 and passed is not None)
