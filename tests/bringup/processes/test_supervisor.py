"""The supervisor, with small processes in place of the robot's."""

from __future__ import annotations

import re
import signal

import pytest

from tests.helpers.processes import Lines, ended

ORCHESTRATOR = """
import sys, time
from datetime import datetime
from pathlib import Path
from bringup.processes.child import ChildSpec
from bringup.processes.health import RestartLimits
from bringup.processes.output import StartUp, TextOutput
from bringup.processes.output import RunLog
from bringup.processes.supervisor import StopTimes, Supervisor

specs = [
    ChildSpec(f"c{n}", [sys.executable, "-c", s], needed=not s.startswith("#"))
    for n, s in enumerate(sys.argv[1:])
]
limits = RestartLimits(first_delay=0.01, deaths=3)
log = RunLog("test", datetime.now(), Path("/dev/null"))  # where none can be written
output = TextOutput(StartUp([], time.monotonic()), log)
sys.exit(Supervisor(specs, output, limits, StopTimes(1.0, 0.3)).run())
"""
READY = "import os, signal, threading; {0}; print('pid', os.getpid()); threading.Event().wait()"
OBEDIENT = READY.format("signal.signal(signal.SIGTERM, signal.SIG_DFL)")
STUBBORN = READY.format(
    "[signal.signal(s, signal.SIG_IGN) for s in (signal.SIGINT, signal.SIGTERM)]"
)
SLOW = (
    "import os, signal, sys, threading\n"
    "def end(*_):\n"
    " print('ending', flush=True); threading.Event().wait(0.2); sys.exit('ended well')\n"
    "signal.signal(signal.SIGINT, end); print('pid', os.getpid(), flush=True); signal.pause()"
)
ALIVE = "from bringup.processes.output import event_line; print(event_line(alive={0}));"
STOPPED = (
    ALIVE.format(0.3) + "import os, signal; print('pid', os.getpid(), flush=True);"
    "os.kill(os.getpid(), signal.SIGSTOP)"
)
BUSY = (
    "import faulthandler, os; faulthandler.enable();"
    + ALIVE.format(0.3)
    + "print('pid', os.getpid(), flush=True)\nwhile True: pass"
)
SINGLE_SHOT = "print('pid', __import__('os').getpid()); raise SystemExit({0})"


def supervise(*sources: str) -> Lines:
    """Start a supervisor with a process for each source."""
    return Lines("-c", ORCHESTRATOR, *sources)


def pids(orchestrator: Lines, count: int, mark: str = "pid ") -> list[int]:
    """Return the ids that the processes under supervision say."""
    found = [re.search(r"pid (\d+)", line) for line in orchestrator.wait_for(mark, count)]
    return [int(match[1]) for match in found if match]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_all_processes_and_the_exit_code_is_0(number: signal.Signals) -> None:
    with supervise(OBEDIENT, OBEDIENT) as orchestrator:
        children = pids(orchestrator, 2)
        orchestrator.process.send_signal(number)
        assert orchestrator.read_to_end() == 0
        assert all(ended(pid) for pid in children)


def test_a_signal_that_comes_twice_at_once_skips_nothing() -> None:
    with supervise(SLOW) as orchestrator:
        pids(orchestrator, 1)
        orchestrator.process.send_signal(signal.SIGTERM)
        orchestrator.wait_for("ending")
        orchestrator.process.send_signal(signal.SIGTERM)
        assert orchestrator.read_to_end() == 0
        assert orchestrator.matching("ended well")
        assert not orchestrator.matching("did not end on")


def test_a_process_that_ignores_sigint_and_sigterm_is_killed() -> None:
    with supervise(STUBBORN) as orchestrator:
        (child,) = pids(orchestrator, 1)
        orchestrator.process.send_signal(signal.SIGINT)
        assert orchestrator.read_to_end() == 0
        assert ended(child)
        ignored = orchestrator.matching("did not end on")
        assert [line.rsplit(" ", 1)[1] for line in ignored] == ["SIGINT", "SIGTERM"]


