"""The pose of a scan, how sure it is, and when tracking or the search decides."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.submap import Submap
from arjuna_slam.matching import scan_matcher
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface, extract
from tests.slam.slam_room import box, room, scan_at

MATCHER = ScanMatcher(MatcherConfig())
CENTRE = SE2(5.0, 5.0, 0.3)
WINDOW = Window(0.5, 0.35, 3)


def reference(scan: Scan) -> Field:
    submap = Submap(Field(0.05, 0.05))
    submap.insert(0, extract(scan, 20.0), SE2())
    return submap.field


def match(scan: Scan, field: Field) -> Match:
    return MATCHER.match(field, extract(scan, 20.0), SE2(), WINDOW, 0.3)


@pytest.mark.parametrize(
    ("x", "y", "degrees"), [(0.0, 0.0, 0.0), (0.12, -0.31, 8.0), (-0.44, 0.05, -17.0)]
)
def test_a_known_offset_is_found_within_2_mm(x: float, y: float, degrees: float) -> None:
    offset = SE2(x, y, math.radians(degrees))
    field = reference(scan_at(room(), CENTRE))
    found = match(scan_at(room(), CENTRE @ offset), field)
    assert found.status is MatchStatus.MATCHED
    assert offset.distance(found.T_field_base) < 0.002
    assert abs(found.T_field_base.theta - offset.theta) < math.radians(0.1)


@pytest.mark.parametrize("heading", [0.0, 0.5, -0.5, 1.5, 2.2])
def test_covariance_is_larger_along_a_corridor_than_across(heading: float) -> None:
    corridor, pose = box(-40.0, -1.0, 40.0, 1.0), SE2(0.0, 0.0, heading)
    field = reference(scan_at(corridor, pose))
    found = MATCHER.track(field, extract(scan_at(corridor, pose), 20.0), SE2(0.02, 0.02, 0.0))
    assert found.status is MatchStatus.MATCHED
    covariance = found.covariance_in(pose)
    assert covariance[0, 0] > 100.0 * covariance[1, 1]


def test_covariance_covers_the_actual_error() -> None:
    """The mean normalised error squared of 3 values is about 3; far above is overconfident."""
    rng = np.random.default_rng(3)
    field = reference(scan_at(room(), CENTRE, sigma=0.01, rng=rng))
    total = 0.0
    for _ in range(30):
        scan = extract(scan_at(room(), CENTRE, sigma=0.01, rng=rng), 20.0)
        found = MATCHER.track(field, scan, SE2(0.03, -0.02, 0.01))
        error = found.T_field_base.array()
        total += float(error @ found.information @ error)
    assert total / 30.0 < 6.0


def test_an_empty_scan_and_a_foreign_room_fail() -> None:
    field = reference(scan_at(room(), CENTRE))
    scan = scan_at(room(), CENTRE)
    blind = Scan(np.full(360, np.inf), 0.0, scan.angle_increment, 0.1, 30.0)
    assert match(blind, field).status is MatchStatus.TOO_FEW_POINTS
    elsewhere = match(scan_at(box(-1.0, -0.7, 0.9, 1.1), SE2()), field)
    assert elsewhere.status is MatchStatus.LOW_RESPONSE


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_scan_taken_while_turning_is_straightened_by_its_motion(clockwise: bool) -> None:
    motion = SE2(0.1, 0.0, 0.2)  # in one sweep: 1 m/s and 2 rad/s at 10 Hz
    exact = scan_at(room(), CENTRE, beams=360, clockwise=clockwise)
    swept = dataclasses.replace(exact, ranges=np.empty(360))
    for k in range(360):
        pose = CENTRE @ SE2.exp(motion.log() * k / 359)
        swept.ranges[k] = scan_at(room(), pose, beams=360, clockwise=clockwise).ranges[k]
    field = reference(exact)
    bent = match(swept, field)
    straight = match(dataclasses.replace(swept, motion=motion), field)
    assert bent.T_field_base.distance(SE2()) > 0.02
    assert straight.T_field_base.distance(SE2()) < 0.002
    assert abs(straight.T_field_base.theta) < math.radians(0.1)


FIELD, PRIOR, WINDOW = Field(0.05, 0.05), SE2(1.0, 2.0, 0.3), Window(0.5, 0.2, 3)
FLOOR = np.diag([0.005**2, 0.005**2, 0.002**2])
MATCHED, LOW, OPEN = MatchStatus.MATCHED, MatchStatus.LOW_RESPONSE, MatchStatus.NOT_CONVERGED


def surface(count: int) -> Surface:
    points = np.column_stack((np.arange(float(count)), np.zeros(count)))
    return Surface(points, np.zeros((count, 2)), np.zeros(count, np.bool_))


@dataclass
class Scripted:
    """Stands for the refinement, the search and the score of a pose.

    Attributes:
        refined: Response and steps of a refinement from the prior, and of one from a found pose.
        found: What the search finds.
        tracked_score: The score of the tracked pose.
    """

    refined: tuple[tuple[float, int], tuple[float, int]]
    found: SE2 | None = None
    tracked_score: float = 0.8
    square: float = 1e-4
    seen: Floats = field(default_factory=lambda: np.diag([4.0, 1.0, 2.0]))
    asked: list[tuple[Floats, float]] = field(default_factory=list)
    refinements: list[Any] = field(default_factory=list)

    def refine(self, _reference: object, points: Floats, *how: Any) -> Any:
        self.refinements.append(how)
        start = how[1]
        response, steps = self.refined[0 if np.array_equal(start, PRIOR.array()) else 1]
        moved = start + np.array([0.01, 0.0, 0.0])
        return moved, np.zeros((3, 3)), response * len(points), self.square, steps

    def search(
        self, reference: Field, points: Floats, prior: SE2, window: Window, least: float
    ) -> tuple[SE2, float] | None:
        assert (reference, prior, window) == (FIELD, PRIOR, WINDOW)
        self.asked.append((points, least))
        return None if self.found is None else (self.found, 0.9)

    def score(
        self, reference: Field, points: Floats, prior: SE2, pose: SE2, window: Window
    ) -> float:
        assert (reference, prior, window) == (FIELD, PRIOR, WINDOW)
        assert pose.x == PRIOR.x + 0.01
        self.scored = points
        return self.tracked_score

    def take_over(self, patch: pytest.MonkeyPatch) -> ScanMatcher:
        for name in ("refine", "search", "score"):
            patch.setattr(scan_matcher, name, getattr(self, name))
        patch.setattr(scan_matcher, "observed", lambda *_: self.seen)
        return ScanMatcher(MatcherConfig())


FOUND = SE2(1.2, 2.1, 0.25)
GOOD, BAD, LOST = (0.6, 5), (0.29, 5), (0.6, -1)


@pytest.mark.parametrize(
    ("refined", "found", "tracked_score", "least", "status", "at", "asked"),
    [
        # The tracked pose is good: the search must find one that scores 0.02 more.
        ((GOOD, GOOD), None, 0.8, 0.4, MATCHED, PRIOR, 0.82),
        ((GOOD, (0.63, 5)), FOUND, 0.8, 0.4, MATCHED, FOUND, 0.82),
        ((GOOD, (0.61, 5)), FOUND, 0.8, 0.4, MATCHED, PRIOR, 0.82),
        # It scores too little: then only what is found counts.
        ((GOOD, GOOD), None, 0.4, 0.4, LOW, None, 0.4),
        ((GOOD, (0.5, 5)), FOUND, 0.4, 0.4, MATCHED, FOUND, 0.4),
        ((GOOD, BAD), FOUND, 0.3, 0.4, LOW, None, 0.4),
        # It fails: so too.
        ((BAD, GOOD), None, 0.8, 0.4, LOW, None, 0.4),
        ((LOST, GOOD), None, 0.8, 0.4, OPEN, None, 0.4),
        ((BAD, (0.3, 5)), FOUND, 0.8, 0.4, MATCHED, FOUND, 0.4),
        ((LOST, (0.3, 0)), FOUND, 0.8, 0.4, MATCHED, FOUND, 0.4),
        ((BAD, LOST), FOUND, 0.8, 0.4, OPEN, None, 0.4),
    ],
)
def test_the_better_of_the_tracked_and_the_found_pose_is_taken(
    refined: tuple[tuple[float, int], tuple[float, int]],
    found: SE2 | None,
    tracked_score: float,
    least: float,
    status: MatchStatus,
    at: SE2 | None,
    asked: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scripted = Scripted(refined, found, tracked_score)
    match = scripted.take_over(monkeypatch).match(FIELD, surface(20), PRIOR, WINDOW, least)
    assert match.status is status
    assert match.T_field_base == (PRIOR if at is None else SE2(at.x + 0.01, at.y, at.theta))
    ((_, searched),) = scripted.asked
    assert searched == pytest.approx(asked)
    from_prior = match.T_field_base.x < 1.1 and found is None
    expected = refined[0 if from_prior or (at is PRIOR) else 1][0]
    assert match.response == pytest.approx(expected)
    if status is not MATCHED:
        np.testing.assert_allclose(match.covariance, np.eye(3))


@pytest.mark.parametrize(
    ("count", "deviation", "gained", "moves"),
    [
        (16, 0.05, 0.2, False),  # some points of a wall's end, 0.9 m from where the wheels led
        (320, 0.05, 0.2, True),
        (16, 0.5, 0.2, True),
        (320, 0.05, 0.03, False),
    ],
)
def test_a_few_points_more_do_not_outweigh_the_prior(
    count: int, deviation: float, gained: float, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, known = PRIOR @ SE2(0.9), np.diag([deviation**-2, deviation**-2, 100.0])
    matcher = Scripted((GOOD, (0.6 + gained, 5)), found).take_over(monkeypatch)
    match = matcher.match(FIELD, surface(count), PRIOR, WINDOW, 0.4, known)
    assert (match.response > 0.6) is moves


@pytest.mark.parametrize(("count", "every"), [(10, 1), (360, 1), (361, 2), (721, 3)])
def test_the_search_scores_some_points_and_the_refinement_all(
    count: int, every: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted, seen = Scripted((GOOD, GOOD)), surface(count)
    match = scripted.take_over(monkeypatch).match(FIELD, seen, PRIOR, WINDOW, 0.4)
    assert match.response == pytest.approx(0.6)
    ((searched, _),) = scripted.asked
    assert np.array_equal(searched, seen.points[::every])
    assert np.array_equal(scripted.scored, searched)


@pytest.mark.parametrize(
    ("count", "refined", "status"),
    [
        (9, GOOD, MatchStatus.TOO_FEW_POINTS),
        (10, GOOD, MATCHED),
        (20, (0.3, 1), MATCHED),
        (20, (0.2999, 1), LOW),
        (20, (0.6, 0), MATCHED),
        (20, LOST, OPEN),
    ],
)
def test_a_match_fails_for_one_reason(
    count: int, refined: tuple[float, int], status: MatchStatus, monkeypatch: pytest.MonkeyPatch
) -> None:
    matcher = Scripted((refined, refined)).take_over(monkeypatch)
    tracked = matcher.track(FIELD, surface(count), PRIOR)
    assert tracked.status is status
    assert (tracked.T_field_base == PRIOR) is (status is not MATCHED)
    assert tracked.response == pytest.approx(0.0 if count < 10 else refined[0])
    if count < 10:
        matched = matcher.match(FIELD, surface(count), PRIOR, WINDOW, 0.0)
        assert (matched.status, matched.response) == (status, 0.0)


@pytest.mark.parametrize(("square", "misfit"), [(1e-4, 1.0), (4e-4, 1.0), (1.6e-3, 4.0)])
def test_the_covariance_is_that_of_points_in_tens_that_err_alike(
    square: float, misfit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points of 0.02 m, ten with one error, worse where they fit worse; 1 m where none is seen."""
    scripted = Scripted((GOOD, GOOD), square=square)
    prior = np.diag([3.0, 2.0, 1.0])
    match = scripted.take_over(monkeypatch).track(FIELD, surface(20), PRIOR, prior)
    seen = np.array([4.0, 1.0, 2.0]) / (0.02**2 * 10.0 * misfit)
    np.testing.assert_allclose(match.covariance, np.diag(1.0 / (seen + 1.0)) + FLOOR, rtol=1e-9)
    np.testing.assert_allclose(match.information @ match.covariance, np.eye(3), atol=1e-9)
    ((_, start, at, information, scales, deviation),) = scripted.refinements
    assert start.tolist() == at.tolist() == PRIOR.array().tolist()
    np.testing.assert_allclose(information, prior + 1e-6 * np.eye(3), rtol=1e-12)
    assert (scales.tolist(), deviation) == ([0.05] * 20, 0.02)
    scripted.seen = np.diag([4.0, 0.0, 2.0])
    twenties = ScanMatcher(MatcherConfig(beam_correlation=20.0)).track(FIELD, surface(20), PRIOR)
    assert twenties.covariance[0, 0] > 1.5 * match.covariance[0, 0]
    blind = ScanMatcher(MatcherConfig()).track(FIELD, surface(20), PRIOR)
    assert blind.covariance[1, 1] == pytest.approx(1.0 + 0.005**2)


