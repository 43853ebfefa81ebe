"""From a scan to where it lies: which are used, how they are straightened, tracked or searched."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.matching.scan_filter import LastOdometry, ScanFilter, Skip, motion_within
from arjuna_slam.matching.surface import Surface

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
        (replace(GOOD, stamp=6.0, ranges=np.full(30, 7.5)), None),
        (replace(GOOD, stamp=6.0, ranges=np.full(30, math.inf)), None),
        (replace(GOOD, stamp=6.0, ranges=np.full(30, math.nan)), Skip.EMPTY),
        (replace(GOOD, stamp=6.0, ranges=np.full(30, 0.0)), Skip.EMPTY),
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
