"""What a place claims: how well it is known, what holds it, on how much ground, when it is one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.submap_match import Search, SubmapMatch, SubmapMatcher
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.scan_matcher import MatchStatus
from tests.slam.graph.test_loops import Told
from tests.slam.graph.test_place_match import Wall, finished, scan, submap

BENT = np.diag([0.03**2, 0.03**2, 0.004**2])  # what a submap's own bend adds to a match
LOOSE = np.diag([100.0, 100.0, 1.0])
CORRIDOR: tuple[Wall, ...] = ((0.0, 0.02, 16.0, 0.02), (0.0, 2.02, 16.0, 2.02))
JAMB: Wall = (7.52, 2.05, 7.52, 2.65)


def covariance(least_seen: float) -> Floats:
    """Return what a match knows that sees least in a direction [rad]."""
    turn = SE2(0.0, 0.0, least_seen).matrix()
    known: Floats = turn @ np.diag([0.04**2, 0.01**2, 0.003**2]) @ turn.T
    return known


def looked_for(
    query: Submap,
    past: Submap,
    told: Told,
    *,
    prior: SE2 = IDENTITY,
    known: Floats = LOOSE,
    xy: float = 0.3,
    scans: Sequence[Scan] = (),
) -> SubmapMatch | None:
    work = SubmapMatcher(SlamConfig(), told, 20.0).find(
        query, past, Search(prior, known, xy, 0.02), scans
    )
    return finished(work)


def same(walls: tuple[Wall, ...], told: Told, **how: float) -> SubmapMatch:
    """Look for walls among themselves."""
    place = looked_for(submap(walls, IDENTITY), submap(walls, IDENTITY), told, **how)  # type: ignore[arg-type]
    assert place is not None
    return place


@pytest.mark.parametrize(
    ("response", "status", "is_one"),
    [
        (0.4, MatchStatus.MATCHED, True),
        (0.399, MatchStatus.MATCHED, False),
        (0.9, MatchStatus.NOT_CONVERGED, False),
    ],
)
def test_what_the_fine_match_does_not_bear_out_is_no_place(
    response: float, status: MatchStatus, is_one: bool
) -> None:
    walls, told = submap((*CORRIDOR, JAMB), IDENTITY), Told(known=covariance(0.0))
    told.response, told.status = response, status
    place = looked_for(walls, walls, told)
    assert (place is not None) is is_one
    ((reference, start, window, least),) = told.asked
    assert reference is walls.field
    assert start.distance(IDENTITY) < 0.15
    assert (window, least) == (Window(0.2, 0.02, 2), 0.0)


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0])
def test_a_place_is_known_as_well_as_its_match_and_a_submap_s_bend(angle: float) -> None:
    place = same((*CORRIDOR, JAMB), Told(known=covariance(angle)))
    assert place.sure
    np.testing.assert_allclose(place.covariance, covariance(angle) + BENT, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(("length", "is_asked"), [(2.7, False), (3.2, True)])
def test_a_submap_of_less_than_60_cells_is_not_looked_for(length: float, is_asked: bool) -> None:
    wall, told = submap(((1.0, 1.02, 1.0 + length, 1.02),), IDENTITY), Told(known=covariance(0.0))
    assert (len(wall.field.surface()[0]) >= 60) is is_asked
    work = SubmapMatcher(SlamConfig(), told, 20.0).find(
        wall, wall, Search(IDENTITY, LOOSE, 0.3, 0.02), []
    )
    list(work)
    assert bool(told.asked) is is_asked


@pytest.mark.parametrize(("share", "is_asked"), [(0.41, False), (0.5, True)])
def test_so_much_of_a_submap_must_lie_on_the_past_one(share: float, is_asked: bool) -> None:
    walls = ((0.0, 0.02, 10.0, 0.02), (0.02, 0.0, 0.02, 10.0))
    part = ((0.0, 0.02, 20.0 * share, 0.02), (0.02, 0.0, 0.02, 0.01))
    told = Told(known=covariance(0.0))
    looked_for(submap(walls, IDENTITY), submap(part, IDENTITY), told, xy=0.1)
    assert bool(told.asked) is is_asked


@pytest.mark.parametrize(
    ("off", "is_one"),
    [
        (SE2(0.0, 2.0, 0.0), True),  # along the submap's own x, which the graph hardly knows
        (SE2(2.0, 0.0, 0.0), False),
        (SE2(0.3, 0.0, 0.0), True),
        (SE2(0.5, 0.0, 0.0), False),  # four deviations are 0.41 m
    ],
)
def test_a_place_is_one_that_the_graph_leaves_open(off: SE2, is_one: bool) -> None:
    walls = (*CORRIDOR, JAMB)
    prior = SE2(3.0, 1.0, math.pi / 2)
    known = np.diag([1.0, 0.02**2, 0.01**2])
    query, past = submap(walls, prior.inverse()), submap(walls, IDENTITY)
    told = Told(prior.inverse() @ off @ prior, known=covariance(0.0))  # off in the past one's frame
    place = looked_for(query, past, told, prior=prior, known=known)
    assert (place is not None) is is_one


@pytest.mark.parametrize("angle", [0.0, 0.29, 0.32, 0.8, math.pi / 2])
def test_what_faces_the_direction_least_seen_holds_a_place(angle: float) -> None:
    """Walls weigh by the square of how they face it, from a cosine of 0.3 on."""
    place = same((*CORRIDOR, JAMB), Told(known=covariance(angle)))
    across, along = math.sin(angle), math.cos(angle)
    jamb = 0.6 * along**2 * (along > 0.3)
    sides = 32.0 * across**2 * (across > 0.3)
    expected = (jamb * np.array([7.5, 2.35]) + sides * np.array([8.0, 1.0])) / (jamb + sides)
    assert place.holds == pytest.approx(expected, abs=0.05)


def test_only_what_lies_on_the_past_one_holds_a_place() -> None:
    walls = (*CORRIDOR, JAMB, (12.02, 2.3, 12.02, 3.0))
    query, past = submap(walls, IDENTITY), submap((*CORRIDOR, JAMB), IDENTITY)
    place = looked_for(query, past, Told(known=covariance(0.0)))
    assert place is not None
    assert place.holds == pytest.approx((7.5, 2.35), abs=0.05)
    off = SE2(-40.0, 3.0, 0.0)
    place = looked_for(past, past, Told(off, known=covariance(0.0)), known=1e4 * LOOSE)
    assert place is not None  # nothing lies on anything: the middle of all
    middle = (32.0 * np.array([8.0, 1.0]) + 0.6 * np.array([7.5, 2.35])) / 32.6
    assert place.holds == pytest.approx(middle + off.array()[:2], abs=0.05)
    assert place.area == 0


LONG: tuple[Wall, ...] = ((0.2, 0.5, 14.8, 0.5), (0.2, 6.5, 14.8, 6.5))  # 15 squares each
FIVE: Wall = (0.5, 1.2, 0.5, 5.8)
THREE: Wall = (12.5, 1.2, 12.5, 3.8)


def slanted(degrees: float, x: float) -> Wall:
    """Return a wall of 4 m whose normal is so much off x."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return x + 2.0 * s, 3.5 - 2.0 * c, x - 2.0 * s, 3.5 + 2.0 * c


