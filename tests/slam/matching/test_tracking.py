"""Tracking of scans, and what odometry counts for by what it has proven."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Stretch, Tracker, TrackerConfig, Trust


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
KNOWN = np.diag([0.01, 0.01, 0.001])
NOTHING = Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.bool_))
STEP = np.array([[100.0, 20.0, 3.0], [20.0, 100.0, -2.0], [3.0, -2.0, 50.0]])


def match(pose: SE2, covariance: Floats = SEEN) -> Match:
    return Match(MatchStatus.MATCHED, pose, covariance, 0.9)


def weighed(square: float) -> Floats:
    """Return a step's information where its positions err by so much more, squared."""
    by = np.diag([square, square, 1.0]) ** 0.5
    return np.asarray(np.linalg.inv(by @ np.linalg.inv(STEP) @ by), np.float64)


def test_odometry_counts_by_its_last_ten_metres() -> None:
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
def test_only_a_match_known_both_ways_judges(angle: float, worst: float, judges: bool) -> None:
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

    def take(self, moved: float, went: float, noise: float | None) -> None:
        """Take in a distance measured with a variance [m^2]; None where it is not seen."""
        self.variance += 0.03**2 * moved / 500.0
        if noise is None:
            return
        spread = math.sqrt(noise + moved**2 * self.variance)
        off = max(-3.0 * spread, min(went - self.mean * moved, 3.0 * spread))
        went = self.mean * moved + off
        precision = 1.0 / self.variance + moved**2 / noise
        self.mean = (self.mean / self.variance + moved * went / noise) / precision
        self.variance = 1.0 / precision


def corridor(heading: float, along: float, across: float = 0.01) -> Floats:
    turn = SE2(0.0, 0.0, heading).matrix()
    known: Floats = turn @ np.diag([along**2, across**2, 1e-6]) @ turn.T
    return known


@pytest.mark.parametrize("seed", range(4))
def test_the_factor_is_that_of_the_distances_measured(seed: int) -> None:
    """Distances of 2 m or more, piecewise along a bend, between matches in one reference."""
    rng, stretch, expected = np.random.default_rng(seed), Stretch(), Expected()
    reference, pose = Field(0.05, 0.05), SE2(3.0, -1.0, 0.4)
    last = corridor(0.4, 0.01)
    stretch.judge(reference, match(pose, last), SE2(9.0))
    for _ in range(60):
        start, moved, first = pose, IDENTITY, last
        heading = math.atan2(*rng.normal(0.0, 1.0, 2).tolist())
        while math.hypot(moved.x, moved.y) < 2.0:
            delta = SE2(*rng.uniform((0.2, -0.1, -0.2), (0.9, 0.1, 0.2)).tolist())
            moved = moved @ delta
            length = rng.normal(1.04, 0.02 if rng.random() < 0.9 else 0.5)
            end = start @ SE2(length * moved.x, length * moved.y, moved.theta)
            last = corridor(heading, float(rng.choice([0.005, 0.024, 0.03])), 0.008)
            stretch.judge(reference, match(end, last), delta)
        pose = end
        gap = np.array([end.x - start.x, end.y - start.y])
        axis = gap / np.hypot(*gap)
        seen = [float(axis @ known[:2, :2] @ axis) for known in (first, last)]
        noise = sum(seen) if max(seen) <= 0.025**2 else None
        expected.take(math.hypot(moved.x, moved.y), float(np.hypot(*gap)), noise)
        assert stretch.factor == pytest.approx(expected.mean, abs=1e-9)
    assert stretch.of(SE2(2.0, -1.0, 0.3)) == SE2(2.0 * stretch.factor, -stretch.factor, 0.3)


