from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.mapping.keyframes import Mapper
from arjuna_slam.matching.scan_matcher import MatchStatus
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam
from tests.slam.slam_room import box, distance_to_walls, drive, ranges_at, room, scan_at

Log = list[tuple[Scan, SE2, SE2]]


@pytest.fixture(scope="module")
def log() -> Log:
    return drive(seed=5)


@pytest.fixture(scope="module")
def ran(log: Log) -> tuple[Slam, list[SlamUpdate]]:
    slam = Slam()
    updates = [slam.process(scan, odometry) for scan, odometry, _ in log]
    return slam, [update for update in updates if update is not None]


def test_the_first_pose_is_the_map_frame(ran: tuple[Slam, list[SlamUpdate]]) -> None:
    assert ran[1][0].T_map_base == SE2()
    assert ran[1][0].keyframe


def test_the_trajectory_is_within_2_cm_of_the_truth(
    log: Log, ran: tuple[Slam, list[SlamUpdate]]
) -> None:
    T_world_map = log[0][2]
    error = [
        (T_world_map @ update.T_map_base).distance(truth)
        for update, (_, _, truth) in zip(ran[1], log, strict=True)
    ]
    drift = [(T_world_map @ odometry).distance(truth) for _, odometry, truth in log]
    assert max(drift) > 0.5
    assert math.sqrt(np.mean(np.square(error))) < 0.02


def test_the_correction_takes_odometry_to_the_map(
    log: Log, ran: tuple[Slam, list[SlamUpdate]]
) -> None:
    update, odometry = ran[1][-1], log[-1][1]
    assert (update.T_map_odom @ odometry).distance(update.T_map_base) < 1e-9


def test_loops_are_closed_and_most_scans_are_no_keyframes(
    ran: tuple[Slam, list[SlamUpdate]],
) -> None:
    assert sum(update.closures for update in ran[1]) > 5
    assert 0.1 < np.mean([update.keyframe for update in ran[1]]) < 0.5


def occupied(grid: OccupancyGrid, T_world_map: SE2) -> Floats:
    return T_world_map.apply(grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64)))


def test_occupied_cells_lie_within_3_cm_of_the_walls(
    log: Log, ran: tuple[Slam, list[SlamUpdate]]
) -> None:
    grid = ran[0].map()
    assert grid is not None
    assert set(np.unique(grid.data)) == {-1, 0, 100}
    distance = distance_to_walls(room(), occupied(grid, log[0][2]))
    assert len(distance) > 700
    assert distance.mean() < 0.03


def test_the_same_input_gives_the_same_bytes(log: Log, ran: tuple[Slam, list[SlamUpdate]]) -> None:
    again = Slam()
    for scan, odometry, _ in log:
        again.process(scan, odometry)
    first, second = ran[0].map(), again.map()
    assert first is not None
    assert second is not None
    assert first.data.tobytes() == second.data.tobytes()
    assert ran[0].graph.poses.tobytes() == again.graph.poses.tobytes()


def test_bad_scans_are_counted_and_change_nothing(log: Log) -> None:
    slam = Slam()
    good, odometry, _ = log[0]
    slam.process(good, odometry)
    bad = [
        dataclasses.replace(good, ranges=np.full(360, value), stamp=1.0 + k)
        for k, value in enumerate((math.nan, math.inf, 0.0, -1.0, 1e9))
    ]
    bad.append(dataclasses.replace(good, ranges=np.zeros(0), stamp=9.0))
    bad.append(good)
    bad.append(dataclasses.replace(good, stamp=-1.0))
    bad.append(dataclasses.replace(good, stamp=math.nan))
    assert [slam.process(scan, SE2(1.0, 0.0, 0.0)) for scan in bad] == [None] * 9
    assert slam.scans.skipped == 9
    assert len(slam.trajectory()) == 1


def test_a_scan_with_too_few_points_keeps_the_odometry(log: Log) -> None:
    slam = Slam()
    slam.process(log[0][0], SE2())
    ranges = np.full(360, np.inf)
    ranges[:4] = 1.0
    update = slam.process(dataclasses.replace(log[0][0], ranges=ranges, stamp=1.0), SE2(0.1, 0, 0))
    assert update is not None
    assert update.status is MatchStatus.TOO_FEW_POINTS
    assert update.T_map_base.distance(SE2(0.1, 0.0, 0.0)) < 1e-9