@pytest.mark.parametrize("source", [OBEDIENT, STUBBORN])
def test_a_killed_orchestrator_leaves_no_orphan(source: str) -> None:
    with supervise(source, source) as orchestrator:
        children = pids(orchestrator, 2)
        orchestrator.process.kill()
        orchestrator.process.wait()
        assert all(ended(pid) for pid in children)


def test_what_a_dead_process_left_behind_is_killed() -> None:
    parent = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', sys.argv[1]])"
    source = f"import sys; sys.argv.append({STUBBORN!r}); {parent}; input()"
    with supervise(source) as orchestrator:
        (grandchild,) = pids(orchestrator, 1)
        orchestrator.process.send_signal(signal.SIGINT)
        orchestrator.read_to_end()
        assert ended(grandchild)


def test_a_process_that_dies_starts_again_and_its_lines_carry_its_name() -> None:
    with supervise(OBEDIENT, SINGLE_SHOT.format(7)) as orchestrator:
        orchestrator.wait_for("[c1] pid ", 3)
        deaths = orchestrator.wait_for("c1 died (exit code 7)", 3)
        assert "starts again in 0.01 s" in deaths[0]
        assert "starts again in 0.02 s" in deaths[1]


def test_a_process_that_keeps_dying_ends_everything_with_exit_code_1() -> None:
    with supervise(OBEDIENT, SINGLE_SHOT.format(7)) as orchestrator:
        (child,) = pids(orchestrator, 1, "[c0] pid ")
        assert orchestrator.read_to_end() == 1
        assert orchestrator.matching("c1 died (exit code 7) and it dies again and again: giving up")
        assert len(orchestrator.matching("[c1] pid ")) == 3
        assert ended(child)


def test_what_refuses_its_input_is_not_started_again_and_its_last_words_are_shown() -> None:
    with supervise("import sys; sys.stderr.write('no line end'); sys.exit(2)") as orchestrator:
        assert orchestrator.read_to_end() == 1
        assert len(orchestrator.matching("[c0] no line end")) == 1
        assert orchestrator.matching("refused its input: giving up")


def test_a_process_killed_by_a_signal_is_named_with_it() -> None:
    with supervise("import os; os.kill(os.getpid(), 11)") as orchestrator:
        orchestrator.wait_for("c0 died (SIGSEGV)")


def test_a_process_that_quits_on_purpose_ends_all_with_exit_code_0() -> None:
    with supervise(OBEDIENT, SINGLE_SHOT.format(3)) as orchestrator:
        assert orchestrator.read_to_end() == 0
        assert orchestrator.matching("c1 quit, and so do all")


def test_the_others_continue_without_a_process_that_is_not_needed() -> None:
    with supervise(OBEDIENT, "# not needed\n" + SINGLE_SHOT.format(2)) as orchestrator:
        orchestrator.wait_for("it refused its input: giving up")
        pids(orchestrator, 2)
        orchestrator.process.send_signal(signal.SIGINT)
        assert orchestrator.read_to_end() == 0


@pytest.mark.parametrize("source", [STOPPED, BUSY], ids=["stopped", "busy"])
def test_a_process_that_no_longer_answers_is_ended_and_started_again(source: str) -> None:
    with supervise(source) as orchestrator:
        first, second = pids(orchestrator, 2)
        assert first != second
        assert ended(first)
        assert orchestrator.matching("c0 has not answered for")
        assert orchestrator.matching("c0 died (SIGABRT)")
        assert bool(orchestrator.matching("most recent call first")) == (source == BUSY)
        orchestrator.process.send_signal(signal.SIGINT)
        assert orchestrator.read_to_end() == 0


def test_a_process_that_lives_is_left_alone() -> None:
    lively = ALIVE.format(60.0) + OBEDIENT
    with supervise(lively, STOPPED) as orchestrator:
        pids(orchestrator, 3)  # the other one has started again
        assert len(orchestrator.matching("[c0] pid")) == 1
