"""Confidence intervals of a campaign's figures, and tests of whether two campaigns differ."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy import stats

from bringup.campaign.outcome import Outcome, read_outcome
from bringup.campaign.plan import CampaignError


def outcomes_in(folder: Path) -> list[Outcome]:
    """Return the outcomes of a campaign's folder, in the order of its runs.

    Raises:
        CampaignError: It holds none.
    """
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    outcomes = [one for one in map(read_outcome, paths) if one is not None]
    if not outcomes:
        raise CampaignError(folder, "holds no runs; valid: the folder that a campaign wrote")
    return outcomes


def compared(first: Sequence[Outcome], second: Sequence[Outcome], level: float = 0.05) -> list[str]:
    """Return lines with two campaigns' figures and how probable the difference is by chance.

    Below a level of that probability they differ.
    """
    counts = [(sum(one.success for one in each), len(each)) for each in (first, second)]
    chance = success_difference(*((good, total - good) for good, total in counts))
    lines = [_line("", ("first", "second"), "p")]
    lines.append(_line("success", [f"{a} of {b}" for a, b in counts], _verdict(chance, level)))
    keys = dict.fromkeys(key for one in (*first, *second) for key in one.figures)
    for key in keys:
        one, other = ([run.figures.get(key, np.nan) for run in each] for each in (first, second))
        medians = [f"{_median(each):.4g}" for each in (one, other)]
        lines.append(_line(key, medians, _verdict(measure_difference(one, other), level)))
    return lines


def _median(values: Sequence[float]) -> float:
    finite = np.array(values)[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else np.nan


def _verdict(chance: float, level: float) -> str:
    return f"{chance:.3f}{' differs' if chance < level else ''}"


def _line(name: str, both: Sequence[str], chance: str) -> str:
    return f"{name:28}{both[0]:>14}{both[1]:>14}  {chance}"


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability, all of 0 to 1 of no trial.

    Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22, 1927:
    right also where all or none succeed.
    """
    if count == 0:
        return 0.0, 1.0
    low, high = stats.binomtest(successes, count).proportion_ci(method="wilson")
    return float(low), float(high)


def success_difference(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Return how probable so great a difference is where there is none (Fisher's exact test)."""
    return float(stats.fisher_exact([first, second]).pvalue)


def measure_difference(first: Sequence[float], second: Sequence[float]) -> float:
    """Return how probable so great a shift is where there is none (Mann-Whitney's U test)."""
    one, other = (np.array(each, float) for each in (first, second))
    one, other = one[~np.isnan(one)], other[~np.isnan(other)]
    if not len(one) or not len(other):
        return 1.0
    return float(stats.mannwhitneyu(one, other).pvalue)
