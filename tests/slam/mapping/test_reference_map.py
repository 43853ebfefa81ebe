"""A map that is known: localized on and resumed."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.mapping import reference_map
from arjuna_slam.mapping.reference_map import ReferenceConfig, ReferenceMap
from arjuna_slam.mapping.session import Session, Start, StartKind, load_session, save_session
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.scan_filter import Skip
from arjuna_slam.matching.scan_matcher import Match, MatchStatus
from arjuna_slam.matching.surface import Surface
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, box, distance_to_walls, drive, room, scan_at

FIRST = SE2(4.0, -2.0, 0.5)
KNOWN = np.diag([0.01, 0.01, 0.001])


@dataclass
class Scripted:
    """Stands for the matcher and the search."""

    found: tuple[SE2, float] | None = (SE2(1.0, 2.0, 3.0), 0.8)
    response: float = 0.9
    matched: list[Any] = field(default_factory=list)
    searched: list[Any] = field(default_factory=list)

    def match(self, *how: Any) -> Match:
        self.matched.append(how)
        return Match(MatchStatus.MATCHED, how[2], KNOWN, self.response)

    def track(self, *how: Any) -> Match:
        return self.match(*how)

    def search(self, *how: Any) -> tuple[SE2, float] | None:
        self.searched.append(how)
        return self.found


def mapped(
    scripted: Scripted, width: float, height: float, patch: pytest.MonkeyPatch
) -> ReferenceMap:
    """Return the map of a hall that is scanned from its middle, as the first keyframe saw it."""
    patch.setattr(reference_map, "ScanMatcher", lambda _: scripted)
    patch.setattr(reference_map, "search", scripted.search)
    walls = box(-0.5 * width, -0.5 * height, 0.5 * width, 0.5 * height)
    scan: Scan = scan_at(walls, SE2(), beams=720)
    session = Session((scan,), FIRST.array()[None], np.zeros(1), (), ((0,),))
    return ReferenceMap(ReferenceConfig(), session)


def surface(count: int) -> Surface:
    points = np.column_stack((np.arange(float(count)), np.zeros(count)))
    return Surface(points, np.zeros((count, 2)), np.zeros(count, np.bool_))


def test_the_field_holds_all_walls_of_the_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    field = mapped(Scripted(), 8.0, 4.0, monkeypatch).field
    x = np.arange(-3.9, 3.9, 0.05)
    walls = FIRST.apply(np.column_stack((np.tile(x, 2), np.repeat((-2.0, 2.0), len(x)))))
    assert field.likelihood(walls).min() > 0.5
    assert field.likelihood(FIRST.apply(np.zeros((1, 2)))) == 0.0
    points, normals = field.surface()
    towards = FIRST.apply(np.zeros((1, 2))) - points
    assert ((normals * towards).sum(axis=1) > 0.0).all()
    assert field.score[0].any()  # no larger than it must be
    assert field.score[:, -1].any()


@pytest.mark.parametrize(
    ("start", "at"),
    [
        (Start(StartKind.FIRST_NODE), FIRST),
        (Start(StartKind.NEAR_POSE, SE2(1.0, 0.5, -2.0)), SE2(1.0, 0.5, -2.0)),
    ],
)
def test_a_start_that_is_known_is_searched_around(
    start: Start, at: SE2, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted = Scripted()
    hall, seen = mapped(scripted, 8.0, 4.0, monkeypatch), surface(50)
    assert hall.find(seen, start).T_field_base == at
    (how,) = scripted.matched
    assert how[0] is hall.field
    assert how[1:] == (seen, at, Window(1.5, 0.6, 4), 0.35)
    assert scripted.searched == []


@pytest.mark.parametrize(
    ("width", "height", "depth"), [(0.6, 0.4, 3), (7.0, 4.0, 4), (30.0, 12.0, 6), (4.0, 38.0, 6)]
)
@pytest.mark.parametrize(("count", "every"), [(100, 1), (120, 1), (121, 2), (500, 5)])
def test_a_start_anywhere_is_searched_on_all_of_the_map(
    width: float, height: float, depth: int, count: int, every: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted = Scripted()
    hall, seen = mapped(scripted, width, height, monkeypatch), surface(count)
    assert hall.find(seen, Start(StartKind.ANYWHERE)).T_field_base == SE2(1.0, 2.0, 3.0)
    ((field, points, prior, window, least),) = scripted.searched
    assert field is hall.field
    assert np.array_equal(points, seen.points[::every])
    assert least == 0.7
    assert (window.theta, window.depth) == (math.pi, depth)
    assert math.hypot(prior.x - FIRST.x, prior.y - FIRST.y) < 0.1
    rows, columns = field.score.shape
    assert window.xy == pytest.approx(0.025 * max(rows, columns))
    blocks = 2.0 * window.xy / 0.05 / 2.0**depth  # of which the widest are six to twelve across
    assert 5.6 <= blocks <= 11.4 or depth == 3
    ((_, surface_, start),) = scripted.matched
    assert surface_ is seen
    assert start == SE2(1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("found", "response", "status", "response_found"),
    [
        (None, 0.9, MatchStatus.LOW_RESPONSE, 0.0),
        ((SE2(1.0, 2.0, 3.0), 0.8), 0.44, MatchStatus.LOW_RESPONSE, 0.44),
        ((SE2(1.0, 2.0, 3.0), 0.8), 0.45, MatchStatus.MATCHED, 0.45),
    ],
)
def test_what_fits_badly_is_not_found(
    found: tuple[SE2, float] | None,
    response: float,
    status: MatchStatus,
    response_found: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hall = mapped(Scripted(found, response), 8.0, 4.0, monkeypatch)
    match = hall.find(surface(50), Start(StartKind.ANYWHERE))
    assert (match.status, match.response) == (status, response_found)
    if status is not MatchStatus.MATCHED:
        np.testing.assert_array_equal(match.covariance, np.eye(3))
        assert match.T_field_base.distance(FIRST) < 0.1


ORIGIN = SE2(5.0, 3.0, 0.0)  # where a drive begins, and so the map's frame in the room
SECOND = SE2(100.0, -50.0, 2.0)  # odometry starts anew with every session


def test_the_map_of_a_saved_session_is_the_map(mapped: Slam, file: Path) -> None:
    resumed = Slam()
    resumed.resume(load_session(file), Start(StartKind.FIRST_NODE))
    first, second = mapped.map(), resumed.map()
    assert first is not None
    assert second is not None
    assert first.frame == second.frame
    assert (first.data != second.data).mean() < 1e-3


def continue_mapping(slam: Slam, start: int, count: int = 60) -> tuple[list[SlamUpdate], Log]:
    """Drive on from a pose on a lap of another seed, with odometry of its own."""
    log = drive(seed=9)[start : start + count]
    away = SECOND @ log[0][1].inverse()
    later = [(dataclasses.replace(s, stamp=s.stamp + 1000.0), away @ o, t) for s, o, t in log]
    updates = [slam.process(scan, odometry) for scan, odometry, _ in later]
    return [update for update in updates if update is not None], later


@pytest.mark.parametrize(
    ("start", "at"),
    [
        (Start(StartKind.FIRST_NODE), 3),
        (Start(StartKind.NEAR_POSE, SE2(2.4, 2.3, 1.4)), 75),
        (Start(StartKind.ANYWHERE), 75),
        (Start(StartKind.ANYWHERE), 190),
    ],
)
def test_mapping_continues_in_the_frame_of_the_saved_map(start: Start, at: int, file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), start)
    nodes = len(slam.graph)
    updates, log = continue_mapping(slam, at)
    assert len(updates) == len(log)
    error = [
        (ORIGIN @ update.T_map_base).distance(truth)
        for update, (_, _, truth) in zip(updates, log, strict=True)
    ]
    assert max(error) < 0.05
    assert len(slam.graph) > nodes + 10
    assert any(edge.i < nodes <= edge.j for edge in slam.graph.edges)
    grid = slam.map()
    assert grid is not None
    cells = np.argwhere(grid.occupied()).astype(np.int64)
    assert distance_to_walls(room(), ORIGIN.apply(grid.frame.to_points(cells))).mean() < 0.03


def test_a_continued_session_can_be_saved_and_continued_again(file: Path, tmp_path: Path) -> None:
    slam = Slam()
    for k in range(2):
        slam.resume(load_session(file), Start(StartKind.FIRST_NODE))
        updates, log = continue_mapping(slam, 3 + 5 * k)
        found = slam.session()
        assert found is not None
        save_session(file, found)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_robot_that_is_nowhere_on_the_map_waits_until_it_is(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.ANYWHERE))
    elsewhere = scan_at(room()[:4] * 0.31, SE2(1.0, 2.0, 0.3), stamp=1.0)
    assert slam.process(elsewhere, SE2()) is None
    assert slam.scans.counts[Skip.LOST] == 1
    updates, log = continue_mapping(slam, 75)
    assert (ORIGIN @ updates[-1].T_map_base).distance(log[-1][2]) < 0.05


def test_a_start_that_no_scan_confirms_is_believed_and_said_so(file: Path) -> None:
    slam = Slam()
    slam.resume(load_session(file), Start(StartKind.NEAR_POSE, SE2(50.0, 0.0, 0.0)))
    updates, _ = continue_mapping(slam, 75, 5)
    assert updates[0].status.value == "low response"
    assert updates[0].T_map_base == SE2(50.0, 0.0, 0.0)


@pytest.mark.parametrize("gap", [1, 30, 60])
def test_odometry_that_continued_has_the_robot_s_pose(gap: int) -> None:
    log, slam = drive(seed=7), Slam()
    for scan, odometry, _ in log[:150]:
        slam.process(scan, odometry)
    session = slam.session()
    assert session is not None
    again = Slam()
    again.resume(session, Start(StartKind.ODOMETRY))
    for scan, odometry, truth in log[150 + gap : 180 + gap]:
        update = again.process(scan, odometry)
        assert update is not None
        assert (ORIGIN @ update.T_map_base).distance(truth) < 0.05


def test_unknown_odometry_is_not_continued(session: Session) -> None:
    unknown = dataclasses.replace(session, T_odom_base=None)
    with pytest.raises(ValueError, match="does not know where odometry was"):
        Slam().resume(unknown, Start(StartKind.ODOMETRY))
