"""Between two updates of the particles: what is followed, and what says nothing new."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Status
from arjuna_slam.amcl.filter import ParticleFilter
from tests.slam.amcl.room import room_map, scan_at

ROOM = room_map()
START = SE2(0.5, 1.0, 0.3)


def started() -> tuple[ParticleFilter, SE2]:
    """Return a filter that has seen one scan, and odometry then."""
    some = ParticleFilter(AmclConfig(), ROOM, np.random.default_rng(1))
    odometry = SE2(7.0, -3.0, 2.0)
    some.set_pose(START, np.diag([1e-3, 1e-3, 1e-3]))
    estimate = some.update(odometry, seen(START, 0.0))
    assert estimate is not None
    assert estimate.status is Status.TRACKING
    return some, odometry


def seen(pose: SE2, stamp: float) -> Scan:
    return scan_at(pose, stamp, np.random.default_rng(3))


def blind(stamp: float) -> Scan:
    return replace(seen(START, stamp), ranges=np.full(360, np.inf))


@pytest.mark.parametrize("step", [SE2(), SE2(0.1, 0.0, 0.05), SE2(0.2, 0.0, 0.1)])
def test_a_blind_scan_on_the_way_says_nothing(step: SE2) -> None:
    some, odometry = started()
    assert some.update(odometry @ step, blind(0.1)) is None
    forced = some.update(odometry @ step, blind(0.2), force=True)
    assert forced is not None
    assert forced.status is Status.BLIND
    assert forced.T_map_base.distance(START @ step) < 0.05


def test_a_robot_that_stands_where_it_was_has_nothing_to_say() -> None:
    some, odometry = started()
    assert some.update(odometry, seen(START, 0.1)) is None
    assert some.update(odometry @ SE2(0.0005), seen(START, 0.2)) is None


@pytest.mark.parametrize("slip", [SE2(), SE2(0.03, -0.02, 0.02)])
def test_on_the_way_the_pose_follows_the_scan_and_the_particles_wait(slip: SE2) -> None:
    some, odometry = started()
    before = some.particles.copy()
    step = SE2(0.15, 0.05, 0.1)
    estimate = some.update(odometry @ step @ slip, seen(START @ step, 0.1))
    assert estimate is not None
    assert estimate.T_map_base.distance(START @ step) < 0.02
    found = estimate.T_map_odom @ odometry @ step @ slip
    assert found.array() == pytest.approx(estimate.T_map_base.array())
    np.testing.assert_array_equal(some.particles, before)
    assert (
        ParticleFilter(AmclConfig(), ROOM, np.random.default_rng(1)).update(SE2(), blind(0)) is None
    )
