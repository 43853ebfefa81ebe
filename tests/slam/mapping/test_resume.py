"""Claims: mapping continues where a saved session ended."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_slam.mapping.session import Session, Start, StartKind, load_session, save_session
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, distance_to_walls, drive, room, scan_at

ORIGIN = SE2(5.0, 3.0, 0.0)  # where a drive begins, and so the map's frame in the room
SECOND = SE2(100.0, -50.0, 2.0)  # odometry starts anew with every session


def test_the_map_of_a_saved_session_is_the_map(mapped: Slam, file: Path) -> None:
    resumed = Slam()
    resumed.resume(load_session(file), Start(StartKind.FIRST_NODE))
    first, second = mapped.map(), resumed.map()
    assert first is not None
    assert second is not None
    assert first.frame == second.frame
    assert (first.data != second.data).mean() < 1e-3


def go_on(slam: Slam, start: int, count: int = 60) -> tuple[list[SlamUpdate], Log]:
    """Drive on from a pose on a lap of another seed, with odometry of its own."""
    log = drive(seed=9)[start : start + count]
    away = SECOND @ log[0][1].inverse()
    later = [(dataclasses.replace(s, stamp=s.stamp + 1000.0), away @ o, t) for s, o, t in log]
    updates = [slam.process(scan, odometry) for scan, odometry, _ in later]
    return [update for update in updates if update is not None], later


@pytest.mark.parametrize(
    ("start", "at"),
    [
        (Start(StartKind.FIRST_NODE), 3),
        (Start(StartKind.NEAR_POSE, SE2(2.4, 2.3, 1.4)), 75),
        (Start(StartKind.ANYWHERE), 75),
        (Start(StartKind.ANYWHERE), 190),
    ],
)
def test_mapping_goes_on_in_the_frame_of_the_saved_map(start: Start, at: int, file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), start)
    nodes = len(slam.graph)
    updates, log = go_on(slam, at)
    assert len(updates) == len(log)
    error = [
        (ORIGIN @ update.T_map_base).distance(truth)
        for update, (_, _, truth) in zip(updates, log, strict=True)
    ]
    assert max(error) < 0.05
    assert len(slam.graph) > nodes + 10
    assert any(edge.i < nodes <= edge.j for edge in slam.graph.edges)
    grid = slam.map()
    assert grid is not None
    cells = np.argwhere(grid.occupied()).astype(np.int64)
    assert distance_to_walls(room(), ORIGIN.apply(grid.frame.to_points(cells))).mean() < 0.03


def test_a_continued_session_can_be_saved_and_continued_again(file: Path, tmp_path: Path) -> None:
    slam = Slam()
    for k in range(2):
        slam.resume(load_session(file), Start(StartKind.FIRST_NODE))
        updates, log = go_on(slam, 3 + 5 * k)
        found = slam.session()
        assert found is not None
        save_session(file, found)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_robot_that_is_nowhere_on_the_map_waits_until_it_is(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.ANYWHERE))
    elsewhere = scan_at(room()[:4] * 0.31, SE2(1.0, 2.0, 0.3), stamp=1.0)
    assert slam.process(elsewhere, SE2()) is None
    assert slam.scans.counts[Skip.LOST] == 1
    updates, log = go_on(slam, 75)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_start_that_no_scan_confirms_is_believed_and_said_so(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.NEAR_POSE, SE2(50.0, 0.0, 0.0)))
    updates, _ = go_on(slam, 75, 5)
    assert updates[0].status.value == "low response"
    assert updates[0].T_map_base == SE2(50.0, 0.0, 0.0)


@pytest.mark.parametrize("gap", [1, 30, 60])
def test_odometry_that_continued_has_the_robot_s_pose(gap: int) -> None:
    log, slam = drive(seed=7), Slam()
    for scan, odometry, _ in log[:150]:
        slam.process(scan, odometry)
    session = slam.session()
    assert session is not None
    again = Slam()
    again.resume(session, Start(StartKind.ODOMETRY))
    for scan, odometry, truth in log[150 + gap : 180 + gap]:
        update = again.process(scan, odometry)
        assert update is not None
        assert (ORIGIN @ update.T_map_base).distance(truth) < 0.05


def test_odometry_that_is_not_known_is_not_gone_on_with(session: Session) -> None:
    unknown = dataclasses.replace(session, T_odom_base=None)
    with pytest.raises(ValueError, match="does not know where odometry was"):
        Slam().resume(unknown, Start(StartKind.ODOMETRY))