@pytest.mark.parametrize(("told", "limit"), [(True, 0.02), (False, 0.06)])
def test_scans_swept_while_the_robot_moves_are_deskewed(told: bool, limit: float) -> None:
    """From rest to 1 m/s and up to 1 rad/s, with a mirror of 5 turns a second."""

    def pose(t: float) -> SE2:
        t = t * t / (t + 2.0)
        return SE2(5.0 + 2.0 * math.sin(0.5 * t), 5.0 - 2.0 * math.cos(0.5 * t), math.sin(t))

    def swept(start: float, increment: float) -> Scan:
        exact = scan_at(room(), pose(start), beams=120, stamp=start)
        for k in range(120):
            here = pose(start + 0.2 * k / 119)
            exact.ranges[k] = ranges_at(room(), here, exact.angles[k : k + 1])[0]
        return dataclasses.replace(exact, time_increment=increment)

    worst = []
    for increment in (0.0, 0.2 / 119):
        slam, gaps = Slam(), []
        for k in range(60):
            start = 0.2 * k
            motion = pose(start).inverse() @ pose(start + 0.2) if told and increment else None
            update = slam.process(swept(start, increment), pose(start), motion)
            assert update is not None
            gaps.append((pose(0.0) @ update.T_map_base).distance(pose(start)))
        worst.append(max(gaps))
    assert worst[1] < limit
    assert worst[1] < 0.6 * worst[0]


def test_reset_starts_over(log: Log) -> None:
    slam = Slam(SlamConfig(minimum_travel_distance=0.1))
    assert slam.map() is None
    for scan, odometry, _ in log[:20]:
        slam.process(scan, odometry)
    assert len(slam.trajectory()) > 1
    slam.reset()
    assert slam.map() is None
    assert slam.trajectory() == []
    update = slam.process(log[3][0], log[3][1])
    assert update is not None
    assert update.T_map_base == SE2()


def test_scans_traced_anew_after_moving_give_the_map_of_their_last_poses() -> None:
    poses = np.array([(5.0, 5.0, 0.1), (5.3, 4.8, 0.4), (4.7, 5.2, -0.2), (5.1, 5.1, 1.0)])
    moved, straight = Mapper(0.05, 20.0), Mapper(0.05, 20.0)
    for pose in poses:
        moved.add(scan_at(room(), SE2.from_array(pose)))
        straight.add(scan_at(room(), SE2.from_array(pose)))
    moved.grid(poses + np.array([0.3, -0.2, 0.1]))
    first, second = moved.grid(poses), straight.grid(poses)
    assert first is not None
    assert second is not None
    assert (first.data == second.data).all()
    assert first.frame == second.frame


def test_a_map_of_the_wrong_number_of_poses_is_refused() -> None:
    mapper = Mapper(0.05, 20.0)
    with pytest.raises(ValueError, match="2 poses for 0 scans"):
        mapper.grid(np.zeros((2, 3)))


def test_a_map_that_may_trace_few_scans_anew_gets_there_in_steps() -> None:
    poses = np.array([(5.0 + 0.1 * k, 5.0, 0.05 * k) for k in range(7)])
    mapper, straight = Mapper(0.05, 20.0), Mapper(0.05, 20.0)
    for pose in poses:
        mapper.add(scan_at(room(), SE2.from_array(pose)))
        straight.add(scan_at(room(), SE2.from_array(pose)))
    mapper.grid(poses + np.array([0.3, -0.2, 0.1]))
    wanted = straight.grid(poses)
    assert wanted is not None
    same = []
    for _ in range(4):
        grid = mapper.grid(poses, most_moved=2)
        assert grid is not None
        same.append(grid.data.shape == wanted.data.shape and (grid.data == wanted.data).all())
    assert same == [False, False, False, True]


def test_a_grid_grows_to_all_sides_and_keeps_what_it_had() -> None:
    mapper = Mapper(0.05, 3.0)
    poses: list[tuple[float, float, float]] = []
    for x, y in ((0.0, 0.0), (40.0, 0.0), (-40.0, 3.0), (0.0, 40.0), (2.0, -40.0)):
        mapper.add(scan_at(box(x - 1.0, y - 1.0, x + 1.0, y + 1.0), SE2(x, y)))
        poses.append((x, y, 0.0))
        grid = mapper.grid(np.array(poses))
    assert grid is not None
    for x, y, _ in poses:
        centre, wall = grid.frame.to_cells(np.array([(x, y), (x + 1.0, y)])).astype(int)
        assert grid.data[tuple(centre)] == 0
        assert grid.data[tuple(wall)] == 100
