"""Claims: what lies on both sides of a stretch that only odometry knows is not known well."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.loops import LoopCloser
from arjuna_slam.graph.pose_graph import EdgeKind, PoseGraph
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.scan_matcher import ScanMatcher
from arjuna_slam.matching.surface import extract
from arjuna_slam.slam import Slam
from tests.helpers.loop_measures import is_wrong
from tests.slam.slam_room import box, scan_at

ROOMS = np.concatenate([box(0.0, 0.0, 7.0, 4.0), box(8.0, -1.0, 13.0, 5.0)])
ROOMS = np.concatenate([ROOMS, box(1.5, 0.5, 2.0, 0.9), box(10.5, 3.0, 11.0, 4.0)])


def in_the_dark(turn: float) -> list[tuple[Scan, SE2, SE2]]:
    """Scan, odometry and true pose on a way out of one room into the next.

    Between them nothing is seen, and odometry turns by so much [rad].
    """
    rng = np.random.default_rng(3)
    way = [SE2(5.0 + 0.25 * k, 2.0 + 0.1 * math.sin(k), 0.05 * math.cos(k)) for k in range(28)]
    log, odometry = [], SE2()
    for k, (before, truth) in enumerate(pairwise(way)):
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


def torn(gap: Floats) -> Submap:
    """Two keyframes 2 m apart in a corner, the second placed with a gap before it."""
    submap = Submap(SlamConfig().field())
    for node, x in enumerate((2.0, 4.0)):
        scan = scan_at(ROOMS, SE2(x, 2.0, 0.0), beams=180)
        unseen = gap if node else np.zeros((3, 3))
        submap.insert(node, extract(scan, 20.0), SE2(x - 2.0, 0.0, 0.0), unseen)
    return submap


@pytest.mark.parametrize(("heading", "known"), [(0.0, True), (0.1, False)])
def test_a_closure_with_a_torn_submap_knows_it_as_badly_as_the_tear(
    heading: float, known: bool
) -> None:
    submap = torn(np.diag([0.2**2, 0.2**2, heading**2]))
    graph = PoseGraph()
    for x in (0.0, 2.0, 0.5):
        graph.add_node(SE2(x, 0.0, 0.0))
    surface = extract(scan_at(ROOMS, SE2(2.5, 2.0, 0.0)), 20.0)
    closer = LoopCloser(SlamConfig(), ScanMatcher(SlamConfig()))
    edge = closer.close_by_hand(graph, 2, SE2(0.6, 0.1, 0.0), surface, [submap])
    assert edge is not None
    deviation = np.sqrt(np.linalg.inv(edge.information).diagonal())
    assert (deviation[2] < 0.01) == (deviation[0] < 0.05) == known
