"""Statistics of outcomes: confidence intervals, and differences that chance explains or not."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from bringup.campaign.outcome import Outcome

Pairs = Sequence[tuple[Outcome, Outcome]]
"""Runs that differ in nothing but what is compared."""


@dataclass(frozen=True)
class Estimate:
    """A mean of some values and its 95 % confidence interval, NaN where it has none."""

    count: int
    mean: float
    low: float
    high: float

    @property
    def significant(self) -> bool:
        """True if the interval leaves out 0."""
        return self.low > 0.0 or self.high < 0.0

    def __str__(self) -> str:
        """Return it with as many digits as the interval gives sense to; "" of no value."""
        if not self.low < self.high:
            return f"{self.mean:.4g}" if self.count else ""
        digits = max(1 - math.floor(math.log10(0.5 * (self.high - self.low))), 0)
        mean, low, high = (round(v, digits) + 0.0 for v in (self.mean, self.low, self.high))
        return f"{mean:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def estimate(values: ArrayLike, seed: int = 0, resamples: int = 9999, least: int = 6) -> Estimate:
    """Return the mean of the finite values, with its interval by the bootstrap.

    Bias-corrected and accelerated: Efron, "Better bootstrap confidence intervals", JASA 82, 1987;
    by percentiles of the resampled means where that is not defined, and of many values, where
    both agree. Fewer than six have no interval: not even the range of five, between their least and
    their greatest, holds a median with 95 %.
    """
    given = np.asarray(values, float)
    data = given[np.isfinite(given)]
    mean = float(data.mean()) if len(data) else math.nan
    if len(data) < least:
        return Estimate(len(data), mean, math.nan, math.nan)
    if np.ptp(data) == 0.0:
        return Estimate(len(data), mean, mean, mean)
    for method in ("BCa", "percentile") if len(data) <= 1000 else ("percentile",):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it is not defined: it is NaN then
            low, high = scipy.stats.bootstrap(
                (data,),
                np.mean,
                n_resamples=resamples,
                batch=max(10_000_000 // len(data), 1),  # bounds the memory
                method=method,
                rng=np.random.default_rng(seed),
            ).confidence_interval
        if math.isfinite(low + high):
            break
    return Estimate(len(data), mean, float(low), float(high))


def figures(outcomes: Sequence[Outcome], key: str) -> list[float]:
    """Return a figure of each run, NaN where it has none."""
    return [one.figures.get(key, math.nan) for one in outcomes]


def paired_difference(pairs: Pairs, key: str) -> Estimate:
    """Return by how much a figure of the second runs exceeds that of the first, pair by pair."""
    first, second = (figures([pair[side] for pair in pairs], key) for side in (0, 1))
    with np.errstate(invalid="ignore"):  # of infinities
        return estimate(np.subtract(second, first))


def discordant(pairs: Pairs) -> tuple[int, int, float]:
    """Return in how many pairs only the first or only the second run succeeded, and how probable.

    The probability of so unequal numbers where both succeed as often: McNemar's test, exact.
    """
    first = sum(a.success and not b.success for a, b in pairs)
    second = sum(b.success and not a.success for a, b in pairs)
    chance = scipy.stats.binomtest(first, first + second).pvalue if first + second else 1.0
    return first, second, float(chance)


def compared(first: Sequence[Outcome], second: Sequence[Outcome], level: float = 0.05) -> list[str]:
    """Return lines with two campaigns' figures and how probable the difference is by chance.

    Below a level of that probability they differ. Runs that both have by one name are pairs, whose
    mean difference stands beside it.
    """
    others = {one.name: one for one in second}
    pairs = [(one, others[one.name]) for one in first if one.name in others]
    counts = [(sum(one.success for one in each), len(each)) for each in (first, second)]
    chance = success_difference(*((good, total - good) for good, total in counts))
    lines = [_line("", ("first", "second"), "p", f"{len(pairs)} pairs" if pairs else "")]
    lines.append(_line("success", [f"{a} of {b}" for a, b in counts], _verdict(chance, level)))
    keys = dict.fromkeys(key for one in (*first, *second) for key in one.figures)
    for key in keys:
        one, other = figures(first, key), figures(second, key)
        medians = [f"{_median(each):.4g}" for each in (one, other)]
        verdict = _verdict(measure_difference(one, other), level)
        lines.append(_line(key, medians, verdict, str(paired_difference(pairs, key))))
    return lines


def _median(values: Sequence[float]) -> float:
    finite = np.array(values)[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else np.nan


def _verdict(chance: float, level: float) -> str:
    return f"{chance:.3f}{' differs' if chance < level else ''}"


def _line(name: str, both: Sequence[str], chance: str, difference: str = "") -> str:
    return f"{name:28}{both[0]:>14}{both[1]:>14}  {chance:13}  {difference}".rstrip()


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability, all of 0 to 1 of no trial.

    Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22, 1927:
    right also where all or none succeed.
    """
    if count == 0:
        return 0.0, 1.0
    low, high = scipy.stats.binomtest(successes, count).proportion_ci(method="wilson")
    return float(low), float(high)


def success_difference(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Return how probable so great a difference is where there is none (Fisher's exact test)."""
    return float(scipy.stats.fisher_exact([first, second]).pvalue)


def measure_difference(first: Sequence[float], second: Sequence[float]) -> float:
    """Return how probable so great a shift is where there is none (Mann-Whitney's U test)."""
    one, other = (np.array(each, float) for each in (first, second))
    one, other = one[~np.isnan(one)], other[~np.isnan(other)]
    if not len(one) or not len(other):
        return 1.0
    return float(scipy.stats.mannwhitneyu(one, other).pvalue)
