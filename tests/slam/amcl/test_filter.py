"""The filter tracks, notices a kidnap, finds itself again, and is never surely wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.grid import UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import MOTION_MODELS, SENSOR_MODELS, AmclConfig
from arjuna_slam.amcl.estimate import Estimate, Hypothesis, LocalizationError, Status
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.scan_view import ScanView
from tests.slam.amcl.room import Robot, error, random_pose, room_map, scan_at

DEFAULTS = AmclConfig()
ROOM = room_map()
TIGHT = np.diag([0.01, 0.01, 0.01])
RVIZ = np.diag([0.25, 0.25, 0.0685])


class Run:
    """A robot and its filter, fed with each scan as a node would."""

    def __init__(self, seed: int, config: AmclConfig = DEFAULTS) -> None:
        self.robot = Robot(np.random.default_rng(seed))
        self.filter = ParticleFilter(config, ROOM, np.random.default_rng(seed + 1000))
        self.estimate: Estimate | None = None
        self.count = 0

    def feed(self, scan: Scan, force: bool = False) -> Estimate | None:
        estimate = self.filter.update(self.robot.odometry, scan, force)
        if estimate is not None:
            self.estimate, self.count = estimate, self.count + 1
        return estimate

    def drive(self, steps: int) -> None:
        for _ in range(steps):
            self.feed(self.robot.step())

    @property
    def pose(self) -> SE2:
        assert self.estimate is not None
        return self.estimate.T_map_odom @ self.robot.odometry

    @property
    def error(self) -> tuple[float, float]:
        return error(self.pose, self.robot.pose)


def tracked(seed: int, config: AmclConfig = DEFAULTS) -> Run:
    run = Run(seed, config)
    run.filter.set_pose(run.robot.pose, TIGHT)
    run.drive(20)
    return run


@pytest.mark.parametrize(
    ("motion", "sensor"), [*zip(MOTION_MODELS.types, SENSOR_MODELS, strict=True)]
)
def test_tracking_error_is_below_3_cm(motion: str, sensor: str) -> None:
    run = Run(1, AmclConfig(robot_model_type=motion, laser_model_type=sensor))
    run.filter.set_pose(run.robot.pose @ SE2(0.2, -0.2, 0.15), RVIZ)
    run.drive(10)
    errors = []
    for _ in range(60):
        run.drive(1)
        errors.append(run.error[0])
        assert run.estimate is not None
        assert run.estimate.status is Status.TRACKING
    assert math.sqrt(np.mean(np.square(errors))) <= 0.03
    assert max(errors) <= 0.08


@pytest.mark.parametrize("mode", ["drive", "spin", "stand"])
@pytest.mark.parametrize("seed", range(3))
def test_a_kidnapped_robot_is_right_again_within_ten_seconds(seed: int, mode: str) -> None:
    run = tracked(seed)
    run.robot.pose = random_pose(np.random.default_rng(seed + 500))
    noticed = right = None
    for tick in range(100):
        if mode == "drive":
            scan = run.robot.step()
        else:
            run.robot.move(SE2(0.0, 0.0, 0.05 if mode == "spin" else 0.0))
            scan = run.robot.scan()
        run.feed(scan)
        off, turned = run.error
        assert run.estimate is not None
        sure = run.estimate.status is Status.TRACKING and run.estimate.quality > 0.7
        assert not (sure and (off > 0.3 or turned > 0.3)), "surely wrong"
        noticed = tick if noticed is None and not sure else noticed
        right = (right if right is not None else tick) if off < 0.1 and turned < 0.1 else None
    assert noticed is not None
    assert noticed < 30
    assert right is not None
    assert run.estimate is not None
    assert run.estimate.status is Status.TRACKING


@pytest.mark.parametrize("seed", range(5))
def test_global_localization_finds_the_robot_with_one_scan(seed: int) -> None:
    run = Run(seed)
    run.filter.globalize()
    assert run.feed(run.robot.scan()) is not None
    assert run.error[0] < 0.05


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (0.0, -2.0), (0.0, 60.0)])
def test_particles_that_have_strayed_from_the_pose_come_back(x: float, y: float) -> None:
    run = tracked(4)
    run.filter.belief.particles[:, :2] += (x, y)
    for _ in range(40):
        run.drive(1)
        assert run.estimate is not None
        assert run.estimate.status is not Status.LOST
        assert run.error[0] < 0.05
    away = run.filter.belief.particles[:, :2] - (run.robot.pose.x, run.robot.pose.y)
    assert np.median(np.hypot(*away.T)) < 0.5


def twins(pose: SE2) -> list[SE2]:
    """The poses of a square room that look like one of them."""
    return [SE2(0.0, 0.0, quarter * math.pi / 2) @ pose for quarter in range(4)]


@pytest.mark.parametrize("seed", range(2))
def test_in_a_symmetric_room_all_poses_are_kept_for_long_and_none_is_sure(seed: int) -> None:
    square = room_map(boxes=())
    robot = Robot(np.random.default_rng(seed), boxes=())
    belief = ParticleFilter(AmclConfig(), square, np.random.default_rng(seed + 50))
    belief.globalize()
    T_map_odom = SE2()
    for _ in range(600):
        estimate = belief.update(robot.odometry, robot.step())
        if estimate is not None:
            T_map_odom = estimate.T_map_odom
            assert estimate.status is Status.AMBIGUOUS
            assert estimate.quality < 0.5
            assert "other poses" in estimate.reason
        pose = T_map_odom @ robot.odometry
        assert min(pose.distance(twin) for twin in twins(robot.pose)) < 0.1
    for twin in twins(robot.pose):
        near = np.hypot(*(belief.belief.particles[:, :2] - (twin.x, twin.y)).T) < 0.5
        assert belief.belief.weights[near].sum() > 0.1


@pytest.mark.parametrize("seed", range(3))
def test_one_box_in_a_room_decides_between_poses(seed: int) -> None:
    boxes = ((2.5, 0.0),)
    robot = Robot(np.random.default_rng(seed), boxes=boxes)
    rng = np.random.default_rng(seed + 50)
    belief = ParticleFilter(AmclConfig(), room_map(boxes=boxes), rng)
    belief.globalize()
    estimate = None
    for _ in range(100):
        estimate = belief.update(robot.odometry, robot.step()) or estimate
    assert estimate is not None
    assert estimate.status is Status.TRACKING
    assert error(estimate.T_map_odom @ robot.odometry, robot.pose)[0] < 0.05


def test_particles_wait_until_the_robot_has_moved_enough_and_the_pose_does_not() -> None:
    run = tracked(1)
    run.feed(run.robot.scan(), force=True)
    before = run.filter.belief.particles.copy()
    run.robot.odometry = run.robot.odometry @ SE2(0.0, 0.0, 0.19)
    run.robot.pose = run.robot.pose @ SE2(0.0, 0.0, 0.16)  # the wheels slip
    assert run.feed(run.robot.scan()) is not None
    np.testing.assert_array_equal(run.filter.belief.particles, before)
    assert run.error[1] < 0.01
    run.robot.odometry = run.robot.odometry @ SE2(0.0, 0.0, 0.02)
    run.robot.pose = run.robot.pose @ SE2(0.0, 0.0, 0.02)
    assert run.feed(run.robot.scan()) is not None
    assert (
        len(run.filter.belief.particles) != len(before)
        or (run.filter.belief.particles != before).any()
    )


def test_small_steps_do_not_add_up_to_an_error() -> None:
    run = tracked(2)
    for _ in range(200):
        run.robot.move(SE2(0.005, 0.0, 0.02))
        run.feed(run.robot.scan())
        assert run.error[0] < 0.05


def test_people_around_the_robot_do_not_throw_it_off() -> None:
    run = tracked(3)
    rng = np.random.default_rng(7)
    for _ in range(150):
        scan = run.robot.step()
        ranges, first = scan.ranges.copy(), int(rng.integers(360))
        blocked = (first + np.arange(70)) % 360
        ranges[blocked] = np.minimum(ranges[blocked], rng.uniform(0.5, 2.0))
        run.feed(replace(scan, ranges=ranges))
        assert run.error[0] < 0.08


@pytest.mark.parametrize(
    ("beams", "length", "searches"), [(15, 1.2, False), (40, 1.2, True), (180, 0.4, False)]
)
def test_the_map_is_not_searched_for_beams_that_would_fit_anywhere(
    monkeypatch: pytest.MonkeyPatch, beams: int, length: float, searches: bool
) -> None:
    found: list[float] = []
    some = ParticleFilter(DEFAULTS, ROOM, np.random.default_rng(1))
    some.set_pose(SE2(), TIGHT)

    def search(best: Hypothesis, view: ScanView) -> list[Hypothesis]:
        found.append(view.stamp)
        return [best]

    monkeypatch.setattr(some._recovery, "search", search)
    ranges = np.full(360, np.inf)
    ranges[: 2 * beams] = length  # of nothing that the map has; every other beam is matched
    for k in range(30):
        some.update(SE2(), Scan(ranges, -math.pi, math.tau / 360, 0.1, 3.5, 0.1 * k), force=True)
    assert bool(found) is searches


def test_a_blind_scan_moves_the_estimate_by_odometry_and_says_so() -> None:
    run = tracked(4)
    scan = run.robot.step()
    blind = run.feed(replace(scan, ranges=np.full(360, np.nan)), force=True)
    assert blind is not None
    assert blind.status is Status.BLIND
    assert blind.quality == 0.0
    assert "odometry" in blind.reason
    assert run.error[0] < 0.3


def test_before_any_pose_there_is_no_estimate() -> None:
    run = Run(0)
    assert run.feed(run.robot.scan()) is None
    assert not run.filter.initialized


def test_set_pose_spreads_the_particles_by_the_covariance() -> None:
    run = Run(0)
    covariance = np.array([[0.2, 0.05, 0.0], [0.05, 0.1, 0.0], [0.0, 0.0, 0.03]])
    run.filter.set_pose(SE2(1.0, 2.0, 0.5), covariance)
    np.testing.assert_allclose(run.filter.belief.particles.mean(axis=0), (1.0, 2.0, 0.5), atol=0.05)
    np.testing.assert_allclose(np.cov(run.filter.belief.particles.T), covariance, atol=0.02)
    assert run.filter.belief.weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("pose", "covariance", "match"),
    [
        (SE2(math.nan, 0.0, 0.0), TIGHT, "must be finite"),
        (SE2(0.0, 0.0, math.inf), TIGHT, "must be finite"),
        (SE2(40.0, 0.0, 0.0), TIGHT, "lies outside the map, which spans x -5.19 to 5.31 m"),
        (SE2(), np.diag([1.0, -1.0, 1.0]), "positive semi-definite"),
        (SE2(), np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1.0]]), "symmetric"),
        (SE2(), np.full((3, 3), np.nan), r"finite \(3, 3\)"),
        (SE2(), np.eye(2), r"finite \(3, 3\)"),
    ],
)
def test_a_bad_pose_keeps_the_last_state(pose: SE2, covariance: np.ndarray, match: str) -> None:
    run = tracked(5)
    before = run.filter.belief.particles.copy()
    with pytest.raises(LocalizationError, match=match):
        run.filter.set_pose(pose, covariance)
    np.testing.assert_array_equal(run.filter.belief.particles, before)
    run.drive(20)
    assert run.error[0] < 0.06


def test_bad_odometry_is_refused_and_the_last_good_state_kept() -> None:
    run = tracked(5)
    before = run.filter.belief.particles.copy()
    with pytest.raises(ArjunaError, match="odometry pose must be finite"):
        run.filter.update(SE2(math.nan, 0.0, 0.0), run.robot.scan(), force=True)
    np.testing.assert_array_equal(run.filter.belief.particles, before)
    run.drive(20)
    assert run.error[0] < 0.06


@pytest.mark.parametrize("value", [-1, 100])
def test_a_map_in_which_no_robot_can_be_is_refused(value: int) -> None:
    grid = OccupancyGrid(GridFrame(0.05, 4, 3), np.full((3, 4), value, np.int8))
    with pytest.raises(LocalizationError, match="has no free cell"):
        ParticleFilter(AmclConfig(), grid, np.random.default_rng(0))


def test_crossed_particle_limits_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"min_particles \(3000\) must not exceed"):
        AmclConfig(min_particles=3000)


def test_the_same_seed_gives_the_same_bytes() -> None:
    def trace() -> bytes:
        run = tracked(6)
        run.robot.pose = random_pose(np.random.default_rng(9))
        run.drive(40)
        assert run.estimate is not None
        return run.filter.belief.particles.tobytes() + run.estimate.T_map_odom.array().tobytes()

    assert trace() == trace()


START = SE2(0.5, 1.0, 0.3)


def started() -> tuple[ParticleFilter, SE2]:
    """Return a filter that has seen one scan, and odometry then."""
    some = ParticleFilter(AmclConfig(), ROOM, np.random.default_rng(1))
    odometry = SE2(7.0, -3.0, 2.0)
    some.set_pose(START, np.diag([1e-3, 1e-3, 1e-3]))
    estimate = some.update(odometry, seen(START, 0.0))
    assert estimate is not None
    assert estimate.status is Status.TRACKING
    return some, odometry


def seen(pose: SE2, stamp: float) -> Scan:
    return scan_at(pose, stamp, np.random.default_rng(3))


def blind(stamp: float) -> Scan:
    return replace(seen(START, stamp), ranges=np.full(360, np.inf))


@pytest.mark.parametrize("step", [SE2(), SE2(0.1, 0.0, 0.05), SE2(0.2, 0.0, 0.1)])
def test_a_blind_scan_between_updates_says_nothing(step: SE2) -> None:
    some, odometry = started()
    assert some.update(odometry @ step, blind(0.1)) is None
    forced = some.update(odometry @ step, blind(0.2), force=True)
    assert forced is not None
    assert forced.status is Status.BLIND
    assert forced.T_map_base.distance(START @ step) < 0.05


def test_a_robot_that_stands_where_it_was_has_nothing_to_say() -> None:
    some, odometry = started()
    assert some.update(odometry, seen(START, 0.1)) is None
    assert some.update(odometry @ SE2(0.0005), seen(START, 0.2)) is None


@pytest.mark.parametrize("slip", [SE2(), SE2(0.03, -0.02, 0.02)])
def test_between_updates_the_pose_follows_the_scan_and_the_particles_wait(slip: SE2) -> None:
    some, odometry = started()
    before = some.belief.particles.copy()
    step = SE2(0.15, 0.05, 0.1)
    estimate = some.update(odometry @ step @ slip, seen(START @ step, 0.1))
    assert estimate is not None
    assert estimate.T_map_base.distance(START @ step) < 0.02
    found = estimate.T_map_odom @ odometry @ step @ slip
    assert found.array() == pytest.approx(estimate.T_map_base.array())
    np.testing.assert_array_equal(some.belief.particles, before)


@pytest.mark.parametrize("off", [SE2(1.3, -1.5), SE2(1.6, -0.4), SE2(0.5, -1.8)])
def test_a_belief_grown_wide_in_the_open_is_matched_where_the_first_wall_fits(off: SE2) -> None:
    """The other corners of the room look the same from so near."""
    truth = SE2(-3.9, 3.9, 0.0)
    some = ParticleFilter(AmclConfig(), room_map(), np.random.default_rng(1))
    some.set_pose(truth @ off, np.diag([1.2**2, 1.2**2, 0.05**2]))
    ranges = seen(truth, 0.1).ranges
    scan = replace(seen(truth, 0.1), ranges=np.where(ranges < 1.6, ranges, np.inf))
    found = some.update(SE2(), scan, force=True)
    assert found is not None
    assert found.T_map_base.distance(truth) < 0.1


def test_a_robot_that_sees_too_little_goes_where_odometry_leads() -> None:
    """Along a wall that tells no more than how far it is, their mean goes astray by chance."""
    robot = Robot(np.random.default_rng(2), pose=SE2(-4.0, 3.3, 0.0), boxes=())
    some = ParticleFilter(DEFAULTS, room_map(boxes=()), np.random.default_rng(1))
    some.set_pose(robot.pose, np.diag([1.0, 0.01, 0.01]))
    T_map_odom = SE2()
    for k in range(250):
        robot.pose, robot.odometry = (pose @ SE2(0.02) for pose in (robot.pose, robot.odometry))
        scan, robot.now = robot.scan(), 0.1 * k
        ranges = np.where(scan.ranges < (2.5 if k < 200 else 0.0), scan.ranges, np.inf)
        estimate = some.update(robot.odometry, replace(scan, ranges=ranges, stamp=robot.now))
        T_map_odom = T_map_odom if estimate is None else estimate.T_map_odom
    assert error(T_map_odom @ robot.odometry, robot.pose) < (0.05, 0.02)


def test_where_all_lies_in_the_unknown_the_robot_goes_where_odometry_leads() -> None:
    data = ROOM.data.copy()
    data[:, ROOM.frame.to_cell(0.0, 0.0)[1] :] = UNKNOWN
    some = ParticleFilter(DEFAULTS, OccupancyGrid(ROOM.frame, data), np.random.default_rng(1))
    some.set_pose(SE2(-1.0, 0.5, 0.0), TIGHT)
    for k in range(100):
        pose = SE2(-1.0 + 0.04 * k, 0.5 + 0.03 * k, 0.0)
        scan = scan_at(pose, 0.1 * k, np.random.default_rng(k))
        ahead = np.where(np.abs(scan.angles) < 1.0, scan.ranges, np.inf)
        some.update(pose, replace(scan, ranges=ahead))
        estimate = some.update(pose, replace(scan, ranges=ahead), force=True)
        assert estimate is not None
        assert estimate.T_map_base.distance(pose) < 0.1
        assert k == 0 or estimate.status is Status.BLIND


@pytest.mark.parametrize("seed", range(4))
def test_no_stray_particle_takes_the_pose_that_explains_the_scan(seed: int) -> None:
    """Steps of a metre scatter the particles, and where the map ends nothing contradicts them."""
    margin, small = 200, ROOM.frame
    half = ROOM.data.copy()
    half[len(half) // 2 :] = UNKNOWN
    data = np.pad(half, margin, constant_values=UNKNOWN)
    around = SE2(-margin * small.resolution, -margin * small.resolution)
    wide = GridFrame(small.resolution, data.shape[1], data.shape[0], small.origin @ around)
    some = ParticleFilter(DEFAULTS, OccupancyGrid(wide, data), np.random.default_rng(seed))
    some.set_pose(SE2(-2.0, -0.5, 0.0), TIGHT)
    for k in range(6):
        pose = SE2(-2.0, -0.5, 0.0) @ SE2(0.3 * k, 0.1 * k, 0.2 * k)
        scan = scan_at(pose, 1.0 * k, np.random.default_rng(k))
        crowd = np.where(np.arange(len(scan.ranges)) % 60 < 30, 0.7, 1.0)
        estimate = some.update(pose, replace(scan, ranges=crowd * scan.ranges), force=True)
        assert estimate is not None
        assert estimate.T_map_base.distance(pose) < 0.1
        some.belief.spread(pose, np.diag([4.0, 4.0, 2.0]))


@pytest.mark.parametrize(("beams", "moves"), [(24, False), (180, True)])
def test_a_pose_that_fits_a_beam_or_two_better_is_not_taken_for_them(
    monkeypatch: pytest.MonkeyPatch, beams: int, moves: bool
) -> None:
    """A tenth more of the beams are two where no more than one thing is seen."""
    some, odometry = started()
    elsewhere = START @ SE2(0.1, 0.1, 0.1)
    monkeypatch.setattr(some._matcher, "agreement", lambda *_: 0.8)
    monkeypatch.setattr(some._matcher, "explained", lambda at, _: 0.9 if at == elsewhere else 0.8)
    monkeypatch.setattr(some._matcher, "best_near", lambda *_: (elsewhere, 0.9))
    scan = seen(START, 0.1)
    ranges = np.where(np.arange(360) < 2 * beams, scan.ranges, np.inf)
    estimate = some.update(odometry, replace(scan, ranges=ranges), force=True)
    assert estimate is not None
    assert (estimate.T_map_base.distance(elsewhere) < 0.01) is moves
