"""Runs a campaign: one process a run, some at a time, and resumes where it was broken off."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.config import dotted
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json, read_text
from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.outcome import Outcome, figures_of, judged, read_outcome, write_outcome
from bringup.campaign.plan import Campaign, CampaignError, Run
from bringup.processes.child import Child, ChildSpec, describe_exit

_POLL = 0.1  # [s] from one look at the running processes to the next
_PROGRAM = (sys.executable, "-m", "bringup")
_CLAIM = "campaign.json"
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Forks:
    """Runs in forks of this process, which need not import all that they stand on.

    Attributes:
        main: Does a run, its words in `sys.argv`, and returns its exit code.
        warm_up: Imports here what runs need; it starts no thread, for a fork would not have it.
    """

    main: Callable[[], int]
    warm_up: Callable[[], None]


class _Started:
    """A run in progress; its output goes into its folder."""

    def __init__(
        self,
        campaign: Campaign,
        run: Run,
        folder: Path,
        program: Sequence[str],
        forks: Forks | None,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.run, self._folder, self._campaign = run, folder, campaign
        self._log = (folder / "log.txt").open("w", encoding="utf-8")
        self._last = ""
        self._start = time.monotonic()
        command = [*program, *run.words(campaign, folder)]
        main = None if forks is None else forks.main
        self._child = Child(ChildSpec(run.name, command, run=main), self._write)

    def _write(self, line: str) -> None:
        self._log.write(f"{line}\n")
        self._last = line.strip() or self._last

    def ended(self) -> Outcome | None:
        """Return how the run ended; None while it runs."""
        self._child.read()
        code = self._child.poll()
        passed = time.monotonic() - self._start
        if code is not None:
            self._close()
            return self._judged(code, passed)
        if passed <= self._campaign.timeout:
            return None
        self.stop()
        return self._outcome(f"took longer than {self._campaign.timeout:g} s", passed)

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
            result = read_json(self._folder / self._campaign.result)
        except InputFileError:
            return self._outcome(f"{describe_exit(code)}, no result; {self._last}", passed)
        flat = dotted(result) if isinstance(result, dict) else {}
        reason = judged(flat, self._campaign.success)
        return self._outcome(reason, passed, figures_of(flat))

    def _outcome(
        self, reason: str, passed: float, figures: dict[str, float] | None = None
    ) -> Outcome:
        run = self.run
        return Outcome(run.name, run.levels, not reason, reason, passed, figures or {})


def run_all(
    campaign: Campaign,
    runs: Sequence[Run],
    folder: Path,
    jobs: int,
    ended: Callable[[Outcome], None],
    stop: threading.Event,
    program: Sequence[str] = _PROGRAM,
    forks: Forks | None = None,
) -> list[Outcome]:
    """Run what has not been run yet.

    Args:
        jobs: How many at a time.
        ended: Takes each outcome, those of earlier times first.
        stop: Set to break off; unfinished runs are run again next time.
        program: What takes the words of a run.
        forks: What does the same in forks of this process; None to start the program each time.

    Returns:
        The outcomes there are, in the order of the runs.

    Raises:
        CampaignError: The folder is another campaign's.
        OSError: A folder cannot be written.
    """
    _claim(folder, campaign)
    os.environ.update(dict.fromkeys(_THREADS, "1"))  # the runs share the cores already
    found = {run.name: read_outcome(folder / run.name) for run in runs}
    for outcome in filter(None, found.values()):
        ended(outcome)
    waiting = [run for run in runs if found[run.name] is None]
    if forks is not None and waiting:
        forks.warm_up()

    def start(run: Run) -> _Started:
        return _Started(campaign, run, folder / run.name, program, forks)

    for outcome in _outcomes(waiting, start, folder, jobs, stop):
        found[outcome.name] = outcome
        ended(outcome)
    return [outcome for outcome in found.values() if outcome is not None]


def _outcomes(
    waiting: list[Run],
    start: Callable[[Run], _Started],
    folder: Path,
    jobs: int,
    stop: threading.Event,
) -> Iterator[Outcome]:
    """Yield how each run ended, as it does; those that are broken off are stopped."""
    going: list[_Started] = []
    try:
        while (waiting or going) and not stop.is_set():
            while waiting and len(going) < jobs:
                going.append(start(waiting.pop(0)))
            stop.wait(_POLL)
            yield from _ended(going, folder)
    finally:
        for started in going:
            started.stop()


def _ended(going: list[_Started], folder: Path) -> list[Outcome]:
    outcomes = []
    for started in list(going):
        end = started.ended()
        if end is not None:
            going.remove(started)
            write_outcome(folder / end.name, end)
            outcomes.append(end)
    return outcomes


def _claim(folder: Path, campaign: Campaign) -> None:
    """Write down what the folder's runs are of: no other campaign shall take them for its own."""
    text = json.dumps(dataclasses.asdict(campaign), indent=2)
    path = folder / _CLAIM
    if not path.exists():
        write_atomically(path, text.encode())
    elif read_text(path) != text:
        raise CampaignError(folder, "has the runs of another campaign; valid: a new folder")
