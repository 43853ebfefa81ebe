"""Drives through made-up buildings, and real logs, with odometry that drifts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arjuna_core.raycast import cast
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_slam import offline
from arjuna_slam.graph.pose_graph import Edge
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.slam import Slam
from tests.helpers.buildings import RESOLUTION, Building

_CORNER = 0.7  # how far from a corner it is cut [m]
_TURN = 0.6  # between two scans at most [rad]
_WANDER = 0.25  # deviation from the middle of the road [m]
_LOST, _SIGMA = 0.01, 0.015  # share of beams without return; of the ranges [m]


@dataclass(frozen=True)
class Drift:
    """Errors of odometry.

    Attributes:
        walk: Of the heading [rad per sqrt(m)].
        bias: Of the heading [rad/m].
        scale: Share by which distances are too long.
    """

    walk: float = 0.02
    bias: float = 0.01
    scale: float = 0.02

    def times(self, factor: float) -> Drift:
        """Return a drift so much worse."""
        return Drift(self.walk * factor, self.bias * factor, self.scale * factor)


@dataclass(frozen=True)
class Lidar:
    """A scanner: beams, field of view [rad] and longest range [m]."""

    beams: int
    field_of_view: float
    range_max: float


LIDARS = (Lidar(180, math.pi, 30.0), Lidar(360, 2.0 * math.pi, 12.0), Lidar(270, 4.7, 20.0))
Drive = list[tuple[Scan, SE2, SE2]]
"""Scan, odometry and true pose."""


def drive(
    building: Building, seed: int, length: float, spacing: float, lidar: Lidar, drift: Drift
) -> Drive:
    """Return a drive through a building.

    Args:
        seed: Of all that is random.
        length: Of the drive [m].
        spacing: Of the scans [m].
        drift: How the odometry errs; the sign of its bias and of its scale is drawn.
    """
    rng = np.random.default_rng([seed, 2])
    poses = along(_walk(building, rng, length), spacing, rng)
    error = DriftingOdometry(drift, rng)
    result, before, odometry = [], poses[0], SE2()
    for k, truth in enumerate(poses):
        odometry = odometry @ error.measured(before.inverse() @ truth)
        before = truth
        result.append((_scan(building, truth, lidar, rng, float(k)), odometry, truth))
    return result


class DriftingOdometry:
    """Odometry that errs.

    Args:
        rng: Source of randomness; the signs of bias and scale are drawn.
    """

    def __init__(self, drift: Drift, rng: np.random.Generator) -> None:
        self._drift, self._rng = drift, rng
        turn, stretch = rng.choice([-1.0, 1.0], 2).tolist()
        self._bias, self._scale = turn * drift.bias, 1.0 + stretch * drift.scale

    def measured(self, step: SE2) -> SE2:
        """Return what is measured of a step."""
        length = math.hypot(step.x, step.y)
        walk = self._rng.normal(0.0, self._drift.walk * math.sqrt(length))
        theta = step.theta + self._bias * length + walk
        return SE2(step.x * self._scale, step.y * self._scale, theta)


def _scan(
    building: Building, pose: SE2, lidar: Lidar, rng: np.random.Generator, stamp: float
) -> Scan:
    increment = lidar.field_of_view / lidar.beams
    first = -0.5 * (lidar.field_of_view - increment)
    bearings = pose.theta + first + increment * np.arange(lidar.beams, dtype=np.float64)
    ranges = cast(building.blocked, RESOLUTION, pose.x, pose.y, bearings, lidar.range_max)
    ranges = ranges + rng.normal(0.0, _SIGMA, lidar.beams)
    ranges[rng.random(lidar.beams) < _LOST] = np.inf
    return Scan(ranges, first, increment, 0.02, lidar.range_max, stamp)


def _walk(building: Building, rng: np.random.Generator, length: float) -> NDArray[np.float64]:
    """Return corners of a walk on the net, `(K, 2)` [m]: mostly to where it has been least."""
    ends: dict[int, list[int]] = {}
    for a, b in building.roads:
        ends.setdefault(a, []).append(b)
        ends.setdefault(b, []).append(a)
    here = int(rng.choice(sorted(ends)))
    walk, gone, last = [here], 0.0, -1
    visits: dict[tuple[int, int], int] = {}
    while gone < length:
        options = [k for k in ends[here] if k != last] or ends[here]
        options = [options[k] for k in rng.permutation(len(options))]
        if rng.random() < 0.7:
            options.sort(key=lambda k: visits.get((min(here, k), max(here, k)), 0))
        last, here = here, options[0]
        edge = min(last, here), max(last, here)
        visits[edge] = visits.get(edge, 0) + 1
        gone += math.dist(building.points[last], building.points[here])
        walk.append(here)
    return np.array([building.points[k] for k in walk])


def along(corners: NDArray[np.float64], spacing: float, rng: np.random.Generator) -> list[SE2]:
    """Return poses along a road of straight pieces, corners cut, lines not quite straight.

    Args:
        corners: `(K, 2) float64` [m].
        spacing: Between poses [m].
    """
    cut = _cut(corners)
    pieces = np.hypot(*np.diff(cut, axis=0).T)
    at = np.concatenate(([0.0], np.cumsum(pieces)))
    distances = np.arange(0.0, at[-1], spacing)
    line = np.column_stack([np.interp(distances, at, cut[:, k]) for k in (0, 1)])
    ahead = np.column_stack([np.interp(distances + 0.3, at, cut[:, k]) for k in (0, 1)])
    behind = np.column_stack([np.interp(distances - 0.3, at, cut[:, k]) for k in (0, 1)])
    heading = np.unwrap(np.arctan2(*(ahead - behind).T[::-1]))
    knots = np.arange(0.0, at[-1] + 5.0, 5.0)
    off = np.interp(distances, knots, rng.normal(0.0, _WANDER, len(knots)))
    off = np.clip(off, -2.0 * _WANDER, 2.0 * _WANDER)
    line += off[:, None] * np.column_stack((-np.sin(heading), np.cos(heading)))
    heading = heading + np.interp(distances, knots, rng.normal(0.0, 0.05, len(knots)))
    return _turning(np.column_stack((line, heading)))


def _turning(poses: NDArray[np.float64]) -> list[SE2]:
    """Return poses with some between those that turn by more than a scanner may miss."""
    result = []
    for a, b in pairwise(poses):
        steps = 1 + int(abs(b[2] - a[2]) / _TURN)
        result += [SE2.from_array(a + (b - a) * (k / steps)) for k in range(steps)]
    return result


def _cut(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace each inner corner by two points near it."""
    result = [corners[0]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        for other in (before, after):
            span = float(np.hypot(*(other - corner)))
            result.append(corner + (other - corner) * min(_CORNER / span, 0.3))
    result.append(corners[-1])
    return np.array(result)


_SPACING, _TURN = 1.0, 0.6  # between two scans [m, rad]


def corrected(path: Path, *, as_is: bool) -> list[tuple[Scan, SE2]]:
    """Return a log's scans and where each was taken.

    Args:
        as_is: Whether its poses are corrected already; else it is mapped, and what comes out of
            that is taken for the truth.
    """
    log = list(open_log(path, RecordingTopics()))
    if as_is:
        return log
    scans = {scan.stamp: scan for scan, _ in log}
    return [(scans[stamp], pose) for stamp, pose in offline.run(Slam(), log)]


def thinned(posed: Sequence[tuple[Scan, SE2]]) -> list[tuple[Scan, SE2]]:
    """Return scans a metre or 0.6 rad apart, numbered by their stamps."""
    result: list[tuple[Scan, SE2]] = []
    for scan, pose in posed:
        gap = result[-1][1].inverse() @ pose if result else None
        if gap is None or math.hypot(gap.x, gap.y) >= _SPACING or abs(wrap(gap.theta)) >= _TURN:
            result.append((replace(scan, stamp=float(len(result))), pose))
    return result


def drifting(posed: Sequence[tuple[Scan, SE2]], seed: int, drift: Drift) -> Drive:
    """Return a log with odometry that drifts.

    Args:
        posed: Scans and their true poses.
    """
    error = DriftingOdometry(drift, np.random.default_rng([seed, 4]))
    result, odometry, before = [], SE2(), posed[0][1]
    for scan, pose in posed:
        odometry = odometry @ error.measured(before.inverse() @ pose)
        before = pose
        result.append((scan, odometry, pose))
    return result


_NEAR, _APART = 1.5, 20.0  # two poses near each other, and the path between two visits [m]
_RUN_GAP = 5  # scans that revisit nothing without ending a loop
_SLACK = np.diag([0.1**2, 0.1**2, 0.03**2])  # on top of what a closure claims of itself
_DEVIATIONS = 3.0


def near_pairs(true: NDArray[np.float64], walls: Building | None) -> NDArray[np.int64]:
    """Return pairs of poses near each other with a path between them, `(P, 2) int64`.

    Args:
        true: The true poses, `(N, 3) float64` [m, m, rad].
        walls: Only pairs in sight of each other count; None for all.
    """
    travel = travelled(true)
    pairs: NDArray[np.int64] = cKDTree(true[:, :2]).query_pairs(_NEAR, output_type="ndarray")
    pairs = pairs[np.abs(travel[pairs[:, 1]] - travel[pairs[:, 0]]) > _APART]
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    if walls is None:
        return pairs
    seen = np.array([_in_sight(true[i], true[j], walls) for i, j in pairs], np.bool_)
    visible: NDArray[np.int64] = pairs[seen]
    return visible


def _in_sight(a: NDArray[np.float64], b: NDArray[np.float64], walls: Building) -> bool:
    gap = b - a
    bearing, far = np.array([math.atan2(gap[1], gap[0])]), math.hypot(gap[0], gap[1])
    free = cast(walls.blocked, RESOLUTION, float(a[0]), float(a[1]), bearing, far)[0]
    return bool(free >= far)


def travelled(true: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance driven to each pose from the first, `(N,) float64` [m]."""
    steps = np.hypot(*np.diff(true[:, :2], axis=0).T)
    return np.concatenate(([0.0], np.cumsum(steps)))


def errors(
    found: NDArray[np.float64], true: NDArray[np.float64], pairs: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return how far off the second of each pair is as seen from the first, `(P,)` [m]."""
    seen = []
    for poses in (found, true):
        first, second = poses[pairs[:, 0]], poses[pairs[:, 1]]
        c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx, dy = (second - first)[:, :2].T
        seen.append(np.array([c * dx + s * dy, c * dy - s * dx]))
    error: NDArray[np.float64] = np.hypot(*(seen[0] - seen[1]))
    return error


def agreement_of_loops(pairs: NDArray[np.int64], good: NDArray[np.bool_]) -> list[float]:
    """Return the share of agreeing pairs of each stretch that revisits."""
    return [float(good[k].mean()) for k in _stretches(pairs)]


def _stretches(pairs: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    if len(pairs):
        breaks = np.flatnonzero(np.diff(pairs[:, 1]) > _RUN_GAP) + 1
        yield from np.split(np.arange(len(pairs)), breaks)


def is_wrong(edge: Edge, truth: list[SE2]) -> bool:
    """Return whether a closure is off by more than it says of itself, and some slack."""
    true = truth[edge.i].inverse() @ truth[edge.j]
    error = edge.T_i_j.array() - true.array()
    error[2] = math.remainder(error[2], 2.0 * math.pi)
    claimed = np.linalg.inv(edge.information) + _SLACK
    return bool(error @ np.linalg.solve(claimed, error) > _DEVIATIONS**2)


def aligned_error(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """Return the root mean square error of positions after the best rigid alignment [m]."""
    a, b = (complex_poses - complex_poses.mean() for complex_poses in map(_complex, (found, true)))
    turn = np.vdot(a, b)
    return float(np.sqrt(np.mean(np.abs(a * turn / max(abs(turn), 1e-12) - b) ** 2)))


def _complex(poses: NDArray[np.float64]) -> NDArray[np.complex128]:
    points: NDArray[np.complex128] = poses[:, 0] + 1j * poses[:, 1]
    return points