@pytest.mark.parametrize(
    ("query", "past", "area"),
    [
        ((*LONG, FIVE, THREE), (*LONG, FIVE, THREE), 8),
        ((*LONG, FIVE, THREE), (*LONG, FIVE), 5),
        ((*LONG, THREE), (*LONG, FIVE, THREE), 3),
        ((*LONG, FIVE, THREE), (*LONG, FIVE, (12.44, 1.2, 12.44, 3.8)), 8),  # on it
        ((*LONG, FIVE, THREE), (*LONG, FIVE, (12.39, 1.2, 12.39, 3.8)), 5),  # beside it
        ((FIVE, THREE), (FIVE, THREE), 0),  # nothing holds it along them
    ],
)
def test_the_ground_that_holds_a_place_is_counted_in_square_metres(
    query: tuple[Wall, ...], past: tuple[Wall, ...], area: int
) -> None:
    place = looked_for(
        submap(query, IDENTITY), submap(past, IDENTITY), Told(known=covariance(0.0)), xy=0.02
    )
    assert place is not None
    assert place.area == area


@pytest.mark.parametrize(("degrees", "counts"), [(55.0, True), (65.0, False)])
def test_a_slanted_wall_holds_a_place_across_to_60_degrees(degrees: float, counts: bool) -> None:
    walls = (*LONG, FIVE, slanted(degrees, 4.0), slanted(-degrees, 10.0))
    place = same(walls, Told(known=covariance(0.0)))
    assert (place.area > 5) is counts


