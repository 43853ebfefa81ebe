"""How sure a campaign's figures are, and whether two campaigns differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import stats


def wilson_interval(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability.

    Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22, 1927:
    right also where all or none succeed.

    Args:
        successes: How many succeeded.
        count: Of how many; the interval is all of 0 to 1 for none.
    """
    if count == 0:
        return 0.0, 1.0
    low, high = stats.binomtest(successes, count).proportion_ci(method="wilson")
    return float(low), float(high)


def success_difference(first: tuple[int, int], second: tuple[int, int]) -> float:
    """Return how probable so great a difference is where there is none (Fisher's exact test).

    Args:
        first: Successes and failures of one campaign.
        second: Those of the other.
    """
    return float(stats.fisher_exact([first, second]).pvalue)


def measure_difference(first: Sequence[float], second: Sequence[float]) -> float:
    """Return how probable so great a shift is where there is none (Mann-Whitney's U test).

    Args:
        first: The figures of one campaign; NaN is left out.
        second: Those of the other.

    Returns:
        The probability; 1 where one has no figures.
    """
    one, other = (np.array(each, float) for each in (first, second))
    one, other = one[~np.isnan(one)], other[~np.isnan(other)]
    if not len(one) or not len(other):
        return 1.0
    return float(stats.mannwhitneyu(one, other).pvalue)