def test_a_distance_ends_with_its_reference_or_a_failed_match() -> None:
    reference = Field(0.05, 0.05)
    failed = Match(MatchStatus.LOW_RESPONSE, SE2(), SEEN, 0.1)
    for between in ((reference, failed), (Field(0.05, 0.05), match(SE2(70.0)))):
        stretch, expected = Stretch(), Expected()
        for x, moved in ((5.0, 0.0), (6.0, 1.0)):
            stretch.judge(reference, match(SE2(x)), SE2(moved))
        stretch.judge(*between, SE2(1.5))
        for x, moved in ((20.0, 1.9), (21.1, 1.0)):  # from 20 m on again
            stretch.judge(reference, match(SE2(x)), SE2(moved))
        assert stretch.factor == 1.0
        stretch.judge(reference, match(SE2(22.2)), SE2(1.0))
        expected.take(2.0, 2.2, 2e-4)
        assert stretch.factor == pytest.approx(expected.mean)


@dataclass
class Scripted(ScanMatcher):
    """A matcher that tracks as scripted, and finds all it searches."""

    status: MatchStatus = MatchStatus.MATCHED
    known: Floats = field(default_factory=lambda: KNOWN)
    responses: tuple[float, ...] = (0.6,)  # of its searches; the last one's of all others
    response: float = 0.5  # of what it tracks
    offset: float = 0.02  # of what it searches [m]
    tracked: list[Any] = field(default_factory=list)
    searched: list[Any] = field(default_factory=list)

    def track(self, *how: Any) -> Match:
        self.tracked.append(how)
        return Match(self.status, how[2] @ SE2(0.01), self.known, self.response)

    def match(self, *how: Any) -> Match:
        response = self.responses[min(len(self.searched), len(self.responses) - 1)]
        self.searched.append(how)
        return Match(MatchStatus.MATCHED, how[2] @ SE2(self.offset), self.known, response)


@pytest.mark.parametrize(
    ("search", "status", "response", "asked"),
    [
        (False, MatchStatus.MATCHED, 0.5, (1, 0)),
        (False, MatchStatus.MATCHED, 0.4, (1, 1)),
        (False, MatchStatus.TOO_FEW_POINTS, 0.0, (1, 0)),
        (False, MatchStatus.LOW_RESPONSE, 0.2, (1, 1)),
        (False, MatchStatus.NOT_CONVERGED, 0.6, (1, 1)),
        (True, MatchStatus.MATCHED, 0.5, (0, 1)),
    ],
)
def test_a_scan_is_searched_where_it_is_due_or_tracking_fails(
    search: bool, status: MatchStatus, response: float, asked: tuple[int, int]
) -> None:
    scripted, reference = Scripted(status, response=response), Field(0.05, 0.05)
    last = SE2(2.0, 1.0, math.pi / 2)
    tracker = Tracker(TrackerConfig(), scripted)
    information = np.linalg.inv(KNOWN)
    match = tracker.locate(reference, NOTHING, last, SE2(0.5), information, search)
    assert (len(scripted.tracked), len(scripted.searched)) == asked
    for how in scripted.tracked + scripted.searched:
        assert how[0] is reference
        assert how[2].array() == pytest.approx((2.0, 1.5, math.pi / 2))
        np.testing.assert_allclose(how[-1], information)
    for how in scripted.searched:
        assert how[3:5] == (Window(0.5, 0.349, 3, 0.25, 1.0, 0.8, 0.9), 0.3)
    assert match.T_field_base.y == pytest.approx(1.52 if asked[1] else 1.51)


