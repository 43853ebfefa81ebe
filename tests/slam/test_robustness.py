"""Claims: what robots meet breaks no map, and what is no scan moves nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, room
from tests.slam.trials import SCENARIOS, measure, room_log, spoil

SIGMA = 0.01


@pytest.fixture(scope="module")
def log() -> Log:
    return room_log(3)


@pytest.mark.parametrize("name", SCENARIOS)
def test_no_map_breaks_and_no_pose_is_5_cm_off(log: Log, name: str) -> None:
    scenario = SCENARIOS[name]
    figures = measure(spoil(log, scenario, SIGMA, 3), room())
    assert not figures.broken
    assert figures.rmse < (0.02 if scenario.noise == 1.0 else 0.05)
    assert figures.map_error < (0.02 if scenario.noise == 1.0 else 0.04)
    assert figures.drift > (0.9 if scenario.slip > 1.0 else 0.3)


def _with(scan: Scan, ranges: float) -> Scan:
    return dataclasses.replace(scan, ranges=np.full(len(scan.ranges), ranges))


def test_bad_scans_among_good_ones_change_no_pose(log: Log) -> None:
    rng = np.random.default_rng(4)
    plain, mixed = Slam(), Slam()
    fed = 0
    for scan, odometry, _ in log[:250]:
        bad = [
            _with(scan, math.nan),
            _with(scan, 0.0),
            _with(scan, -1.0),
            dataclasses.replace(scan, ranges=np.zeros(0)),
            dataclasses.replace(scan, angle_increment=math.nan),
            dataclasses.replace(scan, angle_increment=0.0),
            dataclasses.replace(scan, stamp=math.nan),
            dataclasses.replace(scan, stamp=scan.stamp - 5.0 if fed else math.inf),
        ]
        for k in rng.integers(0, len(bad), 3):
            wrong = SE2(rng.normal(), rng.normal(), rng.normal())
            assert mixed.process(bad[k], wrong) is None
            fed += 1
        one, other = plain.process(scan, odometry), mixed.process(scan, odometry)
        assert one is not None
        assert other is not None
        assert one.T_map_base == other.T_map_base
        assert mixed.process(scan, odometry) is None  # sent twice
        fed += 1
    assert plain.graph.poses.tobytes() == mixed.graph.poses.tobytes()
    assert mixed.scans.skipped == fed
    assert set(Skip) - {reason for reason, n in mixed.scans.counts.items() if n} == {Skip.LOST}


def test_scans_of_a_few_beams_or_of_noise_alone_leave_no_trace_in_the_pose(log: Log) -> None:
    rng = np.random.default_rng(5)
    slam, T_world_map = Slam(), log[0][2] @ log[0][1].inverse()
    for k, (scan, odometry, truth) in enumerate(log[:80]):
        if k % 10 == 5:
            scan = dataclasses.replace(scan, ranges=scan.ranges[:3])
        if k % 10 == 8:
            scan = dataclasses.replace(scan, ranges=rng.uniform(0.2, 9.0, 360))
        update = slam.process(scan, odometry)
        assert update is not None
        assert (T_world_map @ update.T_map_base).distance(truth) < 0.05