@pytest.mark.parametrize("k", range(6))
@pytest.mark.parametrize(("between", "is_held"), [(0.0, False), (15.0, True)])
def test_a_place_is_held_in_six_directions(k: int, between: float, is_held: bool) -> None:
    """Two walls that face all directions but those within 3 degrees of one."""
    one = 30.0 * k + between
    walls = (slanted(one - 63.0, 4.0), slanted(one + 63.0, 10.0))
    assert (same(walls, Told(known=covariance(0.0))).area > 0) is is_held


def teeth(others: str) -> tuple[Wall, ...]:
    """Return a row of walls along x, each across it, and others along the row or nearly so."""
    row = tuple((x, 0.0, x, 2.0) for x in np.arange(1.02, 20.0, 2.0).tolist())
    slant = tuple((x, 0.5, x + 0.2, 0.55) for x in (4.0, 9.0, 14.0))
    return {"none": row, "sides": (*row, *CORRIDOR), "some askew": (*row, *slant)}[others]


@pytest.mark.parametrize("others", ["none", "sides", "some askew"])
@pytest.mark.parametrize("frame", [IDENTITY, SE2(3.0, -2.0, 0.6)])
def test_where_another_place_fits_as_well_its_direction_is_not_known(
    others: str, frame: SE2
) -> None:
    """That of the walls which run to it, or that to it where hardly any do; all else is kept."""
    walls, prior = teeth(others), SE2(2.0, 3.0, 0.4)
    query, past = submap(walls, prior.inverse() @ frame), submap(walls, frame)
    place = looked_for(query, past, Told(known=covariance(0.3)), prior=prior, xy=2.6)
    assert place is not None
    assert not place.sure
    along = np.array([math.cos(frame.theta), math.sin(frame.theta), 0.0])
    values, axes = np.linalg.eigh(place.covariance)
    assert values[2] == pytest.approx(1e4, rel=0.01)  # what 1e-4 of information leaves
    assert abs(axes[:, 2] @ along) > math.cos(0.02 if others == "sides" else 0.1)
    vague = covariance(0.3) + BENT + 1e9 * np.outer(axes[:, 2], axes[:, 2])
    expected = np.linalg.inv(vague) + 1e-4 * np.eye(3)
    np.testing.assert_allclose(np.linalg.inv(place.covariance), expected, rtol=0.02, atol=2.0)


@dataclass
class Kept(Sequence[Scan]):
    """Scans that note which are asked for."""

    scan: Scan
    size: int
    asked: set[int] = field(default_factory=set)

    def __len__(self) -> int:
        return self.size

    def __getitem__(self, k: object) -> Scan:  # type: ignore[override]
        assert isinstance(k, int)
        self.asked.add(k)
        return self.scan


@pytest.mark.parametrize(("count", "every"), [(5, 1), (23, 1), (24, 2), (60, 5)])
def test_a_dozen_of_a_submap_s_scans_are_asked(count: int, every: int) -> None:
    walls, view = (*CORRIDOR, JAMB), SE2(5.0, 1.0, 0.0)
    past, query = submap(walls, IDENTITY), submap(walls, IDENTITY)
    past.nodes.extend(range(count))
    past.poses.extend([view] * count)
    kept = Kept(scan(walls, view), count)
    place = looked_for(query, past, Told(known=covariance(0.0)), scans=kept)
    assert place is not None
    assert place.sure
    assert sorted(kept.asked) == list(range(0, count, every))


@pytest.mark.parametrize(("width", "sure"), [(1.0, True), (1.6, False)])
def test_a_wall_longer_than_a_door_in_a_beam_s_way_makes_a_place_unsure(
    width: float, sure: bool
) -> None:
    open_ = ((0.0, 0.02, 16.0, 0.02), (0.0, 4.02, 16.0, 4.02), (15.52, 0.0, 15.52, 4.0))
    shut = (*open_, (9.52, 1.0, 9.52, 1.0 + width))
    view = SE2(5.0, 2.0, 0.0)
    for ours, theirs in ((shut, open_), (open_, shut)):
        query, past = submap(ours, IDENTITY), submap(theirs, IDENTITY)
        seer = query if ours is open_ else past
        seer.nodes.append(0)
        seer.poses.append(view)
        place = looked_for(query, past, Told(known=covariance(0.0)), scans=[scan(open_, view)])
        assert place is not None
        assert place.sure is sure
