"""Localization's configuration and parts."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.matching.scan_matcher import MatchStatus
from tests.slam.slam_room import drive, ranges_at, room

ORIGIN = SE2(5.0, 3.0, 0.0)
AWAY = SE2(-30.0, 7.0, 1.0)


def second_visit(at: int, count: int) -> list[tuple[Scan, SE2, SE2]]:
    log = drive(seed=9)[at : at + count]
    return [(scan, AWAY @ odometry, truth) for scan, odometry, truth in log]


@pytest.mark.parametrize(("kind", "most"), [(StartKind.NEAR_POSE, 0), (StartKind.ANYWHERE, 10)])
def test_the_robot_is_found_and_followed_within_3_cm(
    session: Session, kind: StartKind, most: int
) -> None:
    log = second_visit(40, 200)
    near = ORIGIN.inverse() @ log[0][2] @ SE2(0.4, -0.3, 0.2)
    localizer = Localizer(SlamConfig(scan_buffer_size=most), session, Start(kind, near))
    errors, kept = [], 0
    for scan, odometry, truth in log:
        update = localizer.process(scan, odometry)
        assert update is not None
        kept += update.keyframe
        assert len(localizer._buffer) == min(kept, most)
        assert update.status is MatchStatus.MATCHED
        assert (update.T_map_odom @ odometry).distance(update.T_map_base) < 1e-9
        errors.append((ORIGIN @ update.T_map_base).distance(truth))
    assert math.sqrt(np.mean(np.square(errors))) < 0.02
    assert max(errors) < 0.03
    assert (2 < kept < len(log) / 2) if most else not kept


def test_localization_leaves_map_and_graph_unchanged(session: Session) -> None:
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


@pytest.mark.parametrize(
    ("delta", "due"),
    [
        (SE2(0.14, 0.14, 0.19), False),
        (SE2(0.15, -0.15, 0.0), True),
        (SE2(0.2, 0.0, 0.0), True),
        (SE2(0.0, 0.0, -0.21), True),
        (SE2(0.0, 0.0, 2.0 * math.pi - 0.1), False),
    ],
)
def test_a_keyframe_is_due_after_travel_or_a_turn(delta: SE2, due: bool) -> None:
    assert SlamConfig().keyframe_due(delta) is due


@pytest.mark.parametrize(("odometry", "turn"), [(0.1, 0.2), (0.2, 0.02)])
def test_odometry_errs_with_travel_and_turn(odometry: float, turn: float) -> None:
    """Travel of 5 m and a turn of 2 rad: 0.01 m and 5.4 parts of a metre, 4.525 of a radian."""
    config = SlamConfig(odometry_deviation=odometry, odometry_heading_deviation=turn)
    known = config.odometry_covariance(SE2(3.0, -4.0, -2.0))
    position, heading = 0.01 + 5.4 * odometry, 4.525 * turn
    np.testing.assert_allclose(known, np.diag([position**2, position**2, heading**2]))
