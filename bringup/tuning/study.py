"""The study: what was tried and how it went, in one file of Optuna's, and what to try next.

The file holds trials that have ended, nothing else. What comes next follows from them and from
their number, so a trial that was broken off is proposed again, and its runs are resumed.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import optuna
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

from arjuna_core.files.input_file import open_file
from bringup.campaign.outcome import Outcome
from bringup.campaign.plan import CampaignError
from bringup.tuning.plan import Dimension, Tuning, Value

FILE = "study.journal"
_FAILED, _TUNING = "failed runs", "tuning"


@dataclass(frozen=True)
class Tried:
    """A trial that has ended.

    Attributes:
        number: Its number; 0 has the values of now.
        values: The parameters' values, by dimension.
        figure: The mean of the figure that is bettered; infinitely bad where no run has one.
    """

    number: int
    values: Mapping[str, Value]
    figure: float
    failed: int


class Study:
    """All trials of a tuning.

    Raises:
        CampaignError: The file there is of another tuning, or is none.
    """

    def __init__(self, tuning: Tuning, folder: Path) -> None:
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._tuning = tuning
        path = folder / FILE
        if path.exists():
            open_file(path, CampaignError, 1 << 30).close()  # Optuna opens it again
        try:
            self._study = optuna.create_study(
                storage=JournalStorage(JournalFileBackend(str(path))),
                study_name=tuning.campaign.name,
                direction="maximize" if tuning.maximize else "minimize",
                load_if_exists=True,
            )
        except (ValueError, KeyError) as error:
            raise CampaignError(path, "is no study; valid: a new folder") from error
        known = self._study.user_attrs.get(_TUNING)
        if known is None:
            self._study.set_user_attr(_TUNING, tuning.identity)
        elif known != tuning.identity:
            raise CampaignError(folder, "has the trials of another tuning; valid: a new folder")

    def tried(self) -> list[Tried]:
        """Return the trials that have ended, in their order."""
        return [
            Tried(one.number, one.params, float(one.values[0]), int(one.constraints[_FAILED]))
            for one in self._study.get_trials(deepcopy=False)
        ]

    def proposal(
        self, number: int, going: Sequence[Mapping[str, Value]] = (), at_once: int = 1
    ) -> dict[str, Value]:
        """Return the values of a trial: first those of now, then what the sampler expects of.

        The tree-structured Parzen estimator of Bergstra et al., "Algorithms for hyper-parameter
        optimization", NIPS 2011, with failed runs as a constraint: fewer of them come before
        any figure. Of trials that may run beside it only the values count, as bad ones (a constant
        liar), whether or not they have ended: what is proposed does not depend on who is first.

        Args:
            going: The values of the trials before it that have not ended, in order.
            at_once: How many trials run side by side.
        """
        if number == 0:
            return self._tuning.now
        trials = self._study.get_trials(deepcopy=False)[:number]
        known = trials[: max(0, number - at_once + 1)]
        beside = [*(one.params for one in trials[len(known) :]), *going]
        sampler = optuna.samplers.TPESampler(seed=number, constant_liar=at_once > 1)
        copy = optuna.create_study(sampler=sampler, direction=self._study.direction)
        space = _distributions(self._tuning.dimensions)
        copy.add_trials(known)
        copy.add_trials(
            optuna.create_trial(
                state=optuna.trial.TrialState.RUNNING, params=dict(one), distributions=space
            )
            for one in beside
        )
        proposed = copy.ask(space).params
        return {one.name: _rounded(one, proposed[one.name]) for one in self._tuning.dimensions}

    def add(self, values: Mapping[str, Value], outcomes: Sequence[Outcome]) -> Tried:
        """Add a trial that has ended."""
        failed = sum(not one.success for one in outcomes)
        worst = -math.inf if self._tuning.maximize else math.inf
        measure = self._tuning.measure
        figures = [one.figures[measure] for one in outcomes if measure in one.figures]
        finite = [figure for figure in figures if math.isfinite(figure)]
        self._study.add_trial(
            optuna.create_trial(
                params=dict(values),
                distributions=_distributions(self._tuning.dimensions),
                value=float(np.mean(finite)) if finite else worst,
                constraints={_FAILED: failed},
            )
        )
        return self.tried()[-1]

    def ranked(self) -> list[Tried]:
        """Return the trials, the best first: by runs that failed, then by the figure."""
        sign = -1.0 if self._tuning.maximize else 1.0
        return sorted(self.tried(), key=lambda one: (one.failed, sign * one.figure, one.number))

    def importance(self, good_share: float = 0.25, least: int = 8) -> dict[str, float]:
        """Return how much each parameter distinguishes the good trials, the most first.

        Watanabe et al., "PED-ANOVA: efficiently quantifying hyperparameter importance in arbitrary
        subspaces", IJCAI 2023.

        Returns:
            Shares of 1 by dimension; nothing while there are too few trials.
        """
        rank = {one.number: float(position) for position, one in enumerate(self.ranked())}
        if len(rank) < least:
            return {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that less of the target is better, as a rank is
            found = optuna.importance.get_param_importances(
                self._study,
                evaluator=optuna.importance.PedAnovaImportanceEvaluator(target_quantile=good_share),
                target=lambda trial: rank[trial.number],
            )
        return dict(found)


def _rounded(one: Dimension, value: Value, digits: int = 4) -> Value:
    if one.choices or one.whole:
        return value
    return min(max(float(f"{value:.{digits}g}"), one.low), one.high)


def _distributions(dimensions: Sequence[Dimension]) -> dict[str, BaseDistribution]:
    found: dict[str, BaseDistribution] = {}
    for one in dimensions:
        if one.choices:
            found[one.name] = CategoricalDistribution(one.choices)
        elif one.whole:
            found[one.name] = IntDistribution(int(one.low), int(one.high), log=one.log)
        else:
            found[one.name] = FloatDistribution(one.low, one.high, log=one.log)
    return found
