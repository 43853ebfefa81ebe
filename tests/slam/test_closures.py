"""Closures that are wrong and steps that nobody has seen: what the graph makes of them."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.slam import Slam
from tests.bench.loops import attempt
from tests.helpers.building_drives import LIDARS, Drift, is_wrong, near_pairs
from tests.helpers.building_drives import drive as drive_through
from tests.helpers.buildings import KINDS, RESOLUTION, Building, building
from tests.slam.slam_room import ROOMS, distance_to_walls, drive, room, scan_at

LOG = drive(seed=5, laps=1.5)
CERTAIN = np.diag([4e4, 4e4, 2.5e5])  # 5 mm and 2 mrad: as certain as a match gets


def mapped(at: int | None = None, off: SE2 | None = None) -> Slam:
    """Map the log; when there are `at` keyframes, join the last to an early one, wrongly."""
    slam = Slam()
    for scan, odometry, _ in LOG:
        update = slam.process(scan, odometry)
        if off is not None and update is not None and update.keyframe and len(slam.graph) == at:
            first, last = at // 3, at - 1
            false = slam.graph.pose(first).inverse() @ slam.graph.pose(last) @ off
            slam.graph.add_edge(Edge(first, last, false, CERTAIN, EdgeKind.LOOP))
    slam.optimize()
    return slam


def errors(slam: Slam) -> tuple[float, float]:
    """Mean distance of occupied cells to walls and worst error of a keyframe [m]."""
    T_world_map = LOG[0][2]
    grid = slam.map()
    assert grid is not None
    cells = grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64))
    truth = {scan.stamp: pose for scan, _, pose in LOG}
    worst = max((T_world_map @ pose).distance(truth[t]) for t, pose in slam.trajectory())
    return float(distance_to_walls(room(), T_world_map.apply(cells)).mean()), worst


@pytest.fixture(scope="module")
def clean() -> tuple[float, float]:
    return errors(mapped())


@pytest.mark.parametrize(
    "off", [SE2(0.25, 0.1, 0.05), SE2(1.0, -1.0, 0.2), SE2(-5.0, 3.0, 3.0)], ids=str
)
def test_a_false_closure_is_taken_back(clean: tuple[float, float], off: SE2) -> None:
    slam = mapped(45, off)
    assert slam.undone == 1
    assert not any((edge.i, edge.j) == (15, 44) for edge in slam.graph.edges)
    assert errors(slam)[0] < 1.1 * clean[0]
    assert errors(slam)[1] < 2.0 * clean[1]


def test_a_false_closure_at_the_end_is_not_believed(clean: tuple[float, float]) -> None:
    slam = mapped(85, SE2(1.0, -1.0, 0.2))
    assert errors(slam)[0] < 1.1 * clean[0]
    assert errors(slam)[1] < 2.0 * clean[1]


def in_the_dark(turn: float) -> list[tuple[Scan, SE2, SE2]]:
    """Scan, odometry and true pose on a drive out of one room into the next.

    Between them nothing is seen, and odometry turns by so much [rad].
    """
    rng = np.random.default_rng(3)
    path = [SE2(5.0 + 0.25 * k, 2.0 + 0.1 * math.sin(k), 0.05 * math.cos(k)) for k in range(28)]
    log, odometry = [], SE2()
    for k, (before, truth) in enumerate(pairwise(path)):
        step = before.inverse() @ truth
        dark = 6.6 < truth.x < 8.6
        off = turn / 8.0 if dark else 0.0
        odometry = odometry @ SE2(step.x, step.y, step.theta + off)
        scan = scan_at(ROOMS, truth, sigma=0.01, rng=rng, stamp=float(k))
        if not dark:
            log.append((scan, odometry, truth))
    return log


@pytest.mark.parametrize("turn", [0.2, -0.2])
def test_no_match_claims_to_know_what_lay_in_the_dark(turn: float) -> None:
    log = in_the_dark(turn)
    slam = Slam()
    for scan, odometry, _ in log:
        slam.process(scan, odometry)
    truth = {scan.stamp: pose for scan, _, pose in log}
    nodes = [truth[scan.stamp] for scan in slam.keyframes.scans]
    matches = [edge for edge in slam.graph.edges if edge.kind is EdgeKind.MATCH]
    assert len(matches) > 10
    assert not [(edge.i, edge.j) for edge in matches if is_wrong(edge, nodes)]


STIFF = np.diag([1e4, 1e4, 1e5])


@pytest.mark.parametrize("seed", range(2 * len(KINDS)))
def test_no_drive_goes_through_a_wall(seed: int) -> None:
    _, walls = building(seed, 0.2)
    log = drive_through(walls, seed, 150.0, 0.5, LIDARS[0], Drift())
    cells = [(int(pose.y / RESOLUTION), int(pose.x / RESOLUTION)) for _, _, pose in log]
    assert not any(walls.blocked[cell] for cell in cells)
    assert min(float(scan.ranges.min()) for scan, _, _ in log) > 0.05


def test_odometry_errs_by_its_drift() -> None:
    _, walls = building(0, 0.2)
    log = drive_through(walls, 0, 200.0, 1.0, LIDARS[0], Drift(walk=0.0, bias=0.01, scale=0.0))
    odometry = np.unwrap([pose.theta for _, pose, _ in log])
    truth = np.unwrap([pose.theta for _, _, pose in log])
    off = (odometry - odometry[0]) - (truth - truth[0])
    steps = [a[2].distance(b[2]) for a, b in pairwise(log)]
    assert abs(off[-1]) == pytest.approx(0.01 * sum(steps), rel=1e-6)


def test_poses_on_two_sides_of_a_wall_are_not_near() -> None:
    blocked = np.zeros((100, 100), np.bool_)
    blocked[:, 50:52] = True
    poses = np.array([(2.2, 1.0, 0.0), (2.2, 30.0, 0.0), (3.0, 1.0, 0.0), (2.0, 1.2, 0.0)])
    assert near_pairs(poses, Building(blocked)).tolist() == [[0, 3]]


def test_a_closure_is_wrong_only_where_it_claims_to_know() -> None:
    truth = [SE2(), SE2(3.0, 0.0, 0.5)]
    off = Edge(0, 1, SE2(4.0, 0.0, 0.5), STIFF, EdgeKind.LOOP)
    vague = Edge(0, 1, SE2(4.0, 0.0, 0.5), np.diag([1.0, 1e4, 1e5]), EdgeKind.LOOP)
    turned = Edge(0, 1, SE2(3.0, 0.0, 0.5 + 2.0 * math.pi), STIFF, EdgeKind.LOOP)
    assert is_wrong(off, truth)
    assert not is_wrong(vague, truth)
    assert not is_wrong(turned, truth)


def test_a_small_building_is_mapped_without_an_open_loop() -> None:
    trial = attempt(1, 0.1, 200.0, Drift().times(0.5))
    assert trial.pairs > 20
    assert trial.agree == 1.0
    assert trial.wrong == 0
    assert trial.found == trial.loops
