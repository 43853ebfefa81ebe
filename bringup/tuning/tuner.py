"""Runs a tuning: trial after trial, each a small campaign, and the winner against what is now."""

from __future__ import annotations

import dataclasses
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from arjuna_core.files.whole_file import write_atomically
from bringup.campaign.comparison import compared
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import Campaign, Level, runs_of
from bringup.campaign.runner import run_all
from bringup.tuning.plan import Tuning
from bringup.tuning.space import Value
from bringup.tuning.study import Study, Tried

BEST = "best.yaml"
_PROGRAM = (sys.executable, "-m", "bringup")


class Tuner:
    """A tuning in progress.

    Args:
        folder: Where the study, a folder a trial and the best parameters go.
        stop: Set to break off; unfinished runs are run again next time.
        program: What takes the words of a run.

    Raises:
        CampaignError: The folder is another tuning's.
        OSError: It cannot be written.
    """

    def __init__(
        self,
        tuning: Tuning,
        folder: Path,
        jobs: int,
        stop: threading.Event,
        program: Sequence[str] = _PROGRAM,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._tuning, self._folder, self._jobs = tuning, folder, jobs
        self._stop, self._program = stop, program
        self.study = Study(tuning, folder)

    def run(self, report: Callable[[Tried], None]) -> bool:
        """Run the trials that are left; return whether all have been run."""
        tried = self.study.tried()
        for one in tried:
            report(one)
        for number in range(len(tried), self._tuning.trials):
            values = self.study.proposal()
            outcomes = self._outcomes(values, self._folder / "trials" / f"{number:04}")
            if outcomes is None:
                return False
            report(self.study.add(values, outcomes))
            self._write_best()
        return True

    def confirm(self) -> list[str]:
        """Compare the best with what is now on runs that chose neither; return lines to show."""
        best = self._best()
        if not self._tuning.confirm or best.number == 0:
            return []
        folder = self._folder / "confirm"
        sides = (("now", self._tuning.now), (f"{best.number:04}", best.values))
        both = [self._outcomes(v, folder / name, self._tuning.confirm) for name, v in sides]
        first, second = both
        if first is None or second is None:
            return []
        head = (
            f"\non other runs, first with the values of now, second with trial {best.number + 1}'s:"
        )
        return [head, *compared(first, second)]

    def _outcomes(
        self,
        values: Mapping[str, Value],
        folder: Path,
        factors: Mapping[str, tuple[Level, ...]] | None = None,
    ) -> list[Outcome] | None:
        """Run some values; None where it was broken off."""
        campaign: Campaign = self._tuning.trial(values, folder)
        if factors is not None:
            campaign = dataclasses.replace(campaign, factors=factors)
        runs = runs_of(campaign)
        outcomes = run_all(
            campaign, runs, folder, self._jobs, lambda outcome: None, self._stop, self._program
        )
        return outcomes if len(outcomes) == len(runs) else None

    def _best(self) -> Tried:
        return self.study.ranked()[0]

    def _write_best(self) -> None:
        best = self._best()
        head = f"# {self._tuning.campaign.name}: trial {best.number + 1}, {self.verdict(best)}.\n"
        write_atomically(
            self._folder / BEST, (head + self._tuning.parameter_text(best.values)).encode()
        )

    def verdict(self, one: Tried) -> str:
        """Return how a trial went, in words."""
        failed = f", {one.failed} of its runs failed" if one.failed else ""
        return f"{self._tuning.measure} {one.figure:.4g}{failed}"
