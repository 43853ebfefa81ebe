"""A submap searched in a past one: the pose, how well it is known, and what speaks against it."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.candidates import Search
from arjuna_slam.graph.submap import Submap
from arjuna_slam.graph.submap_match import SubmapMatch, SubmapMatcher
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.scan_matcher import MatchStatus, ScanMatcher
from tests.slam.graph.loop_scenes import Scripted
from tests.slam.slam_room import scan_at

Wall = tuple[float, float, float, float]  # from x, y to x, y [m]
CORRIDOR: tuple[Wall, ...] = ((0.0, 0.0, 16.0, 0.0), (0.0, 2.0, 16.0, 2.0))
ENDS: tuple[Wall, ...] = ((0.5, -6.0, 0.5, 0.0), (15.5, 2.0, 15.5, 11.0))
MOVED = SE2(0.3, -0.1, 0.02)
VIEWS = tuple(SE2(x, 1.0, 0.0) for x in (2.0, 8.0, 14.0))


def submap(walls: tuple[Wall, ...], T: SE2, nodes: tuple[int, ...] = ()) -> Submap:
    """Return a submap of walls as seen from a frame that T takes them to."""
    result = Submap(SlamConfig().field())
    result.nodes.extend(nodes)
    result.poses.extend(T @ VIEWS[node] for node in nodes)
    for ax, ay, bx, by in walls:
        a, along = np.array([ax, ay]), np.array([bx - ax, by - ay])
        length = float(np.hypot(*along))
        points = a + np.linspace(0.0, 1.0, int(length / 0.02))[:, None] * along
        normals = np.tile(np.array([-along[1], along[0]]) / length, (len(points), 1))
        result.field.add(T.apply(points), SE2(0.0, 0.0, T.theta).apply(normals))
    return result


def scan(walls: tuple[Wall, ...], view: SE2) -> Scan:
    """Return the scan of some walls."""
    return scan_at(np.array(walls), view)


def find(
    walls: tuple[Wall, ...],
    past: tuple[Wall, ...] | None = None,
    xy: float = 1.0,
    nodes: tuple[int, ...] = (),
) -> SubmapMatch:
    """Look for walls where they are, from a frame that is off; among some of them, if given.

    Beams are asked only at nodes.
    """
    config = SlamConfig()
    matcher = SubmapMatcher(config, ScanMatcher(config), config.max_laser_range)
    window = Search(SE2(), np.diag([xy**2, xy**2, 0.01]) / 4.0, xy, 0.1)
    query, there = submap(walls, MOVED.inverse(), nodes), submap(past or walls, SE2(), nodes)
    work = matcher.find(query, there, window, [scan(walls, view) for view in VIEWS])
    match = finished(work)
    assert match is not None
    return match


def finished(work: Generator[None, None, SubmapMatch | None]) -> SubmapMatch | None:
    """Return the result of work that waits at least once."""
    found: list[SubmapMatch | None] = []

    def done() -> Generator[None, None, None]:
        found.append((yield from work))

    assert list(done())
    return found[0]


def row_of_rooms(first: float, last: float) -> tuple[Wall, ...]:
    """A corridor with walls between rooms on both sides every 4 m."""
    walls: list[Wall] = [(first, 0.0, last, 0.0), (first, 2.0, last, 2.0)]
    between = [float(x) for x in range(2, 40, 4) if first < x < last]
    return *walls, *((x, 2.0, x, 5.0) for x in between), *((x, 0.0, x, -3.0) for x in between)


def test_a_row_of_rooms_that_reaches_beyond_what_was_seen_may_lie_a_room_further() -> None:
    """A wrong room fits nearly all of it, the right one only what the past submap has seen."""
    match = find(row_of_rooms(5.0, 21.0), row_of_rooms(0.0, 16.0), xy=5.0)
    assert not match.sure


@pytest.mark.parametrize(("nodes", "sure"), [((), False), ((0, 1, 2), True)])
@pytest.mark.parametrize(("size", "xy"), [((16.0, 6.0), 5.0), ((24.0, 4.0), 1.6)])
def test_a_pose_that_beams_speak_against_is_no_rival(
    size: tuple[float, float], xy: float, nodes: tuple[int, ...], sure: bool
) -> None:
    """Further along, the ends would lie where nobody has looked, or in the open.

    Those of a corridor are little of all of its walls.
    """
    x, y = size
    sides: tuple[Wall, ...] = ((0.0, 0.0, x, 0.0), (0.0, y, x, y))
    ends: tuple[Wall, ...] = ((0.0, 0.0, 0.0, y), (x, 0.0, x, y))
    assert find((*sides, *ends), xy=xy, nodes=nodes).sure is sure


FOUR = 4.0, 5.0, 11.0, 12.0


@pytest.mark.parametrize(
    ("doors", "share", "is_found"), [((5.0,), 0.08, True), (FOUR, 0.08, False), (FOUR, 0.5, True)]
)
def test_beams_that_go_through_much_of_it_speak_against_a_match(
    doors: tuple[float, ...], share: float, is_found: bool
) -> None:
    """A closed door across a corridor is 4 % of all walls; 8 % are too much."""
    open_ = (*CORRIDOR, *ENDS)
    shut = (*open_, *((x, 0.0, x, 2.0) for x in doors))
    config, scans = SlamConfig(loop_contradiction=share), [scan(open_, view) for view in VIEWS]
    matcher = SubmapMatcher(config, ScanMatcher(config), config.max_laser_range)
    window = Search(SE2(), np.diag([1.0, 1.0, 0.01]) / 4.0, 1.0, 0.1)
    for query, past in ((shut, open_), (open_, shut)):
        seen = tuple(range(3))
        ours = submap(query, MOVED.inverse(), seen if query is open_ else ())
        theirs = submap(past, SE2(), seen if past is open_ else ())
        match = finished(matcher.find(ours, theirs, window, scans))
        assert (match is not None) is is_found
        assert match is None or share > 0.1 or not match.sure  # a wall of 2 m is across a beam


BENT = np.diag([0.03**2, 0.03**2, 0.004**2])  # what a submap's own bend adds to a match
LOOSE = np.diag([100.0, 100.0, 1.0])
SIDES: tuple[Wall, ...] = ((0.0, 0.02, 16.0, 0.02), (0.0, 2.02, 16.0, 2.02))
JAMB: Wall = (7.52, 2.05, 7.52, 2.65)


def covariance(least_seen: float) -> Floats:
    """Return what a match knows that sees least in a direction [rad]."""
    turn = SE2(0.0, 0.0, least_seen).matrix()
    known: Floats = turn @ np.diag([0.04**2, 0.01**2, 0.003**2]) @ turn.T
    return known


def looked_for(
    query: Submap,
    past: Submap,
    scripted: Scripted,
    *,
    prior: SE2 = IDENTITY,
    known: Floats = LOOSE,
    xy: float = 0.3,
    scans: Sequence[Scan] = (),
) -> SubmapMatch | None:
    work = SubmapMatcher(SlamConfig(), scripted, 20.0).find(
        query, past, Search(prior, known, xy, 0.02), scans
    )
    return finished(work)


def same(walls: tuple[Wall, ...], scripted: Scripted, **how: float) -> SubmapMatch:
    """Look for walls among themselves."""
    match = looked_for(submap(walls, IDENTITY), submap(walls, IDENTITY), scripted, **how)  # type: ignore[arg-type]
    assert match is not None
    return match


@pytest.mark.parametrize(
    ("response", "status", "is_one"),
    [
        (0.4, MatchStatus.MATCHED, True),
        (0.399, MatchStatus.MATCHED, False),
        (0.9, MatchStatus.NOT_CONVERGED, False),
    ],
)
def test_the_fine_match_must_confirm(response: float, status: MatchStatus, is_one: bool) -> None:
    walls, scripted = submap((*SIDES, JAMB), IDENTITY), Scripted(known=covariance(0.0))
    scripted.response, scripted.status = response, status
    match = looked_for(walls, walls, scripted)
    assert (match is not None) is is_one
    ((reference, start, window, least),) = scripted.asked
    assert reference is walls.field
    assert start.distance(IDENTITY) < 0.15
    assert (window, least) == (Window(0.2, 0.02, 2), 0.0)


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0])
def test_the_covariance_is_that_of_the_fine_match_and_a_submap_s_bend(angle: float) -> None:
    match = same((*SIDES, JAMB), Scripted(known=covariance(angle)))
    assert match.sure
    np.testing.assert_allclose(match.covariance, covariance(angle) + BENT, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(("length", "is_asked"), [(2.7, False), (3.2, True)])
def test_a_submap_of_less_than_60_cells_is_not_looked_for(length: float, is_asked: bool) -> None:
    wall, scripted = (
        submap(((1.0, 1.02, 1.0 + length, 1.02),), IDENTITY),
        Scripted(known=covariance(0.0)),
    )
    assert (len(wall.field.surface()[0]) >= 60) is is_asked
    work = SubmapMatcher(SlamConfig(), scripted, 20.0).find(
        wall, wall, Search(IDENTITY, LOOSE, 0.3, 0.02), []
    )
    list(work)
    assert bool(scripted.asked) is is_asked


@pytest.mark.parametrize(("share", "is_asked"), [(0.41, False), (0.5, True)])
def test_so_much_of_a_submap_must_lie_on_the_past_one(share: float, is_asked: bool) -> None:
    walls = ((0.0, 0.02, 10.0, 0.02), (0.02, 0.0, 0.02, 10.0))
    part = ((0.0, 0.02, 20.0 * share, 0.02), (0.02, 0.0, 0.02, 0.01))
    scripted = Scripted(known=covariance(0.0))
    looked_for(submap(walls, IDENTITY), submap(part, IDENTITY), scripted, xy=0.1)
    assert bool(scripted.asked) is is_asked


@pytest.mark.parametrize(
    ("off", "is_one"),
    [
        (SE2(0.0, 2.0, 0.0), True),  # along the submap's own x, which the graph hardly knows
        (SE2(2.0, 0.0, 0.0), False),
        (SE2(0.3, 0.0, 0.0), True),
        (SE2(0.5, 0.0, 0.0), False),  # four deviations are 0.41 m
    ],
)
def test_a_match_lies_where_the_graph_leaves_it_open(off: SE2, is_one: bool) -> None:
    walls = (*SIDES, JAMB)
    prior = SE2(3.0, 1.0, math.pi / 2)
    known = np.diag([1.0, 0.02**2, 0.01**2])
    query, past = submap(walls, prior.inverse()), submap(walls, IDENTITY)
    scripted = Scripted(
        prior.inverse() @ off @ prior, known=covariance(0.0)
    )  # off in the past one's frame
    match = looked_for(query, past, scripted, prior=prior, known=known)
    assert (match is not None) is is_one


@pytest.mark.parametrize("angle", [0.0, 0.29, 0.32, 0.8, math.pi / 2])
def test_what_faces_the_direction_least_seen_holds_a_match(angle: float) -> None:
    """Walls weigh by the square of how they face it, from a cosine of 0.3 on."""
    match = same((*SIDES, JAMB), Scripted(known=covariance(angle)))
    across, along = math.sin(angle), math.cos(angle)
    jamb = 0.6 * along**2 * (along > 0.3)
    sides = 32.0 * across**2 * (across > 0.3)
    expected = (jamb * np.array([7.5, 2.35]) + sides * np.array([8.0, 1.0])) / (jamb + sides)
    assert match.holds == pytest.approx(expected, abs=0.05)


def test_only_what_lies_on_the_past_one_holds_a_match() -> None:
    walls = (*SIDES, JAMB, (12.02, 2.3, 12.02, 3.0))
    query, past = submap(walls, IDENTITY), submap((*SIDES, JAMB), IDENTITY)
    match = looked_for(query, past, Scripted(known=covariance(0.0)))
    assert match is not None
    assert match.holds == pytest.approx((7.5, 2.35), abs=0.05)
    off = SE2(-40.0, 3.0, 0.0)
    match = looked_for(past, past, Scripted(off, known=covariance(0.0)), known=1e4 * LOOSE)
    assert match is not None  # nothing lies on anything: the middle of all
    middle = (32.0 * np.array([8.0, 1.0]) + 0.6 * np.array([7.5, 2.35])) / 32.6
    assert match.holds == pytest.approx(middle + off.array()[:2], abs=0.05)
    assert match.area == 0


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
def test_the_ground_that_holds_a_match_is_counted_in_square_metres(
    query: tuple[Wall, ...], past: tuple[Wall, ...], area: int
) -> None:
    match = looked_for(
        submap(query, IDENTITY), submap(past, IDENTITY), Scripted(known=covariance(0.0)), xy=0.02
    )
    assert match is not None
    assert match.area == area


@pytest.mark.parametrize(("degrees", "counts"), [(55.0, True), (65.0, False)])
def test_a_slanted_wall_holds_a_submap_across_to_60_degrees(degrees: float, counts: bool) -> None:
    walls = (*LONG, FIVE, slanted(degrees, 4.0), slanted(-degrees, 10.0))
    match = same(walls, Scripted(known=covariance(0.0)))
    assert (match.area > 5) is counts


@pytest.mark.parametrize("k", range(6))
@pytest.mark.parametrize(("between", "is_held"), [(0.0, False), (15.0, True)])
def test_a_match_is_held_in_six_directions(k: int, between: float, is_held: bool) -> None:
    """Two walls that face all directions but those within 3 degrees of one."""
    one = 30.0 * k + between
    walls = (slanted(one - 63.0, 4.0), slanted(one + 63.0, 10.0))
    assert (same(walls, Scripted(known=covariance(0.0))).area > 0) is is_held


def teeth(others: str) -> tuple[Wall, ...]:
    """Return a row of walls along x, each across it, and others along the row or nearly so."""
    row = tuple((x, 0.0, x, 2.0) for x in np.arange(1.02, 20.0, 2.0).tolist())
    slant = tuple((x, 0.5, x + 0.2, 0.55) for x in (4.0, 9.0, 14.0))
    return {"none": row, "sides": (*row, *SIDES), "some askew": (*row, *slant)}[others]


@pytest.mark.parametrize("others", ["none", "sides", "some askew"])
@pytest.mark.parametrize("frame", [IDENTITY, SE2(3.0, -2.0, 0.6)])
def test_the_direction_towards_a_rival_is_not_known(others: str, frame: SE2) -> None:
    """That of the walls which run to it, or that to it where hardly any do; all else is kept."""
    walls, prior = teeth(others), SE2(2.0, 3.0, 0.4)
    query, past = submap(walls, prior.inverse() @ frame), submap(walls, frame)
    match = looked_for(query, past, Scripted(known=covariance(0.3)), prior=prior, xy=2.6)
    assert match is not None
    assert not match.sure
    along = np.array([math.cos(frame.theta), math.sin(frame.theta), 0.0])
    values, axes = np.linalg.eigh(match.covariance)
    assert values[2] == pytest.approx(1e4, rel=0.01)  # what 1e-4 of information leaves
    assert abs(axes[:, 2] @ along) > math.cos(0.02 if others == "sides" else 0.1)
    vague = covariance(0.3) + BENT + 1e9 * np.outer(axes[:, 2], axes[:, 2])
    expected = np.linalg.inv(vague) + 1e-4 * np.eye(3)
    np.testing.assert_allclose(np.linalg.inv(match.covariance), expected, rtol=0.02, atol=2.0)


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
    walls, view = (*SIDES, JAMB), SE2(5.0, 1.0, 0.0)
    past, query = submap(walls, IDENTITY), submap(walls, IDENTITY)
    past.nodes.extend(range(count))
    past.poses.extend([view] * count)
    kept = Kept(scan(walls, view), count)
    match = looked_for(query, past, Scripted(known=covariance(0.0)), scans=kept)
    assert match is not None
    assert match.sure
    assert sorted(kept.asked) == list(range(0, count, every))


@pytest.mark.parametrize(("width", "sure"), [(1.0, True), (1.6, False)])
def test_a_long_wall_across_a_beam_makes_a_match_unsure(width: float, sure: bool) -> None:
    open_ = ((0.0, 0.02, 16.0, 0.02), (0.0, 4.02, 16.0, 4.02), (15.52, 0.0, 15.52, 4.0))
    shut = (*open_, (9.52, 1.0, 9.52, 1.0 + width))
    view = SE2(5.0, 2.0, 0.0)
    for ours, theirs in ((shut, open_), (open_, shut)):
        query, past = submap(ours, IDENTITY), submap(theirs, IDENTITY)
        seer = query if ours is open_ else past
        seer.nodes.append(0)
        seer.poses.append(view)
        match = looked_for(query, past, Scripted(known=covariance(0.0)), scans=[scan(open_, view)])
        assert match is not None
        assert match.sure is sure
