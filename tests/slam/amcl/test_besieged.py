"""Claims: people about the robot do not make it lost, and do not hide that it is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Status
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.recovery import MapMatcher, Recovery
from arjuna_slam.amcl.scan_view import ScanView
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import Robot, error, random_pose, room_map, scan_at

_RADIUS = 0.25  # of a person [m]
_HIDES = 0.05  # that a beam must be shorter for it [m]
_MOST = 300  # people tried


def besieged(
    scan: Scan, share: float, rng: np.random.Generator, near: tuple[float, float] = (0.05, 1.0)
) -> Scan:
    """Return a scan in which people stop at least a share of the beams, if so many find room.

    Args:
        scan: Of walls alone.
        share: 0..1.
        rng: For where they stand.
        near: From the lidar to them, at least and at most [m].
    """
    ranges = scan.ranges
    for _ in range(_MOST):
        if np.mean(ranges < scan.ranges - _HIDES) >= share:
            break
        away, bearing = rng.uniform(*near) + _RADIUS, rng.uniform(-math.pi, math.pi)
        facing = int(np.argmax(np.cos(scan.angles - bearing)))
        if scan.ranges[facing] > away:
            ranges = np.minimum(ranges, _to_person(scan.angles, away, bearing))
    return replace(scan, ranges=ranges)


def _to_person(angles: Floats, away: float, bearing: float) -> Floats:
    along, across = away * np.cos(angles - bearing), away * np.sin(angles - bearing)
    depth = _RADIUS**2 - across**2
    ranges: Floats = np.where(
        (depth > 0.0) & (along > 0.0), along - np.sqrt(np.maximum(depth, 0.0)), np.inf
    )
    return ranges


CONFIG = AmclConfig()
ROOM = room_map()
MATCHER = MapMatcher(CONFIG, MapField(ROOM, CONFIG.laser_likelihood_max_dist))
SHARES = (0.2, 0.4, 0.5, 0.6, 0.7)


def view_at(truth: SE2, share: float, rng: np.random.Generator) -> ScanView:
    return ScanView.of(besieged(scan_at(truth, 0.0, rng), share, rng), CONFIG)


@pytest.mark.parametrize("share", SHARES)
def test_who_stands_about_the_robot_speaks_little_against_its_pose(share: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        assert MATCHER.agreement(truth, view_at(truth, share, rng)) > CONFIG.relocalize_agreement


@pytest.mark.parametrize("share", [0.0, *SHARES])
def test_another_pose_is_not_taken_for_the_robots_though_people_stand_about(share: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth, other = random_pose(rng), random_pose(rng)
        assert MATCHER.agreement(other, view_at(truth, share, rng)) < CONFIG.relocalize_agreement


@pytest.mark.parametrize(("length", "weight"), [(3.5, 0.5), (0.3, 0.05)])
def test_beams_that_end_early_count_half_from_afar_and_next_to_nothing_near_by(
    length: float, weight: float
) -> None:
    scan = scan_at(SE2(), 0.0, np.random.default_rng(0))
    early = (np.arange(360) < 180) & (scan.ranges > 4.0)
    ranges, share = np.where(early, length, scan.ranges), float(early.mean())
    found = MATCHER.agreement(SE2(), ScanView.of(replace(scan, ranges=ranges), CONFIG))
    assert found == pytest.approx((1.0 - share) / (1.0 - share + weight * share), abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_among_people_is_not_lost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot, belief = Robot(rng), ParticleFilter(CONFIG, ROOM, np.random.default_rng(seed + 1000))
    belief.set_pose(robot.pose, np.diag([0.01, 0.01, 0.01]))
    for _ in range(40):
        scan = besieged(robot.step(), 0.6, np.random.default_rng(seed))
        estimate = belief.update(robot.odometry, scan)
        assert estimate is not None
        assert estimate.status is Status.TRACKING
        assert error(estimate.T_map_base, robot.pose)[0] < 0.15


def test_a_robot_is_looked_for_without_the_beams_that_people_stop() -> None:
    recovery, found = Recovery(CONFIG, MATCHER), 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        best = recovery.propose(view_at(truth, 0.5, rng), [])[0]
        found += error(best.T_map_base, truth)[0] < 0.1
    assert found >= 8
