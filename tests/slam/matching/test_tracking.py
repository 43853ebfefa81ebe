"""Claims: odometry counts for what it has proven to be worth, where scans cannot tell better."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Stretch, Trust

_SEEN, _UNSEEN = np.diag([1e-4, 1e-4, 1e-6]), np.diag([1.0, 1e-4, 1e-6])
_PIECE = 6.0  # way matched against one reference [m]


def driven(told: float, true: float, *, way: float = 100.0, covariance: Floats = _SEEN) -> Stretch:
    """Return what is learnt of steps that odometry told and that were another length [m]."""
    stretch, rng = Stretch(), np.random.default_rng(1)
    reference, x = Field(0.05, 0.05), 0.0
    for _ in range(round(way / true)):
        x += true
        if x > _PIECE:
            reference, x = Field(0.05, 0.05), 0.0
        pose = SE2(x + rng.normal(0.0, 0.01), rng.normal(0.0, 0.01), 0.0)
        stretch.judge(reference, Match(MatchStatus.MATCHED, pose, covariance, 1.0), SE2(told))
    return stretch


@pytest.mark.parametrize(("told", "true"), [(1.0, 1.02), (1.0, 0.97), (0.05, 0.051), (1.0, 1.0)])
def test_the_length_of_a_metre_is_learnt(told: float, true: float) -> None:
    stretch = driven(told, true)
    assert stretch.factor == pytest.approx(true / told, abs=0.005)
    assert stretch.of(SE2(told, 0.0, 0.3)).x == pytest.approx(true, abs=0.01)
    assert stretch.of(SE2(told, 0.0, 0.3)).theta == 0.3


def test_a_way_along_which_nothing_is_seen_tells_nothing() -> None:
    assert driven(1.0, 1.02, covariance=_UNSEEN).factor == 1.0


def test_a_slip_does_not_spoil_what_was_learnt() -> None:
    stretch, reference = driven(1.0, 1.02), Field(0.05, 0.05)
    for pose, told in ((SE2(), 0.0), (SE2(0.2, 0.0, 0.0), 3.0)):
        match = Match(MatchStatus.MATCHED, pose, _SEEN, 1.0)
        stretch.judge(reference, match, SE2(told))
    assert stretch.factor == pytest.approx(1.02, abs=0.01)


def test_a_failed_match_measures_no_way() -> None:
    stretch, reference = Stretch(), Field(0.05, 0.05)
    for x, status in ((0.0, "matched"), (2.5, "low response"), (9.0, "matched")):
        match = Match(MatchStatus(status), SE2(x, 0.0, 0.0), _SEEN, 1.0)
        stretch.judge(reference, match, SE2(2.5))
    assert stretch.factor == 1.0


_STEP = np.diag([100.0, 100.0, 400.0])  # 0.1 m, 0.05 rad
_WELL, _BADLY = np.diag([1e-5, 1e-5, 1e-6]), np.diag([1e-5, 1.0, 1e-6])


def judged(trust: Trust, error: float, covariance: Floats, steps: int) -> float:
    """Return what a metre's step is worth after as many that were off [deviations^-2]."""
    match = Match(MatchStatus.MATCHED, SE2(error, 0.0, 0.0), covariance, 1.0)
    for _ in range(steps):
        trust.judge(SE2(), match, _STEP, 1.0)
    return float(trust.weigh(_STEP)[0, 0])


def test_good_odometry_comes_to_count_for_more_and_a_slip_takes_that_away() -> None:
    trust = Trust()
    assert judged(trust, 0.0, _WELL, 1) < judged(trust, 0.0, _WELL, 50) < 20.0 * _STEP[0, 0]
    assert judged(trust, 1.0, _WELL, 1) < _STEP[0, 0]
    assert trust.weigh(_STEP)[2, 2] == _STEP[2, 2]


def test_a_match_that_does_not_see_all_judges_nothing() -> None:
    assert judged(Trust(), 0.0, _BADLY, 50) == _STEP[0, 0]


@pytest.mark.parametrize(("deviation", "held"), [(0.01, True), (0.1, False)])
def test_one_corner_does_not_outweigh_good_odometry(deviation: float, held: bool) -> None:
    """Two walls along x, and a few points of one across; the scan lies 0.05 m off along them."""
    x = np.arange(-4.0, 4.0, 0.05)
    walls = np.concatenate((np.column_stack((x, 0 * x + 1.0)), np.column_stack((x, 0 * x - 1.0))))
    across = np.column_stack((np.full(6, 3.0), np.linspace(0.7, 0.95, 6)))
    points = np.concatenate((walls, across))
    facing = np.column_stack((0.0 * walls[:, 0], -np.sign(walls[:, 1])))
    normals = np.concatenate((facing, np.tile([-1.0, 0.0], (6, 1))))
    field = Field(0.05, 0.05)
    field.add(points, normals)
    scan = Surface(points - [[0.05, 0.0]], normals, np.zeros(len(points), np.bool_))
    information = np.diag([deviation**-2, deviation**-2, 400.0])
    found = ScanMatcher(MatcherConfig()).track(field, scan, SE2(), information)
    assert found.status is MatchStatus.MATCHED
    assert (abs(found.T_field_base.x) < 0.02) is held


SEEN = np.diag([0.01**2, 0.01**2, 0.003**2])
STEP = np.array([[100.0, 20.0, 3.0], [20.0, 100.0, -2.0], [3.0, -2.0, 50.0]])


def match(pose: SE2, covariance: Floats = SEEN) -> Match:
    return Match(MatchStatus.MATCHED, pose, covariance, 0.9)


def weighed(square: float) -> Floats:
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


def corridor(heading: float, along: float, across: float = 0.01) -> Floats:
    turn = SE2(0.0, 0.0, heading).matrix()
    known: Floats = turn @ np.diag([along**2, across**2, 1e-6]) @ turn.T
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
