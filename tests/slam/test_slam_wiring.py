"""Poses, edges and keyframes that SLAM and localization make of matches, each in its frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam import localization, slam
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.pose_graph import EdgeKind
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.session import Session, Start, StartKind
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus
from arjuna_slam.matching.surface import Surface
from arjuna_slam.slam import Slam
from tests.slam.slam_room import room, scan_at

KNOWN = np.array([[4.0, 1.0, 0.2], [1.0, 2.0, 0.1], [0.2, 0.1, 0.5]]) * 1e-4
SLIP = SE2(0.01, -0.004, 0.003)  # what scans correct odometry by at each step
CONFIG = replace(
    SlamConfig(), do_loop_closing=False, submap_length=2.0, lifelong=False, submap_size=100
)
STRETCH = 1.25


@dataclass
class Scripted:
    """A tracker that finds the robot a little off odometry's pose, but for some steps."""

    failing: tuple[int, ...] = ()
    searched: list[bool] = field(default_factory=list)
    information: list[Floats] = field(default_factory=list)

    def locate(
        self,
        _reference: Field,
        _surface: Surface,
        T_field_last: SE2,
        delta: SE2,
        information: Floats,
        search: bool,
        gap: float = math.inf,
    ) -> Match:
        fails = len(self.searched) in self.failing
        self.searched.append(search)
        self.information.append(information)
        status = MatchStatus.LOW_RESPONSE if fails else MatchStatus.MATCHED
        pose = T_field_last @ delta @ (IDENTITY if fails else SLIP)
        return Match(status, pose, KNOWN, 0.8)

    def stretched(self, delta: SE2) -> SE2:
        return SE2(STRETCH * delta.x, STRETCH * delta.y, delta.theta)


def drive(count: int = 40) -> Iterator[tuple[Scan, SE2]]:
    """Yield scans, from one pose, and odometry that bends; each third step is a keyframe."""
    pose = SE2(7.0, 3.0, 2.0)
    for k in range(count):
        yield scan_at(room(), SE2(5.0, 5.0, 0.0), beams=36, stamp=float(k)), pose
        pose = pose @ SE2(0.08, 0.01, 0.03)


def turned(covariance: Floats, angle: float) -> Floats:
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    result: Floats = turn @ covariance @ turn.T
    return result


def test_poses_follow_matches_with_covariances_in_map(monkeypatch: pytest.MonkeyPatch) -> None:
    scripted = Scripted()
    monkeypatch.setattr(slam, "Tracker", lambda *_: scripted)
    mapper, expected, last = Slam(CONFIG), next(drive())[1], None
    turns = set()
    for k, (scan, odometry) in enumerate(drive()):
        update = mapper.process(scan, odometry)
        assert update is not None
        if last is not None:
            expected = expected @ (last.inverse() @ odometry) @ SLIP
        last = odometry
        assert update.T_map_base.array() == pytest.approx(expected.array())
        assert (update.T_map_odom @ odometry).array() == pytest.approx(expected.array())
        assert update.keyframe is (k % 3 == 0)
        assert (update.closures, update.status) == (0, MatchStatus.MATCHED)
        assert update.node == k // 3
        on_node = mapper.graph.pose(update.node) @ update.T_node_base
        assert on_node.array() == pytest.approx(expected.array())
        if k == 0:
            assert not update.covariance.any()
            continue
        # It is the reference's axes that a match is in.
        angles = [mapper.graph.pose(n).theta for n in range(len(mapper.graph))]
        (turn,) = (
            n for n, a in enumerate(angles) if np.allclose(update.covariance, turned(KNOWN, a))
        )
        turns.add(turn)
    assert len(turns) == 3
    assert scripted.searched == [k % 3 == 0 for k in range(1, 40)]
    step = np.linalg.inv(CONFIG.odometry_covariance(SE2(0.08, 0.01, 0.03)))
    for information in scripted.information:
        np.testing.assert_allclose(information, step, rtol=1e-6)
    assert [stamp for stamp, _ in mapper.trajectory()] == [3.0 * k for k in range(14)]
    assert [pose.array().tolist() for _, pose in mapper.trajectory()] == mapper.graph.poses.tolist()


