"""Claims: made-up buildings can be driven through, and what is measured in them is true."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from tests.bench.loops import attempt
from tests.helpers.building_drives import LIDARS, Drift, drive
from tests.helpers.buildings import KINDS, RESOLUTION, Building, building
from tests.helpers.loop_measures import is_wrong, near_pairs

CERTAIN = np.diag([1e4, 1e4, 1e5])


@pytest.mark.parametrize("seed", range(2 * len(KINDS)))
def test_no_drive_goes_through_a_wall(seed: int) -> None:
    _, walls = building(seed, 0.2)
    log = drive(walls, seed, 150.0, 0.5, LIDARS[0], Drift())
    cells = [(int(pose.y / RESOLUTION), int(pose.x / RESOLUTION)) for _, _, pose in log]
    assert not any(walls.blocked[cell] for cell in cells)
    assert min(float(scan.ranges.min()) for scan, _, _ in log) > 0.05


def test_odometry_errs_by_its_drift() -> None:
    _, walls = building(0, 0.2)
    log = drive(walls, 0, 200.0, 1.0, LIDARS[0], Drift(walk=0.0, bias=0.01, scale=0.0))
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
    off = Edge(0, 1, SE2(4.0, 0.0, 0.5), CERTAIN, EdgeKind.LOOP)
    vague = Edge(0, 1, SE2(4.0, 0.0, 0.5), np.diag([1.0, 1e4, 1e5]), EdgeKind.LOOP)
    turned = Edge(0, 1, SE2(3.0, 0.0, 0.5 + 2.0 * math.pi), CERTAIN, EdgeKind.LOOP)
    assert is_wrong(off, truth)
    assert not is_wrong(vague, truth)
    assert not is_wrong(turned, truth)


def test_a_small_building_is_mapped_without_an_open_loop() -> None:
    trial = attempt(1, 0.1, 200.0, Drift().times(0.5))
    assert trial.pairs > 20
    assert trial.agree == 1.0
    assert trial.wrong == 0
    assert trial.found == trial.loops
