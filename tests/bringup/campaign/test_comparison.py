"""Confidence of figures, against values from tables."""

from __future__ import annotations

import numpy as np
import pytest

from bringup.campaign.report import measure_difference, success_difference, wilson_interval


@pytest.mark.parametrize(
    ("successes", "count", "interval"),
    [(0, 0, (0.0, 1.0)), (0, 20, (0.0, 0.1611)), (81, 263, (0.2553, 0.3662)),
     (20, 20, (0.8389, 1.0))],
)  # fmt: skip
def test_wilson_s_interval(successes: int, count: int, interval: tuple[float, float]) -> None:
    assert wilson_interval(successes, count) == pytest.approx(interval, abs=1e-4)


def test_wilson_s_interval_holds_the_truth_as_often_as_it_says() -> None:
    drawn = np.random.default_rng(0).binomial(50, 0.9, 2000)
    intervals = [wilson_interval(n, 50) for n in range(51)]
    held = [intervals[n][0] <= 0.9 <= intervals[n][1] for n in drawn]
    assert np.mean(held) == pytest.approx(0.95, abs=0.03)


def test_the_lady_tasting_tea() -> None:
    assert success_difference((3, 1), (1, 3)) == pytest.approx(0.4857, abs=1e-4)


def test_a_shift_is_distinguished_from_none() -> None:
    rng = np.random.default_rng(1)
    one, same, other = rng.normal(0, 1, 50), rng.normal(0, 1, 50), rng.normal(1, 1, 50)
    assert measure_difference(list(one), list(other)) < 0.01
    assert measure_difference(list(one), list(same)) > 0.05
    assert measure_difference(list(one), [np.nan]) == 1.0
