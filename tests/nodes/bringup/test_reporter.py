"""Claims: a process says how long it will be silent, also where Numba has to compile."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numba
import pytest

from bringup.processes.health import PATIENCE
from bringup.processes.output import read_event
from bringup.processes.reporter import Reporter
from tests.helpers.ros import RosBench


@pytest.fixture
def lines() -> list[str]:
    return []


@pytest.fixture
def reporter(lines: list[str]) -> Iterator[Reporter]:
    bench = RosBench()
    yield Reporter(bench.process, [], lines.append)
    bench.close()


def patience(lines: list[str]) -> list[float]:
    """Return within what times the next signs of life were announced [s]."""
    events = [read_event(line) or {} for line in lines]
    return [event["alive"] for event in events if "alive" in event]


def compile_again() -> None:
    """Let Numba compile a function that it has not seen."""
    compiled: Any = numba.njit(lambda: 0)
    compiled()


def test_a_compilation_is_announced_and_the_next_sign_of_life_ends_it(
    reporter: Reporter, lines: list[str]
) -> None:
    reporter.update(1.0)
    compile_again()
    assert max(patience(lines)) == 90.0
    reporter.update(1.2)
    assert patience(lines)[-1] == PATIENCE == 6.0  # as SECURITY.md promises
    reporter.close()


def test_nothing_is_said_after_the_end(reporter: Reporter, lines: list[str]) -> None:
    reporter.close()
    compile_again()
    assert not lines
