"""Runs a tuning: trial after trial, each a small campaign, and the winner against what is now."""

from __future__ import annotations

import dataclasses
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.comparison import compared
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import runs_of
from bringup.campaign.pool import Ended, Job, Pool
from bringup.campaign.runner import resumed, run_all, run_jobs
from bringup.tuning.plan import Tuning, Value
from bringup.tuning.study import Study, Tried

BEST = "best.yaml"


@dataclass
class _Trial:
    """A trial in progress: its values, its jobs and outcomes, and how many these will be."""

    values: Mapping[str, Value]
    waiting: deque[Job]
    outcomes: dict[str, Outcome]
    count: int


class Tuner:
    """A tuning in progress.

    Args:
        stop: Set to break off; unfinished runs are run again next time.
        at_once: How many trials run side by side. A trial is proposed from those that ended
            `at_once` before it and the values of those between: the same number gives the same
            trials on any pool, another one gives others.

    Attributes:
        lost: The runs that were given up, whose trials have not ended.

    Raises:
        CampaignError: The folder is another tuning's.
        OSError: It cannot be written.
    """

    def __init__(
        self, tuning: Tuning, folder: Path, pool: Pool, stop: threading.Event, at_once: int = 1
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._tuning, self._folder, self._pool = tuning, folder, pool
        self._stop, self._at_once = stop, at_once
        self._going: dict[int, _Trial] = {}
        self.lost: list[Ended] = []
        self.study = Study(tuning, folder)

    def run(self, report: Callable[[Tried], None]) -> bool:
        """Run the trials that are left; return whether all have been run."""
        for one in self.study.tried():
            report(one)
        for end in run_jobs(lambda: self._next(report), self._pool, self._stop):
            trial = self._going[int(end.job.folder.parent.name)]
            if end.outcome is None:
                self.lost.append(end)
            else:
                trial.outcomes[end.outcome.name] = end.outcome
            self._add_ended(report)
        return len(self.study.tried()) >= self._tuning.trials

    def _next(self, report: Callable[[Tried], None]) -> Job | None:
        """Return the next run of a trial in progress, or of a new one; None where none is due."""
        while True:
            for trial in self._going.values():
                if trial.waiting:
                    return trial.waiting.popleft()
            number = len(self.study.tried()) + len(self._going)
            if len(self._going) >= self._at_once or number >= self._tuning.trials:
                return None
            self._going[number] = self._started(number)
            self._add_ended(report)

    def _started(self, number: int) -> _Trial:
        going = [trial.values for trial in self._going.values()]
        values = self.study.proposal(number, going, self._at_once)
        folder = self._folder / "trials" / f"{number:04}"
        campaign = self._tuning.trial(values, folder)
        runs = runs_of(campaign)
        outcomes, waiting = resumed(campaign, runs, folder)
        return _Trial(values, waiting, outcomes, len(runs))

    def _add_ended(self, report: Callable[[Tried], None]) -> None:
        """Add the trials that ended to the study, in order of their numbers."""
        while self._going:
            number, trial = next(iter(self._going.items()))
            if len(trial.outcomes) < trial.count:
                return
            del self._going[number]
            outcomes = [trial.outcomes[name] for name in sorted(trial.outcomes)]
            report(self.study.add(trial.values, outcomes))
            self._write_best()

    def confirm(self) -> list[str]:
        """Compare the best with what is now on runs that chose neither; return lines to show."""
        best = self.study.ranked()[0]
        if not self._tuning.confirm or best.number == 0:
            return []
        folder = self._folder / "confirm"
        sides = (("now", self._tuning.now), (f"{best.number:04}", best.values))
        first, second = (self._outcomes(values, folder / name) for name, values in sides)
        if first is None or second is None:
            return []
        head = "on other runs, first with the values of now, second with trial"
        return [f"\n{head} {best.number + 1}'s:", *compared(first, second)]

    def _outcomes(self, values: Mapping[str, Value], folder: Path) -> list[Outcome] | None:
        """Run some values on the last comparison's runs; None where it was broken off."""
        campaign = self._tuning.trial(values, folder)
        campaign = dataclasses.replace(campaign, factors=self._tuning.confirm)
        runs = runs_of(campaign)
        outcomes = run_all(campaign, runs, folder, self._pool, lambda outcome: None, self._stop)
        return outcomes if len(outcomes) == len(runs) else None

    def _write_best(self) -> None:
        best = self.study.ranked()[0]
        head = f"# {self._tuning.campaign.name}: trial {best.number + 1}, {self.verdict(best)}.\n"
        write_atomically(
            self._folder / BEST, (head + self._tuning.parameter_text(best.values)).encode()
        )

    def verdict(self, one: Tried) -> str:
        """Return how a trial went, in words."""
        failed = f", {one.failed} of its runs failed" if one.failed else ""
        return f"{self._tuning.measure} {one.figure:.4g}{failed}"
