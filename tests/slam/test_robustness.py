"""Claims: what robots meet breaks no map, and what is no scan moves nothing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.mapping.keyframes import Mapper
from arjuna_slam.matching.scan_filter import ScanFilter, Skip
from arjuna_slam.matching.surface import extract
from arjuna_slam.slam import Slam
from tests.slam.slam_room import room, scan_at
from tests.slam.trials import SCENARIOS, Figures, Log, measure, room_log, spoil

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


def test_a_map_that_is_broken_is_called_so(log: Log) -> None:
    blind = Slam(SlamConfig(use_scan_matching=False, do_loop_closing=False))
    assert measure(log, room(), blind).broken
    assert not Figures(0.01, 0.02, 0.02, 0.0, 1.0).broken


def test_each_scenario_does_what_it_says(log: Log) -> None:
    def spoilt(name: str) -> Log:
        return spoil(log, SCENARIOS[name], SIGMA, 0)

    assert len(spoilt("2 s without scans")) == pytest.approx(len(log) - 20, abs=1)
    lost = np.mean([np.isinf(scan.ranges).mean() for scan, _, _ in spoilt("30 % of beams lost")])
    assert lost == pytest.approx(0.3, abs=0.01)
    walked = spoilt("a person walks")
    hidden = [(s.ranges < t.ranges).sum() for (s, _, _), (t, _, _) in zip(walked, log, strict=True)]
    assert max(hidden) > 30
    assert min(hidden) > 0
    first = [spoilt("all of it")[9][0].ranges for _ in range(2)]
    assert first[0].tobytes() == first[1].tobytes()


def _with(scan: Scan, ranges: float) -> Scan:
    return dataclasses.replace(scan, ranges=np.full(len(scan.ranges), ranges))


def test_bad_scans_among_good_ones_change_no_pose(log: Log) -> None:
    rng = np.random.default_rng(4)
    plain, mixed = Slam(), Slam()
    fed = 0
    for scan, odometry, _ in log[:250]:
        bad = [
            _with(scan, math.nan),
            _with(scan, math.inf),
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
    slam = Slam()
    for k, (scan, odometry, truth) in enumerate(log[:250]):
        if k % 10 == 5:
            scan = dataclasses.replace(scan, ranges=scan.ranges[:3])
        if k % 10 == 8:
            scan = dataclasses.replace(scan, ranges=rng.uniform(0.2, 9.0, 360))
        update = slam.process(scan, odometry)
        assert update is not None
        assert (log[0][2] @ update.T_map_base).distance(truth) < 0.05


def test_the_filter_counts_by_reason() -> None:
    scans = ScanFilter(20.0)
    scan = scan_at(room(), SE2(5.0, 5.0, 0.0), stamp=1.0)
    assert scans.take(scan) is not None
    assert scans.last is None
    assert scans.take(scan) is None
    assert scans.last is Skip.STALE
    assert scans.take(dataclasses.replace(scan, stamp=2.0, range_max=math.nan)) is None
    assert scans.take(_with(dataclasses.replace(scan, stamp=2.0), math.nan)) is None
    assert scans.counts[Skip.STALE] == scans.counts[Skip.GEOMETRY] == scans.counts[Skip.EMPTY] == 1
    assert scans.skipped == 3
    assert scans.take(dataclasses.replace(scan, stamp=2.0)) is not None


def occupied(start: SE2) -> Floats:
    """Centres of the occupied cells, in the room, of a map that begins at a pose."""
    mapper = Mapper(0.05, 20.0)
    rng = np.random.default_rng(1)
    poses = [SE2(), SE2(0.6, 0.2, 0.4), SE2(-0.5, -0.4, 2.0), SE2(0.2, 0.7, 4.0)]
    for pose in poses:
        mapper.add(scan_at(room(), start @ pose, beams=720, sigma=SIGMA, rng=rng))
    grid = mapper.grid(np.array([pose.array() for pose in poses]))
    assert grid is not None
    cells = np.argwhere(grid.occupied()).astype(np.int64)
    return start.apply(grid.frame.to_points(cells))


def test_walls_at_round_coordinates_are_one_cell_thick() -> None:
    points = occupied(SE2(5.0, 5.0, 0.0))
    left = points[points[:, 0] < 0.08]
    assert len(left) > 140
    assert (np.abs(left[:, 0]) < 1e-9).mean() > 0.9


def test_a_wall_goes_on_where_beams_are_lost() -> None:
    scan = scan_at(room(), SE2(5.0, 5.0, 0.3), sigma=SIGMA, rng=np.random.default_rng(2))
    lost = np.where(np.random.default_rng(3).random(360) < 0.3, np.inf, scan.ranges)
    surface = extract(dataclasses.replace(scan, ranges=lost), 20.0)
    assert (np.abs(surface.normals).sum(axis=1) > 0.0).mean() > 0.8
    gap = np.where(np.arange(360) % 8 < 4, np.inf, scan.ranges)
    cut = extract(dataclasses.replace(scan, ranges=gap), 20.0)
    assert not cut.linked[3::4].any()
