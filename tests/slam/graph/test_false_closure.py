"""A loop closure that is wrong, forced into the graph past all checks."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.slam import Slam
from tests.slam.slam_room import distance_to_walls, drive, room

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
