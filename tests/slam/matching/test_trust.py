"""What odometry is worth and how much longer its ways are, held to what Bayes has to say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus
from arjuna_slam.matching.tracking import Stretch, Trust

SEEN = np.diag([0.01**2, 0.01**2, 0.003**2])
STEP = np.array([[100.0, 20.0, 3.0], [20.0, 100.0, -2.0], [3.0, -2.0, 50.0]])


def match(pose: SE2, covariance: NDArray[np.float64] = SEEN) -> Match:
    return Match(MatchStatus.MATCHED, pose, covariance, 0.9)


def weighed(square: float) -> NDArray[np.float64]:
    """Return a step's information where its positions err by so much more, squared."""
    by = np.diag([square, square, 1.0]) ** 0.5
    return np.asarray(np.linalg.inv(by @ np.linalg.inv(STEP) @ by), np.float64)


def test_odometry_is_worth_what_it_was_over_the_last_ten_metres() -> None:
    trust = Trust()
    np.testing.assert_allclose(trust.weigh(STEP), STEP)
    # Off by 0.2 and 0.1 m, which is (100 0.04 + 2 20 0.02 + 100 0.01) / 2 = 2.9 times the expected
    # square; half of what is remembered is 5 m old at most.
    trust.judge(SE2(1.0, 2.0, 0.0), match(SE2(1.2, 2.1, 0.5)), STEP, 5.0)
    np.testing.assert_allclose(trust.weigh(STEP), weighed(0.5 * 1.0 + 0.5 * 2.9))
    trust.judge(SE2(1.2, 2.1, 0.0), match(SE2(1.0, 2.0, 0.5)), STEP, 25.0)
    np.testing.assert_allclose(trust.weigh(STEP), weighed(2.9))
    trust.judge(SE2(), match(SE2()), STEP, 1.0)
    np.testing.assert_allclose(trust.weigh(STEP), weighed(0.9 * 2.9))
    trust.judge(SE2(), match(SE2()), STEP, 10.0)
    np.testing.assert_allclose(trust.weigh(STEP), weighed(0.3**2))  # never better than that


@pytest.mark.parametrize("angle", [0.0, 0.8, math.pi / 2])
@pytest.mark.parametrize(("worst", "judges"), [(0.0149, True), (0.0151, False)])
def test_only_a_place_seen_well_in_each_direction_judges(
    angle: float, worst: float, judges: bool
) -> None:
    turn = SE2(0.0, 0.0, angle).matrix()
    covariance = turn @ np.diag([worst**2, 0.005**2, 0.003**2]) @ turn.T
    trust = Trust()
    trust.judge(SE2(), match(SE2(0.5), covariance), STEP, 10.0)
    assert np.allclose(trust.weigh(STEP), STEP) is not judges
    failed = replace(match(SE2(0.5)), status=MatchStatus.LOW_RESPONSE)
    trust = Trust()
    trust.judge(SE2(), failed, STEP, 10.0)
    np.testing.assert_array_equal(trust.weigh(STEP), STEP)


class Expected:
    """The factor as precisions add up: known to 3 %, and as much again comes in 500 m."""

    def __init__(self) -> None:
        self.mean, self.variance = 1.0, 0.03**2

    def take(self, told: float, went: float, noise: float | None) -> None:
        """Take in a way measured with a variance [m^2]; None where it is not seen."""
        self.variance += 0.03**2 * told / 500.0
        if noise is None:
            return
        spread = math.sqrt(noise + told**2 * self.variance)
        off = max(-3.0 * spread, min(went - self.mean * told, 3.0 * spread))
        went = self.mean * told + off
        precision = 1.0 / self.variance + told**2 / noise
        self.mean = (self.mean / self.variance + told * went / noise) / precision
        self.variance = 1.0 / precision


def corridor(heading: float, along: float, across: float = 0.01) -> NDArray[np.float64]:
    turn = SE2(0.0, 0.0, heading).matrix()
    known: NDArray[np.float64] = turn @ np.diag([along**2, across**2, 1e-6]) @ turn.T
    return known


@pytest.mark.parametrize("seed", range(4))
def test_the_factor_is_that_of_the_ways_measured(seed: int) -> None:
    """Ways of 2 m or more, piecewise along a bend, between matches in one reference."""
    rng, stretch, expected = np.random.default_rng(seed), Stretch(), Expected()
    reference, pose = Field(0.05, 0.05), SE2(3.0, -1.0, 0.4)
    last = corridor(0.4, 0.01)
    stretch.judge(reference, match(pose, last), SE2(9.0))
    for _ in range(60):
        start, told, first = pose, IDENTITY, last
        heading = math.atan2(*rng.normal(0.0, 1.0, 2).tolist())
        while math.hypot(told.x, told.y) < 2.0:
            delta = SE2(*rng.uniform((0.2, -0.1, -0.2), (0.9, 0.1, 0.2)).tolist())
            told = told @ delta
            length = rng.normal(1.04, 0.02 if rng.random() < 0.9 else 0.5)
            end = start @ SE2(length * told.x, length * told.y, told.theta)
            last = corridor(heading, float(rng.choice([0.005, 0.024, 0.03])), 0.008)
            stretch.judge(reference, match(end, last), delta)
        pose = end
        way = np.array([end.x - start.x, end.y - start.y])
        axis = way / np.hypot(*way)
        seen = [float(axis @ known[:2, :2] @ axis) for known in (first, last)]
        noise = sum(seen) if max(seen) <= 0.025**2 else None
        expected.take(math.hypot(told.x, told.y), float(np.hypot(*way)), noise)
        assert stretch.factor == pytest.approx(expected.mean, abs=1e-9)
    assert stretch.of(SE2(2.0, -1.0, 0.3)) == SE2(2.0 * stretch.factor, -stretch.factor, 0.3)


def test_a_way_ends_with_its_reference_or_a_failed_match() -> None:
    reference = Field(0.05, 0.05)
    failed = Match(MatchStatus.LOW_RESPONSE, SE2(), SEEN, 0.1)
    for between in ((reference, failed), (Field(0.05, 0.05), match(SE2(70.0)))):
        stretch, expected = Stretch(), Expected()
        for x, told in ((5.0, 0.0), (6.0, 1.0)):
            stretch.judge(reference, match(SE2(x)), SE2(told))
        stretch.judge(*between, SE2(1.5))
        for x, told in ((20.0, 1.9), (21.1, 1.0)):  # from 20 m on anew
            stretch.judge(reference, match(SE2(x)), SE2(told))
        assert stretch.factor == 1.0
        stretch.judge(reference, match(SE2(22.2)), SE2(1.0))
        expected.take(2.0, 2.2, 2e-4)
        assert stretch.factor == pytest.approx(expected.mean)
