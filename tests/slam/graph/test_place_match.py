"""None"""

from __future__ import annotations

import math
from collections.abc import Generator

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.rivals import SeenField
from arjuna_slam.graph.submap_match import Search, SubmapMatch, SubmapMatcher
from arjuna_slam.mapping.submap import Submap
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import ScanMatcher

Wall = tuple[float, float, float, float]  # from x, y to x, y [m]
CORRIDOR: tuple[Wall, ...] = ((0.0, 0.0, 16.0, 0.0), (0.0, 2.0, 16.0, 2.0))
JAMB: Wall = (7.5, 2.0, 7.5, 2.6)
ENDS: tuple[Wall, ...] = ((0.5, -6.0, 0.5, 0.0), (15.5, 2.0, 15.5, 11.0))
MOVED = SE2(0.3, -0.1, 0.02)
VIEWS = tuple(SE2(x, 1.0, 0.0) for x in (2.0, 8.0, 14.0))


def submap(walls: tuple[Wall, ...], T: SE2, nodes: tuple[int, ...] = ()) -> Submap:
    """What walls look like from a frame that T takes them to."""
    result = Submap(SlamConfig().field())
    result.nodes.extend(nodes)
    result.poses.extend(T @ VIEWS[node] for node in nodes)
    for ax, ay, bx, by in walls:
        a, way = np.array([ax, ay]), np.array([bx - ax, by - ay])
        length = float(np.hypot(*way))
        points = a + np.linspace(0.0, 1.0, int(length / 0.02))[:, None] * way
        normals = np.tile(np.array([-way[1], way[0]]) / length, (len(points), 1))
        result.field.add(T.apply(points), SE2(0.0, 0.0, T.theta).apply(normals))
    return result


