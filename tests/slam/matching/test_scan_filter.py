"""From a scan to where it lies: which are used, how they are straightened, tracked or searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_filter import LastOdometry, ScanFilter, Skip, motion_within
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface
from arjuna_slam.matching.tracking import Tracker, TrackerConfig

GOOD = Scan(np.full(30, 2.0), -1.0, 0.1, 0.1, 9.0, 5.0)
NOTHING = Surface(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.bool_))
KNOWN = np.diag([0.01, 0.01, 0.001])


@pytest.mark.parametrize(
    ("scan", "reason"),
    [
        (replace(GOOD, stamp=math.nan), Skip.STAMP),
        (replace(GOOD, stamp=math.inf), Skip.STAMP),
        (replace(GOOD, stamp=5.0), Skip.STALE),
        (replace(GOOD, stamp=4.0), Skip.STALE),
        (replace(GOOD, stamp=5.1), None),
        (replace(GOOD, stamp=6.0, angle_min=math.nan), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, angle_increment=math.inf), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, angle_increment=0.0), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, angle_increment=0.0, ranges=np.ones(2)), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, angle_increment=0.0, ranges=np.ones(1)), None),
        (replace(GOOD, stamp=6.0, range_min=math.nan), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, range_max=math.nan), Skip.GEOMETRY),
        (replace(GOOD, stamp=6.0, range_max=math.inf), None),
        (replace(GOOD, stamp=6.0, ranges=np.full(30, 7.5)), Skip.EMPTY),
        (replace(GOOD, stamp=6.0, ranges=np.full(30, math.inf)), Skip.EMPTY),
    ],
)
def test_a_scan_that_cannot_be_used_is_counted_by_its_reason(
    scan: Scan, reason: Skip | None
) -> None:
    intake = ScanFilter(7.0)
    assert intake.last is None
    first = intake.take(GOOD)
    assert first is not None
    assert len(first) == 30
    assert (intake.take(scan) is None) is (reason is not None)
    assert intake.last is reason
    assert intake.counts == {each: int(each is reason) for each in Skip}
    assert intake.skipped == int(reason is not None)
    late = intake.take(replace(GOOD, stamp=5.5))  # only what was used makes others stale
    assert (late is None) is (reason is None and scan.stamp > 5.5)


@pytest.mark.parametrize(
    ("increment", "gap", "share"),
    [
        (0.001, 0.2, 0.5),  # 101 beams take 0.1 s
        (-0.001, 0.2, -0.5),
        (0.002, 0.1, 2.0),
        (0.0021, 0.1, 0.0),  # longer than two gaps: a mistake
        (-0.0021, 0.1, 0.0),
        (0.001, 0.0, 0.0),
        (0.001, -0.2, 0.0),
    ],
)
def test_the_motion_within_a_scan_is_that_before_it_for_as_long(
    increment: float, gap: float, share: float
) -> None:
    """Half of a motion is that which done twice is all of it."""
    scan = Scan(np.ones(101), 0.0, 0.01, 0.1, 9.0, 1.0, time_increment=increment)
    half = SE2(0.3, -0.1, 0.4)
    steps = {0.5: half, -0.5: half.inverse(), 2.0: half @ half @ half @ half, 0.0: IDENTITY}
    motion = motion_within(scan, half @ half, gap)
    assert motion.array() == pytest.approx(steps[share].array(), abs=1e-12)
    odometry, start = LastOdometry(), SE2(3.0, 2.0, 1.0)
    odometry.advance(0.0, start)
    straight = odometry.with_motion(replace(scan, stamp=gap), start @ half @ half)
    assert straight.motion.array() == pytest.approx(steps[share].array(), abs=1e-9)


def test_a_scan_taken_at_once_is_not_straightened() -> None:
    odometry = LastOdometry()
    assert odometry.with_motion(GOOD, SE2()) is GOOD
    odometry.advance(GOOD.stamp, SE2())
    later = replace(GOOD, stamp=6.0)
    assert odometry.with_motion(later, SE2(1.0)) is later


@pytest.mark.parametrize(
    ("delta", "due"),
    [
        (SE2(0.14, 0.14, 0.19), False),
        (SE2(0.15, -0.15, 0.0), True),
        (SE2(0.2, 0.0, 0.0), True),
        (SE2(0.0, 0.0, -0.21), True),
        (SE2(0.0, 0.0, 2.0 * math.pi - 0.1), False),
    ],
)
def test_a_keyframe_is_due_after_a_way_or_a_turn(delta: SE2, due: bool) -> None:
    assert SlamConfig().keyframe_due(delta) is due


@pytest.mark.parametrize("odometry", [0.1, 0.2])
def test_odometry_errs_with_the_way_and_the_turn(odometry: float) -> None:
    """A way of 5 m and a turn of 2 rad: 0.01 m and 5.4 parts of a metre, 0.005 rad and 4.5."""
    known = SlamConfig(odometry_deviation=odometry).odometry_covariance(SE2(3.0, -4.0, -2.0))
    position, heading = 0.01 + 5.4 * odometry, 0.005 + 4.5 * odometry
    np.testing.assert_allclose(known, np.diag([position**2, position**2, heading**2]))


@dataclass
class Told(ScanMatcher):
    """A matcher that tracks as it is told, and finds all it searches."""

    status: MatchStatus = MatchStatus.MATCHED
    known: Floats = field(default_factory=lambda: KNOWN)
    tracked: list[Any] = field(default_factory=list)
    searched: list[Any] = field(default_factory=list)

    def track(self, *how: Any) -> Match:
        self.tracked.append(how)
        return Match(self.status, how[2] @ SE2(0.01), self.known, 0.5)

    def match(self, *how: Any) -> Match:
        self.searched.append(how)
        return Match(MatchStatus.MATCHED, how[2] @ SE2(0.02), self.known, 0.6)


@pytest.mark.parametrize(
    ("search", "status", "asked"),
    [
        (False, MatchStatus.MATCHED, (1, 0)),
        (False, MatchStatus.TOO_FEW_POINTS, (1, 0)),
        (False, MatchStatus.LOW_RESPONSE, (1, 1)),
        (False, MatchStatus.NOT_CONVERGED, (1, 1)),
        (True, MatchStatus.MATCHED, (0, 1)),
    ],
)
def test_a_scan_is_searched_where_it_is_due_or_tracking_fails(
    search: bool, status: MatchStatus, asked: tuple[int, int]
) -> None:
    told, reference, last = Told(status), Field(0.05, 0.05), SE2(2.0, 1.0, math.pi / 2)
    tracker = Tracker(TrackerConfig(), told)
    information = np.linalg.inv(KNOWN)
    match = tracker.locate(reference, NOTHING, last, SE2(0.5), information, search)
    assert (len(told.tracked), len(told.searched)) == asked
    for how in told.tracked + told.searched:
        assert how[0] is reference
        assert how[2].array() == pytest.approx((2.0, 1.5, math.pi / 2))
        np.testing.assert_allclose(how[-1], information)
    for how in told.searched:
        assert how[3:5] == (Window(0.5, 0.349, 3, 0.25, 1.0, 0.8, 0.9), 0.3)
    assert match.T_field_base.y == pytest.approx(1.52 if asked[1] else 1.51)


def test_odometry_is_followed_where_scans_shall_not_correct_it() -> None:
    tracker = Tracker(TrackerConfig(use_scan_matching=False), Told())
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
    told, reference = Told(known=1e-4 * KNOWN), Field(0.05, 0.05)
    tracker, pose = Tracker(TrackerConfig(), told), SE2()
    information = np.asarray(np.linalg.inv(KNOWN), np.float64)
    for _ in range(30):
        pose = tracker.locate(reference, NOTHING, pose, SE2(1.0), information, False).T_field_base
    lengths = [how[2].x - before[2].x - 0.01 for before, how in pairwise(told.tracked)]
    assert np.all(np.diff(lengths) >= -1e-12)
    assert lengths[0] == pytest.approx(1.0)
    assert lengths[-1] > 1.05
    longer = tracker.stretched(SE2(1.0, 0.0, 0.3))
    assert longer.array() == pytest.approx((lengths[-1], 0.0, 0.3), abs=0.01)
    worth = [how[3][0, 0] / information[0, 0] for how in told.tracked]
    assert worth[0] == 1.0
    assert worth[1] == pytest.approx(1.0 / (1.0 - 0.1 * (1.0 - 0.5 * 0.01)))  # a tenth is newer