@pytest.mark.parametrize(("matching", "failing"), [(True, (20,)), (True, ()), (False, ())])
def test_a_keyframe_is_tied_to_the_one_before_and_to_one_of_each_submap(
    matching: bool, failing: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slam, "Tracker", lambda *_: Scripted(failing))
    mapper = Slam(replace(CONFIG, use_scan_matching=matching))
    odometry = [pose for scan, pose in drive() if mapper.process(scan, pose)]
    odometric = [edge for edge in mapper.graph.edges if edge.kind is EdgeKind.ODOMETRY]
    assert [(edge.i, edge.j) for edge in odometric] == [(k, k + 1) for k in range(13)]
    for edge in odometric:
        step = odometry[3 * edge.i].inverse() @ odometry[3 * edge.j]
        step = SE2(STRETCH * step.x, STRETCH * step.y, step.theta)
        assert edge.T_i_j.array() == pytest.approx(step.array())
        known = np.linalg.inv(CONFIG.odometry_covariance(step))
        np.testing.assert_allclose(edge.information, known, rtol=1e-6)
    matches = [edge for edge in mapper.graph.edges if edge.kind is EdgeKind.MATCH]
    counts = [sum(edge.j == node for edge in matches) for node in range(1, 14)]
    failed = {k // 3 for k in failing}
    assert all((count > 0) is (matching and k not in failed) for k, count in enumerate(counts))
    if matching:
        assert set(counts) - {0} == {1, 2}  # of a submap, and of the next from half of it on
    for edge in matches:
        assert mapper.graph.residual(edge) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
        assert edge.prior is not None
        prior = np.linalg.inv(CONFIG.odometry_covariance(edge.T_i_j))
        np.testing.assert_allclose(edge.prior, prior, rtol=1e-6)
        if not failing:  # as well as the match: in the axes of some submap or other
            values = np.linalg.eigvalsh(np.linalg.inv(edge.information))
            np.testing.assert_allclose(values, np.linalg.eigvalsh(KNOWN), rtol=1e-6)


def session() -> Session:
    """Return a session of three keyframes away from the origin, the last odometry known."""
    scans = tuple(scan_at(room(), SE2(5, 5, 0), beams=36, stamp=-9.0 + k) for k in range(3))
    poses = np.array([(4.0, -1.0, 0.8), (4.3, -0.8, 0.9), (4.6, -0.5, 1.2)])
    return Session(scans, poses, np.array([0.0, 0.4, 0.8]), (), ((0, 1, 2),), SE2(6.8, 3.1, 1.9))


@dataclass
class Reference:
    """Stands for the map of a session: it finds a start, or does not at first."""

    lost: int = 0
    status: MatchStatus = MatchStatus.MATCHED
    pose: SE2 = SE2(4.2, -0.7, 1.0)  # noqa: RUF009
    field: None = None

    def __call__(self, *_: object) -> Reference:
        return self

    def find(self, _surface: Surface, start: Start) -> Match:
        self.lost -= 1
        status = MatchStatus.LOW_RESPONSE if self.lost >= 0 else self.status
        return Match(status, self.pose, KNOWN, 0.8)


@pytest.mark.parametrize("kind", [StartKind.ANYWHERE, StartKind.FIRST_NODE])
def test_it_localizes_where_it_is_found(kind: StartKind, monkeypatch: pytest.MonkeyPatch) -> None:
    scripted, reference = Scripted(), Reference(lost=2)
    monkeypatch.setattr(localization, "Tracker", lambda *_: scripted)
    monkeypatch.setattr(localization, "ReferenceMap", reference)
    localizer, expected, last = Localizer(CONFIG, session(), Start(kind)), reference.pose, None
    waits = 2 if kind is StartKind.ANYWHERE else 0
    for k, (scan, odometry) in enumerate(drive(15)):
        update = localizer.process(scan, odometry)
        if k < waits:
            assert update is None
            continue
        assert update is not None
        if last is not None:
            expected = expected @ (last.inverse() @ odometry) @ SLIP
        last = odometry
        assert update.T_map_base.array() == pytest.approx(expected.array())
        assert (update.T_map_odom @ odometry).array() == pytest.approx(expected.array())
        np.testing.assert_array_equal(update.covariance, KNOWN)
        assert (update.keyframe, update.closures, update.node) == (False, 0, 0)
        on_node = localizer.graph.pose(0) @ update.T_node_base
        assert on_node.array() == pytest.approx(expected.array())
        lost = kind is StartKind.FIRST_NODE and k == 0  # it is believed all the same, and said so
        assert (update.status is MatchStatus.LOW_RESPONSE) is lost
    assert scripted.searched == [k % 3 == waits for k in range(waits + 1, 15)]
    assert localizer.scans.skipped == waits
    reference.pose = SE2(1.0, 1.0, 1.0)
    localizer.restart(Start(StartKind.NEAR_POSE, SE2()))
    scan, odometry = list(drive(16))[-1]
    update = localizer.process(scan, odometry)
    assert update is not None
    assert update.T_map_base == reference.pose


@pytest.mark.parametrize(
    ("status", "information"),
    [
        (MatchStatus.MATCHED, np.linalg.inv(KNOWN)),
        (MatchStatus.LOW_RESPONSE, np.diag([4.0, 4.0, 10.0])),  # half a metre and 0.3 rad
    ],
)
def test_a_resumed_map_continues_from_its_nearest_keyframe(
    status: MatchStatus, information: Floats, monkeypatch: pytest.MonkeyPatch
) -> None:
    scripted, reference = Scripted(), Reference(status=status)
    monkeypatch.setattr(slam, "Tracker", lambda *_: scripted)
    monkeypatch.setattr(slam, "ReferenceMap", reference)
    mapper = Slam(CONFIG)
    mapper.resume(session(), Start(StartKind.NEAR_POSE))
    updates = [mapper.process(scan, odometry) for scan, odometry in drive(9)]
    first, *_, last = updates
    assert first is not None
    assert last is not None
    assert first.T_map_base.array() == pytest.approx(reference.pose.array())
    assert (first.status, first.node, first.keyframe, first.closures) == (status, 3, True, 0)
    np.testing.assert_allclose(first.covariance, turned(KNOWN, reference.pose.theta))
    edge = mapper.graph.edges[0]
    assert (edge.i, edge.j, edge.kind) == (1, 3, EdgeKind.MATCH)
    assert mapper.graph.residual(edge) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    np.testing.assert_allclose(edge.information, information, rtol=1e-6)
    again = mapper.session()
    assert again is not None
    step = np.hypot(0.08, 0.01)  # of each step, on top of the session's
    assert again.travel == pytest.approx([0.0, 0.4, 0.8, 0.8, 0.8 + 3 * step, 0.8 + 6 * step])
    assert len(again.scans) == 6


def test_odometry_continues_from_the_last_keyframe(monkeypatch: pytest.MonkeyPatch) -> None:
    scripted = Scripted()
    monkeypatch.setattr(slam, "Tracker", lambda *_: scripted)
    monkeypatch.setattr(slam, "ReferenceMap", Reference())
    mapper = Slam(CONFIG)
    mapper.resume(session(), Start(StartKind.ODOMETRY))
    ((scan, odometry),) = drive(1)
    update = mapper.process(scan, odometry)
    assert update is not None
    delta = SE2(6.8, 3.1, 1.9).inverse() @ odometry
    expected = SE2(4.6, -0.5, 1.2) @ delta @ SLIP
    assert update.T_map_base.array() == pytest.approx(expected.array())
    assert scripted.searched == [True]
    known = np.linalg.inv(CONFIG.odometry_covariance(delta))
    np.testing.assert_allclose(scripted.information[0], known, rtol=1e-6)