def scan(walls: tuple[Wall, ...], view: SE2) -> Scan:
    """What beams see of walls."""
    angles = view.theta - math.pi + math.radians(1.0) * np.arange(360)
    beams = np.column_stack((np.cos(angles), np.sin(angles)))
    ranges = np.full(360, np.inf)
    for ax, ay, bx, by in walls:
        gap, way = np.array([ax - view.x, ay - view.y]), np.array([bx - ax, by - ay])
        across = beams[:, 0] * way[1] - beams[:, 1] * way[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            far = (gap[0] * way[1] - gap[1] * way[0]) / across
            at = (gap[0] * beams[:, 1] - gap[1] * beams[:, 0]) / across
        hit = (far > 0.0) & (at >= 0.0) & (at <= 1.0)
        ranges[hit] = np.minimum(ranges[hit], far[hit])
    return Scan(ranges, -math.pi, math.radians(1.0), 0.02, 30.0, 0.0)


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
    place = finished(work)
    assert place is not None
    return place


def finished(work: Generator[None, None, SubmapMatch | None]) -> SubmapMatch | None:
    """What comes of work that waits at least once."""
    found: list[SubmapMatch | None] = []

    def done() -> Generator[None, None, None]:
        found.append((yield from work))

    assert list(done())
    return found[0]


@pytest.mark.parametrize(
    ("walls", "least", "most"), [((*CORRIDOR, JAMB), 1.0, 2.0), ((*CORRIDOR, *ENDS), 13.0, 18.0)]
)
def test_a_door_holds_a_corridor_on_less_ground_than_its_ends(
    walls: tuple[Wall, ...], least: float, most: float
) -> None:
    place = find(walls)
    assert place.T_past_query.distance(MOVED) < 0.02
    assert least <= place.area <= most


def row_of_rooms(first: float, last: float) -> tuple[Wall, ...]:
    """A corridor with walls between rooms on both sides every 4 m."""
    walls: list[Wall] = [(first, 0.0, last, 0.0), (first, 2.0, last, 2.0)]
    between = [float(x) for x in range(2, 40, 4) if first < x < last]
    return *walls, *((x, 2.0, x, 5.0) for x in between), *((x, 0.0, x, -3.0) for x in between)


def test_a_row_of_rooms_that_reaches_beyond_what_was_seen_may_lie_a_room_further() -> None:
    """A wrong room fits nearly all of it, the right one only what the past submap has seen."""
    place = find(row_of_rooms(5.0, 21.0), row_of_rooms(0.0, 16.0), xy=5.0)
    assert not place.sure


@pytest.mark.parametrize(("nodes", "sure"), [((), False), ((0, 1, 2), True)])
@pytest.mark.parametrize(("size", "xy"), [((16.0, 6.0), 5.0), ((24.0, 4.0), 1.6)])
def test_what_beams_speak_against_is_no_other_place(
    size: tuple[float, float], xy: float, nodes: tuple[int, ...], sure: bool
) -> None:
    """Further along, the ends would lie where nobody has looked, or in the open.

    Those of a corridor are little of all of its walls.
    """
    x, y = size
    sides: tuple[Wall, ...] = ((0.0, 0.0, x, 0.0), (0.0, y, x, y))
    ends: tuple[Wall, ...] = ((0.0, 0.0, 0.0, y), (x, 0.0, x, y))
    assert find((*sides, *ends), xy=xy, nodes=nodes).sure is sure


@pytest.mark.parametrize("frame", [SE2(), SE2(-5.0, 10.0, 0.4), SE2(30.0, 12.0, 0.7)])
def test_what_another_place_leaves_open_is_the_way_along_the_walls(frame: SE2) -> None:
    """Equal doors hold a corridor along it as firmly as its walls do across."""
    sides: tuple[Wall, ...] = ((0.0, 0.0, 30.0, 0.0), (0.0, 2.0, 30.0, 2.0))
    doors = tuple((float(x), 2.0, float(x), 2.4) for x in range(2, 30, 3))
    there = submap((*sides, *doors), frame)
    matcher = SubmapMatcher(SlamConfig(), ScanMatcher(SlamConfig()), 20.0)
    window = Search(SE2(0.1, 0.05, 0.01), np.diag([6.0, 6.0, 0.01]), 5.0, 0.1)
    place = finished(matcher.find(there, there, window, []))
    assert place is not None
    assert not place.sure
    unknown = np.linalg.eigh(place.covariance[:2, :2])[1][:, 1]
    along = np.array([math.cos(frame.theta), math.sin(frame.theta)])
    assert abs(unknown @ along) > math.cos(math.radians(0.5))


@pytest.mark.parametrize(("doors", "is_found"), [((5.0,), True), ((4.0, 5.0, 11.0, 12.0), False)])
def test_beams_that_go_through_much_of_it_speak_against_a_place(
    doors: tuple[float, ...], is_found: bool
) -> None:
    """A closed door across a corridor is 4 % of all walls; 8 % are too much."""
    open_ = (*CORRIDOR, *ENDS)
    shut = (*open_, *((x, 0.0, x, 2.0) for x in doors))
    config, scans = SlamConfig(), [scan(open_, view) for view in VIEWS]
    matcher = SubmapMatcher(config, ScanMatcher(config), config.max_laser_range)
    window = Search(SE2(), np.diag([1.0, 1.0, 0.01]) / 4.0, 1.0, 0.1)
    for query, past in ((shut, open_), (open_, shut)):
        seen = tuple(range(3))
        ours = submap(query, MOVED.inverse(), seen if query is open_ else ())
        theirs = submap(past, SE2(), seen if past is open_ else ())
        place = finished(matcher.find(ours, theirs, window, scans))
        assert (place is not None) is is_found
        assert place is None or not place.sure  # a wall of 2 m is in the way


PRIOR = SE2(4.0, -3.0, 1.0)


def search(xy: float, theta: float = 0.3) -> Search:
    return Search(PRIOR, np.eye(3), xy, theta)


@pytest.mark.parametrize(("xy", "reaches"), [(0.75, False), (0.85, True)])
@pytest.mark.parametrize("way", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_another_place_may_lie_where_the_window_reaches_beside_the_best(
    xy: float, reaches: bool, way: tuple[float, float]
) -> None:
    assert search(xy).reaches_beside(PRIOR) is reaches
    best = SE2(PRIOR.x + 0.3 * way[0], PRIOR.y + 0.3 * way[1], PRIOR.theta)
    assert search(xy - 0.3).reaches_beside(best) is reaches


def test_a_window_has_room_for_two_places_that_are_apart() -> None:
    assert search(1.65).ambiguous
    assert not search(1.55).ambiguous


@pytest.mark.parametrize(("xy", "theta"), [(0.2, 0.05), (1.0, 0.3), (3.0, 0.4), (8.0, 0.5)])
def test_pieces_cover_the_window_once_from_the_middle_outwards(xy: float, theta: float) -> None:
    pieces = search(xy, theta).pieces(0.05)
    assert all((middle.x, middle.y) == (PRIOR.x, PRIOR.y) for middle, _ in pieces)
    assert all(window.xy == xy for _, window in pieces)
    off = [middle.theta - PRIOR.theta for middle, _ in pieces]
    assert np.all(np.diff(np.abs(off)) > -1e-9)
    edges = sorted(
        (turn - window.theta, turn + window.theta)
        for turn, (_, window) in zip(off, pieces, strict=True)
    )
    assert edges[0][0] == pytest.approx(-theta)
    assert edges[-1][1] == pytest.approx(theta)
    assert [low for low, _ in edges[1:]] == pytest.approx([high for _, high in edges[:-1]])
    assert all(window.theta * xy**2 < 1.3 or window.theta <= 0.03 for _, window in pieces)


@pytest.mark.parametrize(
    ("xy", "theta", "count"), [(0.2, 0.05, 1), (1.0, 0.3, 1), (2.0, 0.5, 2), (3.0, 0.39, 3)]
)
def test_a_piece_holds_so_much_of_the_window_or_three_hundredths_of_a_radian(
    xy: float, theta: float, count: int
) -> None:
    assert len(search(xy, theta).pieces(0.05)) == count
    assert len(search(10.0, 0.295).pieces(0.05)) == 10


@pytest.mark.parametrize(
    ("xy", "resolution", "depth"),
    [
        (0.01, 0.1, 2),
        (0.39, 0.05, 2),
        (0.41, 0.05, 3),
        (1.59, 0.1, 3),
        (1.61, 0.05, 5),
        (9, 0.05, 5),
    ],
)
def test_blocks_of_a_search_are_up_to_32_cells_and_no_wider_than_the_window(
    xy: float, resolution: float, depth: int
) -> None:
    assert {window.depth for _, window in search(xy).pieces(resolution)} == {depth}


def seen_field() -> SeenField:
    """Return a field of a wall along y = 0 from x = 0 to 2 m; its left half has been seen."""
    field = Field(0.1, 0.1)
    points = np.column_stack((np.linspace(0.0, 2.0, 41), np.zeros(41)))
    field.add(points, np.tile((0.0, 1.0), (41, 1)))
    seen = np.zeros(field.score.shape, np.bool_)
    seen[:, : seen.shape[1] // 2] = True
    return SeenField(field, seen)


def test_points_lie_on_seen_ground_where_its_cells_are() -> None:
    ground = seen_field()
    x, y = ground.field.origin
    width = 0.1 * ground.seen.shape[1]
    points = np.array([(x + 0.05, y + 0.05), (x + width - 0.05, y + 0.05), (x - 0.05, y + 0.05)])
    assert ground.on_seen(points).tolist() == [True, False, False]
    assert not ground.on_seen(np.array([(x + 0.05, y - 0.05), (x + 0.05, y + 50.0)])).any()


@pytest.mark.parametrize("reach", [0.0, 0.25, 1.0])
def test_ground_that_was_not_seen_is_worth_the_same_everywhere(reach: float) -> None:
    ground = seen_field()
    field = ground.neutral(0.5, reach)
    border = int(np.ceil(reach / 0.1))
    rows, columns = ground.seen.shape
    assert field.score.shape == (rows + 2 * border, columns + 2 * border)
    np.testing.assert_allclose(field.origin, ground.field.origin - 0.1 * border)
    inner = field.score[border : border + rows, border : border + columns]
    np.testing.assert_array_equal(inner[ground.seen], ground.field.score[ground.seen])
    assert set(inner[~ground.seen].tolist()) == {127}
    outside = np.ones(field.score.shape, np.bool_)
    outside[border : border + rows, border : border + columns] = False
    assert (field.score[outside] == 127).all()
