"""Mapping: the trajectory, the map and the loops of drives through a room."""

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
from arjuna_slam.matching.scan_matcher import MatchStatus
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, box, distance_to_walls, drive, ranges_at, room, scan_at


@pytest.fixture(scope="module")
def ran(log: Log) -> tuple[Slam, list[SlamUpdate]]:
    slam = Slam()
    updates = [slam.process(scan, odometry) for scan, odometry, _ in log]
    return slam, [update for update in updates if update is not None]


def test_one_box_in_the_open_does_not_turn_the_robot() -> None:
    """Its few points share their errors; odometry knows the heading better."""
    crate, worst = box(1.0, 1.2, 1.4, 1.6), []
    for seed in range(6):
        slam, rng, turned = Slam(), np.random.default_rng(seed), 0.0
        for k in range(100):
            pose = SE2(0.05 * k - 1.0, 0.0)
            scan = scan_at(crate, pose, sigma=0.01, rng=rng, stamp=0.2 * k)
            update = slam.process(scan, pose)
            turned = max(turned, abs(update.T_map_base.theta)) if update else turned
        worst.append(turned)
    assert np.mean(worst) < math.radians(0.5)


def test_the_trajectory_is_within_2_cm(log: Log, ran: tuple[Slam, list[SlamUpdate]]) -> None:
    T_world_map = log[0][2]
    error = [
        (T_world_map @ update.T_map_base).distance(truth)
        for update, (_, _, truth) in zip(ran[1], log, strict=True)
    ]
    drift = [(T_world_map @ odometry).distance(truth) for _, odometry, truth in log]
    assert max(drift) > 0.5
    assert math.sqrt(np.mean(np.square(error))) < 0.02


def test_loops_are_closed_and_keyframes_are_few(ran: tuple[Slam, list[SlamUpdate]]) -> None:
    assert sum(update.closures for update in ran[1]) > 5
    assert 0.1 < np.mean([update.keyframe for update in ran[1]]) < 0.5


def occupied(grid: OccupancyGrid, T_world_map: SE2) -> Floats:
    return T_world_map.apply(grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64)))


def test_occupied_cells_lie_on_the_walls(log: Log, ran: tuple[Slam, list[SlamUpdate]]) -> None:
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


def test_a_scan_with_too_few_points_keeps_the_odometry(log: Log) -> None:
    slam = Slam()
    slam.process(log[0][0], SE2())
    ranges = np.full(360, np.inf)
    ranges[:4] = 1.0
    update = slam.process(dataclasses.replace(log[0][0], ranges=ranges, stamp=1.0), SE2(0.1, 0, 0))
    assert update is not None
    assert update.status is MatchStatus.TOO_FEW_POINTS
    assert update.T_map_base.distance(SE2(0.1, 0.0, 0.0)) < 1e-9


def _on_a_bend(t: float) -> SE2:
    """Return where a robot is that drives off from rest, up to 1 m/s and 1 rad/s."""
    t = t * t / (t + 2.0)
    return SE2(5.0 + 2.0 * math.sin(0.5 * t), 5.0 - 2.0 * math.cos(0.5 * t), math.sin(t))


@pytest.fixture(scope="module")
def swept() -> list[Scan]:
    """Scans on that bend, of a mirror of 5 turns a second."""
    found = []
    for start in 0.2 * np.arange(60):
        scan = scan_at(room(), _on_a_bend(start), beams=120, stamp=start)
        for k in range(120):
            here = _on_a_bend(start + 0.2 * k / 119)
            scan.ranges[k] = ranges_at(room(), here, scan.angles[k : k + 1])[0]
        found.append(scan)
    return found


@pytest.mark.parametrize(("known", "limit"), [(True, 0.02), (False, 0.06)])
def test_scans_swept_while_the_robot_moves_are_deskewed(
    swept: list[Scan], known: bool, limit: float
) -> None:
    worst = []
    for increment in (0.0, 0.2 / 119):
        slam, gaps = Slam(), []
        for scan in swept:
            here, there = _on_a_bend(scan.stamp), _on_a_bend(scan.stamp + 0.2)
            motion = here.inverse() @ there if known and increment else None
            given = dataclasses.replace(scan, time_increment=increment)
            update = slam.process(given, here, motion)
            assert update is not None
            gaps.append(update.T_map_base.distance(here))
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
    assert update.T_map_base == log[3][1]


def test_a_map_s_frame_is_that_of_odometry_at_the_first_scan(log: Log) -> None:
    """As slam_toolbox's: a map made where odometry does not begin at 0 has its coordinates."""
    T_new_old = SE2(-7.0, 12.0, 2.0)
    begun, moved = Slam(), Slam()
    for scan, odometry, _ in log[:30]:
        update, other = begun.process(scan, odometry), moved.process(scan, T_new_old @ odometry)
        assert update is not None
        assert other is not None
        assert (T_new_old @ update.T_map_base).distance(other.T_map_base) < 0.02
    assert moved.trajectory()[0][1] == T_new_old @ log[0][1]


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


def test_a_keyframe_put_right_by_hand_closes_the_loop_there() -> None:
    slam, log = drifted(), drive(seed=5, laps=1.25)
    node = len(slam.graph) - 1
    stamp, before = slam.trajectory()[node]
    truth = log[0][2].inverse() @ next(t for scan, _, t in log if scan.stamp == stamp)
    assert before.distance(truth) > 0.4
    assert slam.close_by_hand({node: truth @ SE2(0.3, -0.2, 0.1)}) == 1
    assert slam.graph.pose(node).distance(truth) < 0.15
    assert slam.close_by_hand({node: SE2(30.0, 0.0, 0.0)}) == 0


LOG = drive(seed=5, laps=0.6)
MIDDLE = SE2()


@pytest.mark.parametrize(
    ("beams", "degrees", "clockwise", "mount", "limit"),
    [
        ((50, 50), 90.0, False, MIDDLE, 0.05),
        ((50, 50), 360.0, True, MIDDLE, 0.02),
        ((181, 181), 180.0, False, SE2(0.3, -0.2, 2.5), 0.02),
        ((720, 720), 270.0, True, SE2(-0.5, 0.5, -3.0), 0.02),
        ((2880, 2880), 360.0, False, SE2(0.1, 0.0, math.pi / 2), 0.02),
        ((100, 400), 270.0, False, MIDDLE, 0.02),
    ],
)
def test_the_pose_is_kept_with_any_lidar(
    beams: tuple[int, int], degrees: float, clockwise: bool, mount: SE2, limit: float
) -> None:
    rng = np.random.default_rng(1)
    slam, gaps = Slam(), []
    for scan, odometry, truth in LOG:
        seen = scan_at(
            room(), truth, beams=int(rng.integers(beams[0], beams[1] + 1)),
            field_of_view=math.radians(degrees), sigma=0.01, rng=rng, stamp=scan.stamp,
            clockwise=clockwise, T_base_sensor=mount,
        )  # fmt: skip
        update = slam.process(seen, odometry)
        assert update is not None
        gaps.append((LOG[0][2] @ update.T_map_base).distance(truth))
    assert math.sqrt(np.mean(np.square(gaps))) < limit
    assert slam.map() is not None
