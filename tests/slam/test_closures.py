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
from tests.helpers.loop_measures import is_wrong
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
