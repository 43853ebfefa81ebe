"""What a match decides: tracked or searched, matched or failed, and how much it claims to know."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_slam.matching import scan_matcher
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatcherConfig, MatchStatus, ScanMatcher
from arjuna_slam.matching.surface import Surface

FIELD, PRIOR, WINDOW = Field(0.05, 0.05), SE2(1.0, 2.0, 0.3), Window(0.5, 0.2, 3)
FLOOR = np.diag([0.005**2, 0.005**2, 0.002**2])
MATCHED, LOW, OPEN = MatchStatus.MATCHED, MatchStatus.LOW_RESPONSE, MatchStatus.NOT_CONVERGED


def surface(count: int) -> Surface:
    points = np.column_stack((np.arange(float(count)), np.zeros(count)))
    return Surface(points, np.zeros((count, 2)), np.zeros(count, np.bool_))


@dataclass
class Told:
    """Stands for the refinement, the search and the score of a pose.

    Attributes:
        refined: Response and steps of a refinement from the prior, and of one from a found pose.
        found: What the search finds.
        worth: The score of the tracked pose.
    """

    refined: tuple[tuple[float, int], tuple[float, int]]
    found: SE2 | None = None
    worth: float = 0.8
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
        return self.worth

    def take_over(self, patch: pytest.MonkeyPatch) -> ScanMatcher:
        for name in ("refine", "search", "score"):
            patch.setattr(scan_matcher, name, getattr(self, name))
        patch.setattr(scan_matcher, "observed", lambda *_: self.seen)
        return ScanMatcher(MatcherConfig())


FOUND = SE2(1.2, 2.1, 0.25)
GOOD, BAD, LOST = (0.6, 5), (0.29, 5), (0.6, -1)


@pytest.mark.parametrize(
    ("refined", "found", "worth", "least", "status", "at", "asked"),
    [
        # The tracked pose is good: the search must find one that is worth 0.02 more.
        ((GOOD, GOOD), None, 0.8, 0.4, MATCHED, PRIOR, 0.82),
        ((GOOD, (0.63, 5)), FOUND, 0.8, 0.4, MATCHED, FOUND, 0.82),
        ((GOOD, (0.61, 5)), FOUND, 0.8, 0.4, MATCHED, PRIOR, 0.82),
        # It is not worth enough: then only what is found counts.
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
    worth: float,
    least: float,
    status: MatchStatus,
    at: SE2 | None,
    asked: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = Told(refined, found, worth)
    match = told.take_over(monkeypatch).match(FIELD, surface(20), PRIOR, WINDOW, least)
    assert match.status is status
    assert match.T_field_base == (PRIOR if at is None else SE2(at.x + 0.01, at.y, at.theta))
    ((_, searched),) = told.asked
    assert searched == pytest.approx(asked)
    from_prior = match.T_field_base.x < 1.1 and found is None
    expected = refined[0 if from_prior or (at is PRIOR) else 1][0]
    assert match.response == pytest.approx(expected)
    if status is not MATCHED:
        np.testing.assert_allclose(match.covariance, np.eye(3))


@pytest.mark.parametrize(("count", "every"), [(10, 1), (360, 1), (361, 2), (721, 3)])
def test_the_search_scores_some_points_and_the_refinement_all(
    count: int, every: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    told, seen = Told((GOOD, GOOD)), surface(count)
    match = told.take_over(monkeypatch).match(FIELD, seen, PRIOR, WINDOW, 0.4)
    assert match.response == pytest.approx(0.6)
    ((searched, _),) = told.asked
    assert np.array_equal(searched, seen.points[::every])
    assert np.array_equal(told.scored, searched)


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
    matcher = Told((refined, refined)).take_over(monkeypatch)
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
    told = Told((GOOD, GOOD), square=square)
    prior = np.diag([3.0, 2.0, 1.0])
    match = told.take_over(monkeypatch).track(FIELD, surface(20), PRIOR, prior)
    seen = np.array([4.0, 1.0, 2.0]) / (0.02**2 * 10.0 * misfit)
    np.testing.assert_allclose(match.covariance, np.diag(1.0 / (seen + 1.0)) + FLOOR, rtol=1e-9)
    np.testing.assert_allclose(match.information @ match.covariance, np.eye(3), atol=1e-9)
    ((_, start, at, information, scales, deviation),) = told.refinements
    assert start.tolist() == at.tolist() == PRIOR.array().tolist()
    np.testing.assert_allclose(information, prior + 1e-6 * np.eye(3), rtol=1e-12)
    assert (scales.tolist(), deviation) == ([0.05] * 20, 0.02)
    told.seen = np.diag([4.0, 0.0, 2.0])
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
