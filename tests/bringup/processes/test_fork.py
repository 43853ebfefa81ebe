"""Child processes: forked and ended."""

from __future__ import annotations

import re
import signal
from types import SimpleNamespace

import pytest

from bringup.processes import fork
from tests.helpers.processes import Lines, ended

SUPERVISOR = """
import atexit, os, sys, threading, time
from datetime import datetime
from pathlib import Path
from bringup.processes.child import ChildSpec
from bringup.processes.health import RestartLimits
from bringup.processes.output import StartUp, TextOutput
from bringup.processes.output import RunLog
from bringup.processes.supervisor import StopTimes, Supervisor

def run():
    {0}
    return 0

{1}
command = [sys.executable, "-c", "print('started')", "a word", "x" * 5000]
log = RunLog("test", datetime.now(), Path("/dev/null"))  # where none can be written
output = TextOutput(StartUp([], time.monotonic()), log)
limits = RestartLimits(first_delay=0.01, deaths=2)
spec = ChildSpec("child", command, run=run)
sys.exit(Supervisor([spec], output, limits, StopTimes(0.3, 0.3)).run())
"""
IN_FORK = """
from arjuna_core.errors import ArjunaError
from bringup.processes.fork import in_fork

def refuse(): raise ArjunaError("it will not do")
def err(): raise KeyError("a mistake")

print(in_fork(lambda: {"a": [1, None]}))
try:
    in_fork(refuse)
except ArjunaError as error:
    print("refused:", error)
in_fork(err)
"""
WARM_UP = """
import os, sys
os.environ["OPENBLAS_NUM_THREADS"] = "1"
from bringup.stack import ALL_GROUPS
from bringup.processes.fork import can_fork, warm_up
from bringup.stack import MESSAGES

warm_up(ALL_GROUPS)
cores = [core for group in ALL_GROUPS for core in group.cores]
print("missing:", [name for name in (*MESSAGES, *cores) if name not in sys.modules])
print("rclpy:", "rclpy" in sys.modules, "can fork:", can_fork())
print("groups without:", [group.name for group in ALL_GROUPS if not group.cores])
"""
WAIT = "threading.Event().wait()"


def supervise(run: str, before: str = "") -> Lines:
    """Start a supervisor of a fork that runs a source, after another source."""
    return Lines("-c", SUPERVISOR.format(run, before))


def test_ctrl_c_waits_for_the_end_of_an_import(monkeypatch: pytest.MonkeyPatch) -> None:
    imported: list[str] = []

    def extension(name: str) -> None:
        signal.raise_signal(signal.SIGINT)
        imported.append(name)

    monkeypatch.setattr(fork, "importlib", SimpleNamespace(import_module=extension))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # others' tests leave theirs
    with pytest.raises(KeyboardInterrupt, match=r"^$"):
        fork.warm_up((), ["one", "another"])
    signal.signal(signal.SIGINT, before)
    assert len(imported) == 1


def test_it_has_the_words_it_was_given_to_itself_and_to_ps() -> None:
    source = "print('words', sys.argv, Path('/proc/self/cmdline').read_bytes().split(b'\\0')[1:])"
    with supervise(f"{source}; {WAIT}") as bringup:
        (line,) = bringup.wait_for("[child] words")
        assert line.count("'a word'") == 2
        assert line.count("x" * 5000) == 2
        bringup.process.send_signal(signal.SIGINT)
        assert bringup.read_to_end() == 0


def test_nothing_that_its_parent_has_open_is_open_in_it() -> None:
    source = "print('open', sorted(map(int, os.listdir('/proc/self/fd')))[:-1])"
    with supervise(f"{source}; {WAIT}") as bringup:
        assert bringup.wait_for("[child] open") == ["[child] open [0, 1, 2]"]


def test_its_exception_is_shown_and_it_starts_again() -> None:
    with supervise(
        "{}['a mistake']", "atexit.register(print, 'the end of', os.getpid())"
    ) as bringup:
        assert bringup.read_to_end() == 1
        assert len(bringup.matching("[child] KeyError: 'a mistake'")) == 2
        assert bringup.matching("child died (exit code 1); it starts again")
        assert len(bringup.matching("the end of")) == 1  # the parent's own


def test_a_killed_parent_leaves_no_fork() -> None:
    with supervise(f"print('pid', os.getpid(), flush=True); {WAIT}") as bringup:
        (line,) = bringup.wait_for("[child] pid")
        bringup.process.kill()
        bringup.process.wait()
        assert ended(int(re.sub(r"\D", "", line)))


def test_a_parent_with_threads_starts_the_program() -> None:
    thread = f"threading.Thread(target=lambda: {WAIT}, daemon=True).start()"
    with supervise("print('forked')", thread) as bringup:
        assert bringup.read_to_end() == 1  # for it ends, again and again
        assert bringup.matching("[child] started")
        assert not bringup.matching("[child] forked")


@pytest.mark.parametrize(
    "answer", ["{'a': [1, None]}", "refused: it will not do", "KeyError: 'a mistake'"]
)
def test_work_done_in_a_fork_answers_refuses_or_errs(answer: str) -> None:
    with Lines("-c", IN_FORK) as lines:
        assert lines.read_to_end() == 1
        assert lines.matching(answer)


@pytest.mark.ros
def test_every_group_is_warmed_up_without_rclpy_and_its_threads() -> None:
    pytest.importorskip("rclpy", reason="no ROS here")
    with Lines("-c", WARM_UP) as lines:
        assert lines.read_to_end() == 0
        assert lines.seen == [
            "missing: []",
            "rclpy: False can fork: True",
            "groups without: ['explorer']",  # which runs in its command's own process
        ]
