"""Poses near by and anywhere: what is matched, what agrees, and when the map is searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.grid import UNKNOWN, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl import recovery
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis, Status
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.amcl.recovery import LikelihoodAverages, LostDetector, MapMatcher, Recovery
from arjuna_slam.amcl.scan_view import Beams, ScanView
from arjuna_slam.matching.correlative import GlobalSearch
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import Robot, error, random_pose, room_map, scan_at

CONFIG = AmclConfig()
MATCHER = MapMatcher(CONFIG, MapField(room_map(), CONFIG.laser_likelihood_max_dist))


@pytest.mark.parametrize("seed", range(4))
def test_refinement_returns_to_the_true_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = random_pose(rng)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    offset = rng.uniform((-0.2, -0.2, -0.1), (0.2, 0.2, 0.1))
    start = truth @ SE2.from_array(offset)
    found = MATCHER.refined(start, view)
    off, turned = error(found, truth)
    assert off < 0.03
    assert turned < math.radians(1.0)


def test_refinement_works_on_a_rotated_map() -> None:
    rng = np.random.default_rng(3)
    field = MapField(room_map(SE2(-0.9, -10.2, math.radians(40.0)), 290), 2.0)
    truth = random_pose(rng)
    start = truth @ SE2(0.15, -0.1, 0.05)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    found = MapMatcher(CONFIG, field).refined(start, view)
    assert error(found, truth)[0] < 0.03


def test_refinement_without_anything_to_match_returns_the_given_pose() -> None:
    pose = SE2(50.0, 50.0, 0.3)
    view = ScanView.of(scan_at(SE2(), 0.0, np.random.default_rng(0)), CONFIG)
    np.testing.assert_allclose(MATCHER.refined(pose, view).array(), pose.array(), atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_agreement_is_high_at_the_truth_and_low_elsewhere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth, other = random_pose(rng), random_pose(rng)
    view = ScanView.of(scan_at(truth, 0.0, rng), CONFIG)
    assert MATCHER.agreement(truth, view) > 0.95
    assert MATCHER.agreement(other, view) < 0.7


def test_a_beam_without_return_speaks_only_where_the_map_has_an_obstacle() -> None:
    rng = np.random.default_rng(1)
    scan = scan_at(SE2(), 0.0, rng)
    silent = replace(scan, ranges=np.where(np.arange(360) < 90, np.inf, scan.ranges))
    assert MATCHER.agreement(SE2(), ScanView.of(silent, CONFIG)) == pytest.approx(0.75, abs=0.02)
    short = replace(silent, range_max=3.0, ranges=np.where(scan.ranges < 3.0, scan.ranges, np.inf))
    assert MATCHER.agreement(SE2(), ScanView.of(short, CONFIG)) > 0.9


_HALF = OccupancyGrid(room_map().frame, room_map().data.copy())  # unknown from x = -1 m on
_HALF.data[:, _HALF.frame.to_cell(-1.0, 0.0)[1] :] = UNKNOWN
HALF = MapMatcher(CONFIG, MapField(_HALF, CONFIG.laser_likelihood_max_dist))


@pytest.mark.parametrize("at", [SE2(-1.5, 0.0, 0.4), SE2(-3.5, -0.5, 2.0), SE2(1.0, 4.0, 0.0)])
def test_what_lies_in_the_unknown_speaks_neither_for_a_pose_nor_against_it(at: SE2) -> None:
    view = ScanView.of(scan_at(at, 0.0, np.random.default_rng(1)), CONFIG)
    known = at.apply(view.many.endpoints)[:, 0] < -1.0
    assert HALF.agreement(at, view) > 0.97
    assert HALF.known(at, view) == pytest.approx(known.sum(), abs=4)
    short = 0.5 * np.minimum(view.many.ranges[~known] / 3.0, 1.0).sum()
    explained = known.sum() / (known.sum() + short)
    assert HALF.explained(at, view) == pytest.approx(explained, abs=0.03)
    off = at @ SE2(0.0, 0.0, 0.5)  # where beams end in the open and behind walls
    assert HALF.agreement(off, view) < 0.7


@pytest.mark.parametrize("x", [-1.6, -1.2, -0.8])
def test_where_a_mapped_wall_ends_matching_does_not_slide_along_it(x: float) -> None:
    """As does a robot in a hall whose lidar sees no more than a wall."""
    pose, odometry = SE2(x, 3.6, 0.7), np.array([0.01, 0.01, 0.01])
    found = pose
    for seed in range(100):
        scan = replace(scan_at(pose, 0.0, np.random.default_rng(seed)), range_max=2.0)
        found = HALF.refined(found, ScanView.of(scan, CONFIG), odometry)
    assert error(found, pose) < (0.035, 0.02)


@pytest.mark.parametrize("origin", [SE2(-5.187, -5.213, 0.0), SE2(-0.9, -10.2, 0.7)])
def test_search_finds_the_pose_anywhere(origin: SE2) -> None:
    field = MapField(room_map(origin, 290), 2.0)
    recovery = Recovery(CONFIG, MapMatcher(CONFIG, field))
    for seed in range(8):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        scan = scan_at(truth, 0.0, rng)
        found = recovery.propose(ScanView.of(scan, CONFIG), [])
        off, turned = error(found[0].T_map_base, truth)
        assert off < 0.05
        assert turned < math.radians(1.5)
        assert (found[0].agreement or 0.0) > 0.95
        assert sum(hypothesis.share for hypothesis in found) == pytest.approx(1.0)


def test_search_looks_through_a_map_of_many_rooms_in_bounded_steps() -> None:
    grid = room_map(SE2(-40.0, -40.0, 0.0), 1600)
    field = MapField(grid, 2.0)
    rng = np.random.default_rng(4)
    truth = random_pose(rng)
    found = GlobalSearch(field).find(scan_at(truth, 0.0, rng).points(), 10)
    errors = [error(SE2.from_array(pose), truth) for pose in found]
    assert min(errors)[0] < 0.15


def test_lost_detector_survives_a_clock_set_back() -> None:
    detector = LostDetector(0.7, 1.0, 8.0)
    assert not detector.observe(0.3, 100.0)
    assert not detector.observe(0.3, 5.0)
    assert detector.observe(0.3, 6.0)


def test_injection_follows_the_ratio_of_the_averages() -> None:
    averages = LikelihoodAverages(0.001, 0.1)
    for _ in range(50):
        averages.add(8.0)
    assert averages.injection == 0.0
    averages.add(2.0)
    assert averages.injection == pytest.approx(1.0 - (8.0 - 0.6) / (8.0 - 0.006))
    averages.reset()
    assert averages.injection == 0.0


CONFIG = AmclConfig()  # lost below 0.7, in doubt below 0.85, better by 0.15, sure from a share 0.75
FIELD = MapField(room_map(), 2.0)
KNOWN = np.diag([0.01, 0.02, 0.003])
NO_BEAMS = Beams(np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.bool_), *np.zeros((2, 0, 2)))


def hypothesis(agreement: float | None, pose: SE2 = IDENTITY, share: float = 0.9) -> Hypothesis:
    return Hypothesis(pose, KNOWN, agreement, share)


def view(near: int = 0, far: int = 40) -> ScanView:
    """Return a scan of which so many beams end 0.9 m and 1.1 m from a sensor that sits aside."""
    mount, angles = SE2(3.0, 1.0, 0.0), np.arange(near + far)
    reach = np.where(angles < near, 0.9, 1.1)
    ends = np.column_stack((np.cos(angles), np.sin(angles))) * reach[:, None] + (3.0, 1.0)
    beams = Beams(ends, reach, np.ones(len(ends), np.bool_), ends, -ends)
    return ScanView(5.0, 10.0, mount, beams, NO_BEAMS)


@pytest.mark.parametrize(
    ("near", "far", "readings"), [(0, 40, 1), (7, 33, 1), (9, 31, 2), (30, 10, 2), (31, 9, 1)]
)
def test_short_beams_are_left_out_of_a_second_reading(near: int, far: int, readings: int) -> None:
    scan = view(near, far)
    found = scan.readings
    assert len(found) == readings
    assert found[0] == (scan.many.endpoints, scan.many.normals)
    ends, normals = found[-1]
    np.testing.assert_array_equal(normals, -ends)
    assert len(ends) == (far if readings == 2 else near + far)


@dataclass
class Scripted:
    """A map whose matching moves poses as scripted, with agreements by x."""

    moves: dict[int, SE2] = field(default_factory=dict)  # by the number of ends matched
    agreements: dict[float, float] = field(default_factory=dict)  # by x
    asked: list[tuple[SE2, Floats]] = field(default_factory=list)

    def refine(
        self,
        pose: SE2,
        points: Floats,
        _normals: Floats,
        information: Floats,
        scales: Floats,
        deviation: float,
    ) -> SE2:
        assert (scales[0], scales[-1], deviation) == (0.36, 0.12, 0.05)
        self.asked.append((pose, information))
        move = self.moves.get(len(points), IDENTITY)
        return SE2(pose.x + move.x, pose.y + move.y, pose.theta + move.theta)

    def agreement(
        self, field: object, pose: SE2, _view: ScanView, distance: float, _doubt: bool = False
    ) -> float:
        assert field is self
        assert distance == 0.15
        return self.agreements.get(round(pose.x, 6), 0.5)

    def matcher(self, patch: pytest.MonkeyPatch) -> MapMatcher:
        patch.setattr(recovery, "share_agreeing", self.agreement)
        return MapMatcher(CONFIG, self)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("move", "is_near"),
    [
        (SE2(0.49, -0.49, 0.26), True),
        (SE2(0.51, 0.0, 0.0), False),
        (SE2(0.0, -0.51, 0.0), False),
        (SE2(0.0, 0.0, -0.27), False),
        (SE2(0.0, 0.0, 2.0 * math.pi + 0.2), True),
    ],
)
def test_a_pose_that_ends_far_away_is_another_one(
    move: SE2, is_near: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted, start = Scripted({40: move}), SE2(1.0, 2.0, 3.0)
    found = scripted.matcher(monkeypatch).refined(start, view(), np.array([0.1, 2.0, 0.0]))
    assert (found != start) is is_near
    ((_, information),) = scripted.asked
    np.testing.assert_allclose(information, np.diag([100.0, 0.25, 1e6]))


@pytest.mark.parametrize(
    ("first", "second", "at"),
    [(0.85, 0.9, 0.1), (0.84, 0.85, 0.1), (0.84, 0.87, 0.2), (0.3, 0.2, 0.1)],
)
def test_what_is_not_hidden_is_matched_alone_where_all_fits_badly(
    first: float, second: float, at: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted = Scripted({40: SE2(0.1), 30: SE2(0.2)}, {0.1: first, 0.2: second})
    assert scripted.matcher(monkeypatch).refined(SE2(), view(10, 30)).x == pytest.approx(at)
    assert len(scripted.asked) == (1 if first >= 0.85 else 2)


@pytest.mark.parametrize(
    ("agreements", "at"),
    [
        ({0.0: 0.85, 0.2: 0.95}, 0.0),
        ({0.0: 0.84, 0.2: 0.85}, 0.0),
        ({0.0: 0.60, 0.2: 0.63, -0.2: 0.64}, 0.2),
        ({0.0: 0.60, 0.2: 0.63, -0.2: 0.66}, -0.2),
    ],
)
def test_where_a_pose_fits_badly_others_a_step_away_are_tried(
    agreements: dict[float, float], at: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted = Scripted(agreements=agreements)
    start = SE2(0.0, 1.0, 0.3)
    pose, score = scripted.matcher(monkeypatch).best_near(start, view(), np.full(3, 0.1))
    assert (pose.x, score) == pytest.approx((at, agreements[at]))
    assert pose.theta == 0.3
    tried = [(round(p.x, 3), round(p.y, 3)) for p, _ in scripted.asked[1:]]
    ring = [SE2(0.2 * math.cos(a), 1.0 + 0.2 * math.sin(a)) for a in np.arange(8) * math.pi / 4]
    expected = [(round(p.x, 3), round(p.y, 3)) for p in ring]
    assert tried == ([] if agreements[0.0] >= 0.85 else expected)


def test_a_search_is_due_ever_more_rarely_up_to_the_longest_wait() -> None:
    lost = LostDetector(0.7, 1.0, 5.0)
    assert not lost.observe(0.7, 0.0)
    calls = []
    for now in np.arange(1.0, 30.0, 0.5).tolist():
        if lost.observe(0.69, now):
            calls.append(now)
            lost.searched(now)
    assert calls == [2.0, 4.0, 8.0, 13.0, 18.0, 23.0, 28.0]
    eager = LostDetector(0.7, 0.0, 5.0)
    assert eager.observe(0.1, 3.0)
    eager.searched(3.0)
    assert eager.observe(0.1, 3.0)


@pytest.mark.parametrize(("slow", "fast"), [(0.0, 0.1), (0.1, 0.0)])
def test_without_an_average_nothing_is_injected(slow: float, fast: float) -> None:
    averages = LikelihoodAverages(slow, fast)
    for likelihood in (4.0, 1.0):
        averages.add(likelihood)
    assert averages.injection == 0.0


@dataclass
class Looked:
    """A search of the whole map that finds poses at given x."""

    at: list[float]
    made: int = 0

    def __call__(self, _field: object) -> Looked:
        self.made += 1
        return self

    def find(self, endpoints: Floats, limit: int) -> Floats:
        assert limit == 24
        some = self.at if len(endpoints) == 40 else self.at[:1]
        return np.array([(x, 0.0, 0.0) for x in some])


def searching(
    patch: pytest.MonkeyPatch, agreements: dict[float, float], *at: float
) -> tuple[Recovery, Looked]:
    scripted, looked = Scripted(agreements=agreements), Looked(list(at))
    patch.setattr(recovery, "GlobalSearch", looked)
    return Recovery(CONFIG, scripted.matcher(patch)), looked


def test_poses_of_equal_fit_share_the_evidence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each beam of 40 that more agree makes a pose e times as likely."""
    agreements = {1.0: 0.8, 2.0: 0.9, 2.1: 0.89, 3.0: 0.795, 4.0: 0.85}
    agreements |= {float(x): 0.81 for x in range(5, 12)}
    searched, looked = searching(monkeypatch, agreements, 1.0, 2.0, 2.1, 3.0, 4.0)
    found = searched.propose(view(), [])
    assert [pose.T_map_base.x for pose in found] == [2.0, 4.0, 1.0]  # 2.1 is like 2.0
    assert [pose.agreement for pose in found] == [0.9, 0.85, 0.8]
    odds = np.exp([0.0, -2.0, -4.0])
    assert [pose.share for pose in found] == pytest.approx(list(odds / odds.sum()))
    assert found[0].covariance.diagonal() == pytest.approx([0.0025, 0.0025, math.radians(2.0) ** 2])
    looked.at = [float(x) for x in range(5, 12)]
    found = searched.propose(view(10, 30), [SE2(4.0, 0.0, 0.0)])
    assert [pose.T_map_base.x for pose in found] == [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert looked.made == 1


@pytest.mark.parametrize(
    ("present", "other", "goes"),
    [(0.75, 0.91, True), (0.75, 0.89, False), (0.6, 0.71, True), (0.6, 0.69, False)],
)
def test_another_pose_must_fit_better_than_the_present_one(
    present: float, other: float, goes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By 0.15, and by two thirds of that where the present one fits so badly that it is lost."""
    searched, _ = searching(monkeypatch, {0.0: present, 5.0: other}, 5.0)
    best = hypothesis(present)
    searched.averages.add(4.0)
    searched.averages.add(1.0)
    found = searched.search(best, view())
    assert [pose.T_map_base.x for pose in found[:1]] == [5.0] * goes
    assert (searched.averages.injection == 0.0) is goes
    assert not searched.due(0.1, 6.9)  # the next in two seconds
    assert searched.due(0.1, 7.0)
    never = Recovery(replace(CONFIG, relocalize=False), searched._matcher)
    assert not never.due(0.1, 0.0)
    assert not never.due(0.1, 50.0)


def test_another_pose_must_fit_the_better_the_fewer_beams_return(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As in a hall, where half of the beams say nothing: by 0.3 in place of 0.15."""
    whole = view()
    many = replace(whole.many, directions=whole.many.directions.repeat(2, axis=0))
    many = replace(many, ranges=whole.many.ranges.repeat(2))
    for present, goes in ((0.69, True), (0.71, False)):  # by two thirds of that where it is lost
        searched, _ = searching(monkeypatch, {0.0: present, 5.0: 0.91}, 5.0)
        assert bool(searched.search(hypothesis(present), replace(whole, many=many))) is goes


def test_a_wanted_search_takes_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    searched, _ = searching(monkeypatch, {0.0: 0.99, 5.0: 0.2}, 5.0)
    searched.restart(search=True)
    assert searched.due(1.0, 0.0)
    found = searched.search(hypothesis(0.99), view())
    assert [pose.T_map_base.x for pose in found] == [5.0]
    assert not searched.wanted
    assert not searched.due(1.0, 0.1)


_RADIUS = 0.25  # of a person [m]
_HIDES = 0.05  # that a beam must be shorter for it [m]
_MOST = 300  # people tried


def besieged(
    scan: Scan, share: float, rng: np.random.Generator, near: tuple[float, float] = (0.05, 1.0)
) -> Scan:
    """Return a scan in which people stop at least a share of the beams, if so many find room.

    Args:
        scan: Of walls alone.
        share: 0..1.
        rng: For where they stand.
        near: From the lidar to them, at least and at most [m].
    """
    ranges = scan.ranges
    for _ in range(_MOST):
        if np.mean(ranges < scan.ranges - _HIDES) >= share:
            break
        away, bearing = rng.uniform(*near) + _RADIUS, rng.uniform(-math.pi, math.pi)
        facing = int(np.argmax(np.cos(scan.angles - bearing)))
        if scan.ranges[facing] > away:
            ranges = np.minimum(ranges, _to_person(scan.angles, away, bearing))
    return replace(scan, ranges=ranges)


def _to_person(angles: Floats, away: float, bearing: float) -> Floats:
    along, across = away * np.cos(angles - bearing), away * np.sin(angles - bearing)
    depth = _RADIUS**2 - across**2
    ranges: Floats = np.where(
        (depth > 0.0) & (along > 0.0), along - np.sqrt(np.maximum(depth, 0.0)), np.inf
    )
    return ranges


ROOM = room_map()
IN_ROOM = MapMatcher(CONFIG, MapField(ROOM, CONFIG.laser_likelihood_max_dist))
SHARES = (0.2, 0.4, 0.5, 0.6, 0.7)


def view_at(truth: SE2, share: float, rng: np.random.Generator) -> ScanView:
    return ScanView.of(besieged(scan_at(truth, 0.0, rng), share, rng), CONFIG)


@pytest.mark.parametrize("share", SHARES)
def test_who_stands_about_the_robot_speaks_little_against_its_pose(share: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        assert IN_ROOM.agreement(truth, view_at(truth, share, rng)) > CONFIG.relocalize_agreement


@pytest.mark.parametrize("share", [0.0, *SHARES])
def test_another_pose_is_not_taken_for_the_robots_though_people_stand_about(share: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth, other = random_pose(rng), random_pose(rng)
        assert IN_ROOM.agreement(other, view_at(truth, share, rng)) < CONFIG.relocalize_agreement


@pytest.mark.parametrize(("length", "weight"), [(3.5, 0.5), (0.3, 0.05)])
def test_short_beams_count_half_from_afar(length: float, weight: float) -> None:
    scan = scan_at(SE2(), 0.0, np.random.default_rng(0))
    early = (np.arange(360) < 180) & (scan.ranges > 4.0)
    ranges, share = np.where(early, length, scan.ranges), float(early.mean())
    found = IN_ROOM.agreement(SE2(), ScanView.of(replace(scan, ranges=ranges), CONFIG))
    assert found == pytest.approx((1.0 - share) / (1.0 - share + weight * share), abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_among_people_is_not_lost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot, belief = Robot(rng), ParticleFilter(CONFIG, ROOM, np.random.default_rng(seed + 1000))
    belief.set_pose(robot.pose, np.diag([0.01, 0.01, 0.01]))
    for _ in range(40):
        scan = besieged(robot.step(), 0.6, np.random.default_rng(seed))
        estimate = belief.update(robot.odometry, scan)
        assert estimate is not None
        assert estimate.status is Status.TRACKING
        assert error(estimate.T_map_base, robot.pose)[0] < 0.15


def test_a_robot_is_looked_for_without_the_beams_that_people_stop() -> None:
    recovery, found = Recovery(CONFIG, IN_ROOM), 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        truth = random_pose(rng)
        best = recovery.propose(view_at(truth, 0.5, rng), [])[0]
        found += error(best.T_map_base, truth)[0] < 0.1
    assert found >= 8