@pytest.mark.parametrize(
    ("responses", "width", "widest", "searched", "best"),
    [
        ((0.5,), 0.5, 2.0, [0.25], 0.5),
        ((0.1, 0.9), 0.5, 2.0, [0.25, 0.5], 0.9),
        ((0.1, 0.4, 0.3), 0.5, 2.0, [0.25, 0.5, 1.0], 0.4),
        ((0.1,), 0.6, 2.0, [0.3, 0.6], 0.1),
        ((0.1,), 0.5, 0.0, [0.25], 0.1),
        ((0.1,), 0.0, 2.0, [0.0], 0.1),
    ],
)
def test_what_matches_badly_is_searched_for_farther_away(
    responses: tuple[float, ...], width: float, widest: float, searched: list[float], best: float
) -> None:
    config = TrackerConfig(
        correlation_search_space_dimension=width, widest_search_space_dimension=widest
    )
    scripted = Scripted(responses=responses)
    tracker = Tracker(config, scripted)
    match = tracker.locate(Field(0.05, 0.05), NOTHING, SE2(), SE2(), np.linalg.inv(KNOWN), True)
    assert [how[3].xy for how in scripted.searched] == pytest.approx(searched)
    penalties = [0.25 * 4.0**k for k in range(len(searched))]
    assert [how[3].distance_penalty for how in scripted.searched] == pytest.approx(penalties)
    assert [how[3].angle_penalty for how in scripted.searched] == pytest.approx(
        [4.0 * penalty for penalty in penalties]
    )
    angles = [0.349 * 2.0**k for k in range(len(searched))]
    assert [how[3].theta for how in scripted.searched] == pytest.approx(angles)
    assert match.response == best


@pytest.mark.parametrize(
    ("gaps", "response"),
    [
        ((0.1,), 0.1),
        ((0.6,), 0.4),
        ((0.1, 0.1), 0.1),
        ((0.3, 0.3), 0.4),  # the time since a scan that matched
    ],
)
def test_nothing_slips_far_in_no_time(gaps: tuple[float, ...], response: float) -> None:
    tracker = Tracker(TrackerConfig(), Scripted())
    known, field = np.linalg.inv(KNOWN), Field(0.05, 0.05)
    tracker.locate(field, NOTHING, SE2(), SE2(), known, True, 0.1)
    for gap in gaps:
        tracker._matcher = Scripted(responses=(0.1, 0.4), offset=1.0)
        match = tracker.locate(field, NOTHING, SE2(), SE2(), known, True, gap)
    assert match.response == response


def test_odometry_is_followed_where_scans_shall_not_correct_it() -> None:
    assert TrackerConfig(minimum_distance_penalty=0.3).window.floor_xy == 0.3
    tracker = Tracker(TrackerConfig(use_scan_matching=False), Scripted())
    information: Floats = np.diag([100.0, 50.0, 20.0])
    match = tracker.locate(Field(0.05, 0.05), NOTHING, SE2(1.0), SE2(0.5), information, True)
    assert (match.status, match.T_field_base, match.response) == (
        MatchStatus.MATCHED,
        SE2(1.5),
        0.0,
    )
    np.testing.assert_allclose(match.covariance, np.diag([0.01, 0.02, 0.05]))


def test_what_matches_say_of_odometry_is_learnt() -> None:
    """Each metre is found to be a centimetre longer, a tenth of what odometry may err by."""
    scripted, reference = Scripted(known=1e-4 * KNOWN), Field(0.05, 0.05)
    tracker, pose = Tracker(TrackerConfig(), scripted), SE2()
    information = np.asarray(np.linalg.inv(KNOWN), np.float64)
    for _ in range(30):
        pose = tracker.locate(reference, NOTHING, pose, SE2(1.0), information, False).T_field_base
    lengths = [how[2].x - before[2].x - 0.01 for before, how in pairwise(scripted.tracked)]
    assert np.all(np.diff(lengths) >= -1e-12)
    assert lengths[0] == pytest.approx(1.0)
    assert lengths[-1] > 1.05
    longer = tracker.stretched(SE2(1.0, 0.0, 0.3))
    assert longer.array() == pytest.approx((lengths[-1], 0.0, 0.3), abs=0.01)
    weights = [how[3][0, 0] / information[0, 0] for how in scripted.tracked]
    assert weights[0] == 1.0
    assert weights[1] == pytest.approx(1.0 / (1.0 - 0.1 * (1.0 - 0.5 * 0.01)))  # a tenth is newer