@pytest.mark.parametrize("angle", [0.0, 0.6, 2.0, math.pi / 2])
def test_what_neither_a_match_nor_the_step_to_it_sees_is_unseen(angle: float) -> None:
    """Along a direction known to 1 m by the match and 0.5 m before: 0.45 m of both, none across."""
    turn = SE2(0.0, 0.0, angle).matrix()

    def turned(*deviations: float) -> Floats:
        result: Floats = turn @ np.diag(np.square(deviations)) @ turn.T
        return result

    match = Match(MATCHED, PRIOR, turned(1.0, 0.01, 0.01), 0.9)
    prior = np.asarray(np.linalg.inv(turned(0.5, 0.5, 0.1)), np.float64)
    expected = turned(math.sqrt(0.2), 0.0, 0.0)
    np.testing.assert_allclose(match.unseen(prior), expected, atol=1e-9)
    straight = match.covariance_in(SE2(7.0, 8.0, -angle))
    np.testing.assert_allclose(straight, np.diag([1.0, 1e-4, 1e-4]), atol=1e-12)
    failed = Match(LOW, PRIOR, np.eye(3), 0.1)
    np.testing.assert_allclose(failed.unseen(prior), turned(0.5, 0.5, 0.1), rtol=1e-9)
    for along, is_seen in ((0.049, True), (0.051, False)):
        known = Match(MATCHED, PRIOR, turned(along, 0.01, 0.01), 0.9)
        assert (known.unseen(1e-6 * np.eye(3)) == 0.0).all() == is_seen
