"""What is made of how well scans agree: a better place near by, a search of the whole map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl import recovery
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Hypothesis
from arjuna_slam.amcl.recovery import LikelihoodAverages, LostDetector, MapMatcher, Recovery
from arjuna_slam.amcl.scan_view import Beams, ScanView
from arjuna_slam.matching.map_field import MapField
from tests.slam.amcl.room import room_map

CONFIG = AmclConfig()  # lost below 0.7, in doubt below 0.85, better by 0.15, sure from a share 0.75
FIELD = MapField(room_map(), 2.0)
KNOWN = np.diag([0.01, 0.02, 0.003])
NO_BEAMS = Beams(np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.bool_), np.zeros((0, 2)))


def hypothesis(agreement: float | None, pose: SE2 = IDENTITY, share: float = 0.9) -> Hypothesis:
    return Hypothesis(pose, KNOWN, agreement, share)


def view(near: int = 0, far: int = 40) -> ScanView:
    """Return a scan of which so many beams end 0.9 m and 1.1 m from a sensor that sits aside."""
    mount, angles = SE2(3.0, 1.0, 0.0), np.arange(near + far)
    reach = np.where(angles < near, 0.9, 1.1)
    ends = np.column_stack((np.cos(angles), np.sin(angles))) * reach[:, None] + (3.0, 1.0)
    beams = Beams(ends, reach, np.ones(len(ends), np.bool_), ends)
    return ScanView(5.0, 10.0, mount, beams, NO_BEAMS)


@pytest.mark.parametrize(
    ("near", "far", "readings"), [(0, 40, 1), (7, 33, 1), (9, 31, 2), (30, 10, 2), (31, 9, 1)]
)
def test_beams_that_end_near_by_are_left_out_of_a_second_reading(
    near: int, far: int, readings: int
) -> None:
    scan = view(near, far)
    found = scan.readings
    assert len(found) == readings
    assert found[0] is scan.many.endpoints
    assert len(found[-1]) == (far if readings == 2 else near + far)


@dataclass
class Told:
    """A map whose matching moves poses as it is told, and agreements by where a pose lies."""

    moves: dict[int, SE2] = field(default_factory=dict)  # by the number of ends matched
    worth: dict[float, float] = field(default_factory=dict)  # by x
    asked: list[tuple[SE2, Floats]] = field(default_factory=list)

    def refine(
        self, pose: SE2, points: Floats, information: Floats, scales: Floats, deviation: float
    ) -> SE2:
        assert (scales[0], scales[-1], deviation) == (0.36, 0.12, 0.05)
        self.asked.append((pose, information))
        move = self.moves.get(len(points), IDENTITY)
        return SE2(pose.x + move.x, pose.y + move.y, pose.theta + move.theta)

    def agreement(self, field: object, pose: SE2, _view: ScanView, distance: float) -> float:
        assert field is self
        assert distance == 0.15
        return self.worth.get(round(pose.x, 6), 0.5)

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
def test_what_ends_far_away_is_another_place(
    move: SE2, is_near: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    told, start = Told({40: move}), SE2(1.0, 2.0, 3.0)
    found = told.matcher(monkeypatch).refined(start, view(), np.array([0.1, 2.0, 0.0]))
    assert (found != start) is is_near
    ((_, information),) = told.asked
    np.testing.assert_allclose(information, np.diag([100.0, 0.25, 1e6]))


@pytest.mark.parametrize(
    ("first", "second", "at"),
    [(0.85, 0.9, 0.1), (0.84, 0.85, 0.1), (0.84, 0.87, 0.2), (0.3, 0.2, 0.1)],
)
def test_what_is_not_hidden_is_matched_alone_where_all_fits_badly(
    first: float, second: float, at: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = Told({40: SE2(0.1), 30: SE2(0.2)}, {0.1: first, 0.2: second})
    assert told.matcher(monkeypatch).refined(SE2(), view(10, 30)).x == pytest.approx(at)
    assert len(told.asked) == (1 if first >= 0.85 else 2)


@pytest.mark.parametrize(
    ("worth", "at"),
    [
        ({0.0: 0.85, 0.2: 0.95}, 0.0),
        ({0.0: 0.84, 0.2: 0.85}, 0.0),
        ({0.0: 0.60, 0.2: 0.63, -0.2: 0.64}, 0.2),
        ({0.0: 0.60, 0.2: 0.63, -0.2: 0.66}, -0.2),
    ],
)
def test_where_a_place_fits_badly_others_a_step_away_are_tried(
    worth: dict[float, float], at: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = Told(worth=worth)
    start = SE2(0.0, 1.0, 0.3)
    pose, score = told.matcher(monkeypatch).best_near(start, view(), np.full(3, 0.1))
    assert (pose.x, score) == pytest.approx((at, worth[at]))
    assert pose.theta == 0.3
    tried = [(round(p.x, 3), round(p.y, 3)) for p, _ in told.asked[1:]]
    ring = [SE2(0.2 * math.cos(a), 1.0 + 0.2 * math.sin(a)) for a in np.arange(8) * math.pi / 4]
    expected = [(round(p.x, 3), round(p.y, 3)) for p in ring]
    assert tried == ([] if worth[0.0] >= 0.85 else expected)


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

    places: list[float]
    made: int = 0

    def __call__(self, _field: object) -> Looked:
        self.made += 1
        return self

    def find(self, endpoints: Floats, limit: int) -> Floats:
        assert limit == 24
        some = self.places if len(endpoints) == 40 else self.places[:1]
        return np.array([(x, 0.0, 0.0) for x in some])


def searching(
    patch: pytest.MonkeyPatch, worth: dict[float, float], *places: float
) -> tuple[Recovery, Looked]:
    told, looked = Told(worth=worth), Looked(list(places))
    patch.setattr(recovery, "GlobalSearch", looked)
    return Recovery(CONFIG, told.matcher(patch)), looked


def test_places_that_fit_about_as_well_are_told_with_their_evidence(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each beam of 40 that more agree makes a place e times as likely."""
    worth = {1.0: 0.8, 2.0: 0.9, 2.1: 0.89, 3.0: 0.795, 4.0: 0.85}
    worth |= {float(x): 0.81 for x in range(5, 12)}
    searched, looked = searching(monkeypatch, worth, 1.0, 2.0, 2.1, 3.0, 4.0)
    found = searched.propose(view(), [])
    assert [place.T_map_base.x for place in found] == [2.0, 4.0, 1.0]  # 2.1 is like 2.0
    assert [place.agreement for place in found] == [0.9, 0.85, 0.8]
    odds = np.exp([0.0, -2.0, -4.0])
    assert [place.share for place in found] == pytest.approx(list(odds / odds.sum()))
    assert found[0].covariance.diagonal() == pytest.approx([0.0025, 0.0025, math.radians(2.0) ** 2])
    looked.places = [float(x) for x in range(5, 12)]
    found = searched.propose(view(10, 30), [SE2(4.0, 0.0, 0.0)])
    assert [place.T_map_base.x for place in found] == [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert looked.made == 1


@pytest.mark.parametrize(
    ("present", "other", "goes"),
    [(0.75, 0.91, True), (0.75, 0.89, False), (0.6, 0.71, True), (0.6, 0.69, False)],
)
def test_another_place_must_fit_better_than_the_present_one(
    present: float, other: float, goes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By 0.15, and by two thirds of that where the present one fits so badly that it is lost."""
    searched, _ = searching(monkeypatch, {0.0: present, 5.0: other}, 5.0)
    best = hypothesis(present)
    searched.averages.add(4.0)
    searched.averages.add(1.0)
    found = searched.search(best, view())
    assert [place.T_map_base.x for place in found[:1]] == [5.0] * goes
    assert (searched.averages.injection == 0.0) is goes
    assert not searched.due(0.1, 6.9)  # the next in two seconds
    assert searched.due(0.1, 7.0)
    never = Recovery(replace(CONFIG, relocalize=False), searched._matcher)
    assert not never.due(0.1, 0.0)
    assert not never.due(0.1, 50.0)


def test_a_search_that_is_wanted_takes_the_best_whatever_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searched, _ = searching(monkeypatch, {0.0: 0.99, 5.0: 0.2}, 5.0)
    searched.restart(search=True)
    assert searched.due(1.0, 0.0)
    found = searched.search(hypothesis(0.99), view())
    assert [place.T_map_base.x for place in found] == [5.0]
    assert not searched.wanted
    assert not searched.due(1.0, 0.1)
