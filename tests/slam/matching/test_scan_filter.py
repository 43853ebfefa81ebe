"""Scans that are filtered, and contradictions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_slam.matching.contradiction import gone_through, longest, seen_and_contradicted
from arjuna_slam.matching.scan_filter import LastOdometry, ScanFilter, Skip, motion_within
from arjuna_slam.matching.surface import Surface
from tests.slam.slam_room import box, scan_at

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
def test_an_unusable_scan_is_counted_by_its_reason(scan: Scan, reason: Skip | None) -> None:
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
def test_motion_within_a_scan_is_that_before(increment: float, gap: float, share: float) -> None:
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


SHORT, LONG = box(0.0, 0.0, 6.0, 2.0), box(0.0, 0.0, 12.0, 2.0)
END = np.array([(6.0, y) for y in np.linspace(0.2, 1.8, 17)])
VIEWS = [SE2(1.0, 1.0, 0.3), SE2(3.0, 1.2, 2.0)]


def counts(points: Floats, scans: list[tuple[Scan, SE2]]) -> tuple[int, int]:
    """Return the numbers of points seen and contradicted."""
    seen, against = seen_and_contradicted(points, scans, 20.0)
    return int(seen.sum()), int(against.sum())


def test_beams_go_through_an_end_that_is_not_there() -> None:
    scans = [(scan_at(LONG, pose), pose) for pose in VIEWS]
    assert counts(END, scans) == (17, 17)


def test_an_end_that_is_there_is_seen() -> None:
    scans = [(scan_at(SHORT, pose, clockwise=True), pose) for pose in VIEWS]
    assert counts(END, scans) == (17, 0)


def verdict(point: Floats, scan: Scan, pose: SE2, range_max: float) -> str:
    """Return what the three beams beside a point say of it."""
    at = (pose @ scan.T_base_sensor).inverse().apply(point[None])[0]
    distance, bearing = math.hypot(*at), math.atan2(at[1], at[0])
    bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    off = [abs(wrap(float(each) - bearing)) for each in bearings]
    nearest = int(np.argmin(off))
    farthest = min(scan.range_max, range_max)
    if nearest in (0, len(bearings) - 1) or not scan.range_min <= distance < farthest:
        return ""
    beams = scan.ranges[nearest - 1 : nearest + 2].tolist()
    if not all(scan.range_min <= beam < farthest for beam in beams):
        return ""
    if min(beams) > distance + 0.4:
        return "through"
    return "on" if min(beams) - 0.2 < distance < max(beams) + 0.2 else ""


@pytest.mark.parametrize("seed", range(12))
def test_the_beams_beside_points_say_whether_they_are_there(seed: int) -> None:
    rng, turn = np.random.default_rng(seed), 0.1 * (-1) ** seed
    points = rng.uniform(-4.0, 4.0, (60, 2))
    scans = []
    for _ in range(3):
        ranges = np.repeat(rng.uniform(0.3, 8.0, 10), 4)
        ranges[rng.integers(0, 40, 4)] = rng.choice([math.inf, math.nan, 0.1, 6.9], 4)
        mount, pose = (SE2(*rng.uniform(-1.0, 1.0, 3).tolist()) for _ in range(2))
        first = float(rng.uniform(-3.0, 3.0))
        scans.append((Scan(ranges, first, turn, 0.5, 6.0, T_base_sensor=mount), pose))
    said = [[verdict(point, *each, 5.0 + seed % 3) for each in scans] for point in points]
    seen, against = seen_and_contradicted(points, scans, 5.0 + seed % 3)
    assert seen.tolist() == [any(each) for each in said]
    share = [each.count("through") > 0.7 * sum(map(bool, each)) for each in said]
    assert against.tolist() == share
    through = gone_through(points, scans, 5.0 + seed % 3)
    assert through.tolist() == ["through" in each for each in said]
    assert 0 < sum(share) < sum(map(any, said)) < len(points)


def test_the_longest_thing_is_one_without_gaps() -> None:
    near = np.array([(0.0, y) for y in np.linspace(0.0, 0.6, 13)])
    assert longest(np.concatenate((END, near))) == pytest.approx(1.6)
    assert longest(np.concatenate((near, near + np.array([0.0, 1.0])))) == pytest.approx(0.6)
    assert longest(np.zeros((0, 2))) == 0.0


def test_one_beam_is_enough_and_seven_of_ten_must_speak_against() -> None:
    true, false = (scan_at(SHORT, VIEWS[0]), VIEWS[0]), (scan_at(LONG, VIEWS[0]), VIEWS[0])
    assert counts(END[:1], [false]) == (1, 1)
    assert counts(END[:1], [true]) == (1, 0)
    assert counts(END, [false] * 3 + [true]) == (17, 17)
    assert counts(END, [false] * 2 + [true]) == (17, 0)
    assert counts(END, []) == (0, 0)
