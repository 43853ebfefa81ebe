"""Pools that run a campaign's runs: one Protocol, this machine's processes, their progress."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from arjuna_core.config import dotted
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from bringup.campaign.outcome import Outcome, figures_of, judged
from bringup.campaign.plan import Campaign, Run
from bringup.processes.child import Child, ChildSpec, describe_exit
from bringup.processes.fork import warm_up
from bringup.stack import Group
from bringup.terminal import Bar, show

PROGRAM = (sys.executable, "-m", "bringup")
"""The program that takes the words of a run."""
LOG = "log.txt"
"""The file in a run's folder that has its output."""
_POLL = 0.1  # [s] from one look at the running processes to the next
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Job:
    """A run to do, and the folder of its own that its files come to lie in."""

    campaign: Campaign
    run: Run
    folder: Path


@dataclass(frozen=True)
class Ended:
    """A job that ended: its outcome, or None and the cause where its worker died meanwhile."""

    job: Job
    outcome: Outcome | None
    cause: str = ""


class Pool(Protocol):
    """A pool that runs; it neither plans them nor records their outcomes."""

    @property
    def slots(self) -> int:
        """The number of runs that can run at a time."""

    @property
    def capacity(self) -> int:
        """The most runs to have started, with those that wait for a slot."""

    def start(self, job: Job) -> None:
        """Start a run, or queue it.

        Raises:
            ArjunaError: No part of the pool can do it.
            OSError: Its folder cannot be written.
        """

    def ended(self, timeout: float) -> list[Ended]:
        """Return the jobs that ended, waiting for the first at most some time [s]."""

    def stop(self) -> None:
        """End the runs in progress."""


@dataclass(frozen=True)
class Forks:
    """Runs in forks of this process, which need not import all that they stand on.

    Attributes:
        main: Does a run, its words in `sys.argv`, and returns its exit code.
        warm_up: Imports here what runs need; it starts no thread, for a fork would not have it.
    """

    main: Callable[[], int]
    warm_up: Callable[[], None]


def forks_of(arguments: object, groups: Iterable[Group]) -> Forks | None:
    """Return forks that have imported some groups of nodes and what draws pictures.

    None where the program that parsed the arguments is not to be forked.
    """
    also = "bringup.demo.measures", "bringup.viewing.pictures"
    main = vars(arguments).get("main")
    return Forks(main, lambda: warm_up(groups, also)) if main is not None else None


class _Started:
    """A run in progress; its output goes into its folder."""

    def __init__(self, job: Job, program: Sequence[str], forks: Forks | None) -> None:
        job.folder.mkdir(parents=True, exist_ok=True)
        self.job = job
        self._log = (job.folder / LOG).open("w", encoding="utf-8")
        self._last = ""
        self._start = time.monotonic()
        command = [*program, *job.run.words(job.campaign, job.folder)]
        main = None if forks is None else forks.main
        self._child = Child(ChildSpec(job.run.name, command, run=main), self._write)

    def _write(self, line: str) -> None:
        self._log.write(f"{line}\n")
        self._last = line.strip() or self._last

    def ended(self) -> Outcome | None:
        """Return how the run ended; None while it runs."""
        self._child.read()
        code, timeout = self._child.poll(), self.job.campaign.timeout
        passed = time.monotonic() - self._start
        if code is not None:
            self._close()
            return self._judged(code, passed)
        if passed <= timeout:
            return None
        self.stop()
        return self._outcome(f"took longer than {timeout:g} s", passed)

    def stop(self) -> None:
        """End the process and close its files."""
        self._child.send(signal.SIGKILL)
        while self._child.poll() is None:
            threading.Event().wait(_POLL)
        self._close()

    def _close(self) -> None:
        self._child.close()
        self._log.close()

    def _judged(self, code: int, passed: float) -> Outcome:
        try:
            result = read_json(self.job.folder / self.job.campaign.result)
        except InputFileError:
            return self._outcome(f"{describe_exit(code)}, no result; {self._last}", passed)
        flat = dotted(result) if isinstance(result, dict) else {}
        reason = judged(flat, self.job.campaign.success)
        return self._outcome(reason, passed, figures_of(flat))

    def _outcome(
        self, reason: str, passed: float, figures: dict[str, float] | None = None
    ) -> Outcome:
        run = self.job.run
        return Outcome(run.name, run.levels, not reason, reason, passed, figures or {})


class LocalPool:
    """Some jobs at a time, each a process of this machine: a program, or a fork if there is one."""

    def __init__(
        self, jobs: int, program: Sequence[str] = PROGRAM, forks: Forks | None = None
    ) -> None:
        self.slots = self.capacity = jobs
        self._program, self._forks = program, forks
        self._going: list[_Started] = []
        self._warm = False

    def start(self, job: Job) -> None:
        """Start a run."""
        if not self._warm:
            os.environ.update(dict.fromkeys(_THREADS, "1"))  # the runs share the cores already
            if self._forks is not None:
                self._forks.warm_up()
            self._warm = True
        self._going.append(_Started(job, self._program, self._forks))

    def ended(self, timeout: float) -> list[Ended]:
        """Return the jobs that ended, waiting for the first at most some time [s]."""
        end = time.monotonic() + timeout
        while True:
            threading.Event().wait(_POLL)
            found = [(one, outcome) for one in self._going if (outcome := one.ended())]
            if found or time.monotonic() >= end:
                break
        for one, _ in found:
            self._going.remove(one)
        return [Ended(one.job, outcome) for one, outcome in found]

    def stop(self) -> None:
        """End the runs in progress."""
        while self._going:
            self._going.pop().stop()


class Progress:
    """Shows how runs end, how many run, and when the last will have."""

    def __init__(self, count: int, pool: Pool) -> None:
        self._count, self._pool = count, pool
        self._done = self._lost = self._before = 0
        self._start = float("nan")
        self._bar = Bar()

    def ended(self, outcome: Outcome) -> None:
        """Show how a run ended."""
        self._done += 1
        verdict = "ok" if outcome.success else f"FAILED: {outcome.reason}"
        line = f"{self._done:5} of {self._count}  {outcome.name:40} {outcome.wall_s:7.1f} s"
        self._bar.clear()
        show(f"{line}  {verdict}")

    def lost(self, end: Ended) -> None:
        """Show that a run was given up."""
        self._lost += 1
        self._bar.clear()
        show(f"LOST  {end.job.run.name}: {end.cause}; the same words try it again")

    def show(self, going: int) -> None:
        """Show how far all are, while some have started and not ended."""
        now = time.monotonic()
        if self._start != self._start:
            self._start, self._before = now, self._done
        minutes = (now - self._start) / 60.0
        rate = (self._done - self._before) / max(minutes, 1e-3)
        remaining = self._count - self._done - self._lost
        end = f", ends in {remaining / rate:.0f} min" if rate > 0.0 else ""
        running = min(going, self._pool.slots)
        self._bar.show(
            (self._done + self._lost) / self._count,
            f"{self._done} done, {running} running, {self._lost} lost, {rate:.1f} a minute{end}",
        )
