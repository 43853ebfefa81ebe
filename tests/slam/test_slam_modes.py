"""Claims: localization moves only the robot, lifelong mapping keeps its size and its map true."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.lifelong import LifelongConfig, is_redundant, prune
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.matching.scan_matcher import MatchStatus
from arjuna_slam.slam import Slam
from tests.slam.slam_room import distance_to_walls, drive, ranges_at, room

ORIGIN = SE2(5.0, 3.0, 0.0)
AWAY = SE2(-30.0, 7.0, 1.0)


@pytest.fixture(scope="module")
def session() -> Session:
    slam = Slam()
    for scan, odometry, _ in drive(seed=5):
        slam.process(scan, odometry)
    slam.optimize()
    found = slam.session()
    assert found is not None
    return found


def second_visit(at: int, count: int) -> list[tuple[Scan, SE2, SE2]]:
    log = drive(seed=9)[at : at + count]
    return [(scan, AWAY @ odometry, truth) for scan, odometry, truth in log]


@pytest.mark.parametrize("kind", [StartKind.NEAR_POSE, StartKind.ANYWHERE])
def test_the_robot_is_found_and_followed_within_3_cm(session: Session, kind: StartKind) -> None:
    log = second_visit(40, 200)
    near = ORIGIN.inverse() @ log[0][2] @ SE2(0.4, -0.3, 0.2)
    localizer = Localizer(SlamConfig(), session, Start(kind, near))
    errors = []
    for scan, odometry, truth in log:
        update = localizer.process(scan, odometry)
        assert update is not None
        assert update.status is MatchStatus.MATCHED
        assert (update.T_map_odom @ odometry).distance(update.T_map_base) < 1e-9
        errors.append((ORIGIN @ update.T_map_base).distance(truth))
    assert math.sqrt(np.mean(np.square(errors))) < 0.02
    assert max(errors) < 0.03


def test_localization_leaves_map_and_graph_as_they_are(session: Session) -> None:
    localizer = Localizer(SlamConfig(), session, Start(StartKind.ANYWHERE))
    before = localizer.map()
    for scan, odometry, _ in second_visit(0, 60):
        localizer.process(scan, odometry)
    after = localizer.map()
    assert before is not None
    assert after is not None
    assert before.data.tobytes() == after.data.tobytes()
    assert len(localizer.graph) == len(session.poses)
    assert localizer.session() is session


def test_a_pose_given_at_run_time_is_searched_around(session: Session) -> None:
    log = second_visit(0, 40)
    localizer = Localizer(SlamConfig(), session, Start(StartKind.NEAR_POSE, SE2(-1.0, 4.0, 2.0)))
    wrong = localizer.process(log[0][0], log[0][1])
    assert wrong is not None
    assert (ORIGIN @ wrong.T_map_base).distance(log[0][2]) > 1.0
    localizer.restart(Start(StartKind.NEAR_POSE, SE2(0.5, 0.5, 0.1)))
    for scan, odometry, _ in log[1:]:
        update = localizer.process(scan, odometry)
    assert update is not None
    assert (ORIGIN @ update.T_map_base).distance(log[-1][2]) < 0.03


def test_bad_scans_are_counted_and_a_lost_robot_waits(session: Session) -> None:
    localizer = Localizer(SlamConfig(), session, Start(StartKind.ANYWHERE))
    scan, odometry, _ = second_visit(0, 1)[0]
    blind = dataclasses.replace(scan, ranges=np.full(360, np.nan), stamp=-2.0)
    nowhere = dataclasses.replace(scan, ranges=np.full(360, 0.7), stamp=-1.0)
    assert localizer.process(blind, odometry) is None
    assert localizer.process(nowhere, odometry) is None
    assert localizer.scans.counts[Skip.EMPTY] == localizer.scans.counts[Skip.LOST] == 1
    assert localizer.process(scan, odometry) is not None
    assert localizer.scans.skipped == 2


def test_lifelong_mapping_keeps_its_size_and_its_map_true() -> None:
    log = drive(seed=2, laps=5.0)
    slam = Slam(SlamConfig(lifelong=True))
    sizes, errors = [], []
    for scan, odometry, truth in log:
        update = slam.process(scan, odometry)
        assert update is not None
        sizes.append(len(slam.graph))
        errors.append((log[0][2] @ update.T_map_base).distance(truth))
    lap = len(log) // 5
    assert max(sizes[4 * lap :]) <= max(sizes[2 * lap : 3 * lap]) + 5
    assert len(slam.trajectory()) == len(slam.graph) == sizes[-1]
    assert math.sqrt(np.mean(np.square(errors))) < 0.02
    grid = slam.map()
    assert grid is not None
    cells = grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64))
    assert len(cells) > 700
    assert distance_to_walls(room(), log[0][2].apply(cells)).mean() < 0.03


def test_without_lifelong_it_keeps_every_keyframe() -> None:
    slam = Slam()
    for scan, odometry, _ in drive(seed=2, laps=2.0):
        slam.process(scan, odometry)
    assert len(slam.graph) > 100


def chain() -> Session:
    """Nine keyframes there and back, a loop edge between the ends of both ways."""
    poses = np.array([(x, 0.0, 0.0) for x in (0, 1, 2, 3, 4, 3, 2, 1, 0)], dtype=float)
    scan = Scan(np.ones(3), 0.0, 0.1, 0.1, 10.0)
    edges = [
        Edge(k, k + 1, SE2(poses[k + 1, 0] - poses[k, 0]), np.eye(3), EdgeKind.ODOMETRY)
        for k in range(8)
    ]
    edges.append(Edge(1, 7, IDENTITY, np.eye(3), EdgeKind.LOOP))
    scans = tuple(dataclasses.replace(scan, stamp=float(k)) for k in range(9))
    submaps = ((0, 1, 2), (3, 4, 5), (6, 7, 8))
    return Session(scans, poses, np.arange(9.0), tuple(edges), submaps)


def test_a_submap_is_redundant_where_newer_keyframes_cover_it() -> None:
    session = chain()
    redundant = [is_redundant(LifelongConfig(), session.poses, n) for n in session.submaps]
    assert redundant == [True, False, False]


def test_a_pruned_graph_stays_connected_and_means_the_same() -> None:
    session = chain()
    keep = np.array([True, False, False, True, True, True, True, True, True])
    pruned, index = prune(session, keep)
    assert index.tolist() == [0, -1, -1, 1, 2, 3, 4, 5, 6]
    assert [scan.stamp for scan in pruned.scans] == [0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    assert pruned.submaps == ((0,), (1, 2, 3), (4, 5, 6))
    pairs = {(edge.i, edge.j) for edge in pruned.edges}
    assert {(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6)} <= pairs
    loops = [edge for edge in pruned.edges if edge.kind is EdgeKind.LOOP]
    assert [(edge.i, edge.j) for edge in loops] == [(0, 5)]
    for edge in pruned.edges:
        T = SE2.from_array(pruned.poses[edge.i]).inverse() @ SE2.from_array(pruned.poses[edge.j])
        assert edge.T_i_j.distance(T) < 1e-9


def drifted() -> Slam:
    """A lap and a half that no loop closure corrects, the odometry alone: half a metre off."""
    slam = Slam(SlamConfig(use_scan_matching=False, do_loop_closing=False))
    for scan, odometry, _ in drive(seed=5, laps=1.25):
        slam.process(scan, odometry)
    return slam


def test_without_scan_matching_the_odometry_is_believed() -> None:
    slam, log = drifted(), drive(seed=5, laps=1.25)
    stamp, pose = slam.trajectory()[-1]
    odometry = next(o for scan, o, _ in log if scan.stamp == stamp)
    assert pose.distance(odometry) < 1e-6


def test_a_keyframe_put_in_its_place_by_hand_closes_the_loop_there() -> None:
    slam, log = drifted(), drive(seed=5, laps=1.25)
    node = len(slam.graph) - 1
    stamp, before = slam.trajectory()[node]
    truth = log[0][2].inverse() @ next(t for scan, _, t in log if scan.stamp == stamp)
    assert before.distance(truth) > 0.4
    assert slam.close_by_hand({node: truth @ SE2(0.3, -0.2, 0.1)}) == 1
    assert slam.graph.pose(node).distance(truth) < 0.15
    assert slam.close_by_hand({node: SE2(30.0, 0.0, 0.0)}) == 0


def test_a_lidar_that_turns_while_the_robot_does_is_followed_all_the_same(session: Session) -> None:
    """A sweep of 0.1 s at 1 rad/s is 6 degrees askew; deskewed it is not."""
    rng, errors = np.random.default_rng(6), []
    start = SE2(5.0, 3.0, 0.0)
    localizer = Localizer(
        SlamConfig(), session, Start(StartKind.NEAR_POSE, ORIGIN.inverse() @ start)
    )
    for k in range(30):
        begin = start @ SE2(0.0, 0.0, 0.1 * k)
        ranges = np.array(
            [
                ranges_at(room(), begin @ SE2(0.0, 0.0, 0.1 * i / 359), np.array([angle]))[0]
                for i, angle in enumerate(np.linspace(-math.pi, math.pi, 360))
            ]
        )
        noisy = ranges + rng.normal(0.0, 0.01, 360)
        step = 2.0 * math.pi / 359
        scan = Scan(noisy, -math.pi, step, 0.1, 30.0, 0.1 * k, 0.1 / 359)
        update = localizer.process(scan, AWAY @ begin)
        assert update is not None
        pose = ORIGIN @ update.T_map_base
        errors.append((pose.distance(begin), abs(pose.theta - begin.theta) % (2.0 * math.pi)))
    late = np.array(errors[2:])
    assert late[:, 0].max() < 0.03
    assert np.minimum(late[:, 1], 2.0 * math.pi - late[:, 1]).max() < math.radians(1.0)
