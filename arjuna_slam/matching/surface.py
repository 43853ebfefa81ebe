"""Scan to surface: end points in beam order, their links and the normals of their walls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

_BREAK_ANGLE = math.radians(10.0)  # flatter than this to the beam, a surface counts as two
_BREAK_NOISE = 0.06  # that noise adds to the gap between neighbours [m]
_LINK_BEAMS = 4  # a wall continues over up to three beams that were lost
_FLATNESS = 0.1  # of the spread across to that along, above which points show no direction
_SAME_WALL = 0.8  # cosine between the normals of neighbours: 37 degrees


@dataclass(frozen=True)
class Surface:
    """The surfaces that one scan saw, in the robot's base frame."""

    points: Floats  # end points of the valid beams, in beam order, `(N, 2) float64` [m]
    # unit normals towards the sensor, `(N, 2) float64`; zero where there is no wall
    normals: Floats
    linked: Bools  # `(N,) bool`, whether point i and point i + 1 lie on one surface

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def dense(self, spacing: float) -> tuple[Floats, Floats]:
        """Return points and normals, `(M, 2)`; gaps on walls are filled to `spacing` [m]."""
        return _densify(self.points, self.normals, self.linked, spacing)


def extract(scan: Scan, range_max: float, reach: float = 0.2) -> Surface:
    """Return the surface of a scan, which may have any beams and field of view.

    Its motion is undone; a normal is fitted to the wall up to `reach` [m] to each side.

    Source: breakpoints, Borges and Aldon, Line extraction in 2D range images, 2004; normals as
    principal axes of the neighbours.
    """
    points, beams, lengths = _extract(
        np.asarray(scan.ranges, dtype=np.float64),
        scan.rays(),
        scan.range_min,
        min(scan.range_max, range_max),
    )
    linked = _link(points, beams, lengths, scan.angle_increment)
    return Surface(points, _fit_normals(points, linked, reach, scan.T_base_sensor.array()), linked)


def wall_normals(
    points: Floats, beams: Ints, ranges: Floats, increment: float, mount: SE2, reach: float = 0.2
) -> Floats:
    """Return the normals at beams' ends `(N, 2)` as of a `Surface`, `(N, 2) float64`.

    `beams` are the beams' numbers, `increment` is the angle [rad] from one number to the next.
    """
    linked = _link(points, beams, ranges, increment)
    normals: Floats = _fit_normals(points, linked, reach, mount.array())
    return normals


@njit(cache=True)
def _extract(
    ranges: Floats, rays: Floats, range_min: float, range_max: float
) -> tuple[Floats, Ints, Floats]:
    """Return the ends, the numbers and the ranges of the valid beams."""
    count = 0
    beam = np.empty(len(ranges), np.int64)
    points = np.empty((len(ranges), 2))
    for i in range(len(ranges)):
        r = ranges[i]
        if r >= range_min and r < range_max and r > 0.0:
            points[count, 0] = rays[i, 0] + r * math.cos(rays[i, 2])
            points[count, 1] = rays[i, 1] + r * math.sin(rays[i, 2])
            beam[count] = i
            count += 1
    return points[:count], beam[:count], ranges[beam[:count]]


@njit(cache=True)
def _link(points: Floats, beams: Ints, ranges: Floats, increment: float) -> Bools:
    """Return whether points i and i + 1 lie on one surface, `(N,) bool`."""
    linked = np.zeros(len(points), np.bool_)
    step = abs(increment)
    factor = math.sin(step) / math.sin(_BREAK_ANGLE) if step < _BREAK_ANGLE else 2.0
    for i in range(len(points) - 1):
        near = min(ranges[i], ranges[i + 1])
        gap = math.hypot(points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1])
        linked[i] = beams[i + 1] - beams[i] <= _LINK_BEAMS and gap < near * factor + _BREAK_NOISE
    return linked


@njit(cache=True)
def _fit_normals(points: Floats, linked: Bools, reach: float, mount: Floats) -> Floats:
    """Return the normal of each point from its linked neighbours, at least one to each side."""
    count = len(points)
    normals = np.zeros((count, 2))
    sums = _running_sums(points)
    first = last = 0
    for i in range(count):
        if i == 0 or not linked[i - 1]:
            first = i
        x, y = points[i, 0], points[i, 1]
        while first < i - 1 and math.hypot(points[first, 0] - x, points[first, 1] - y) > reach:
            first += 1
        last = max(last, i)
        while last < count - 1 and linked[last]:
            near = math.hypot(points[last + 1, 0] - x, points[last + 1, 1] - y) <= reach
            if not near and last > i:
                break
            last += 1
        n = last - first + 1
        if n < 3:
            continue
        before, after = sums[first], sums[last + 1]
        mx, my = (after[0] - before[0]) / n, (after[1] - before[1]) / n
        xx = (after[2] - before[2]) / n - mx * mx
        xy = (after[3] - before[3]) / n - mx * my
        yy = (after[4] - before[4]) / n - my * my
        mean, spread = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
        if mean - spread > _FLATNESS * (mean + spread):
            continue
        nx, ny = _short_axis(xx, xy, yy)
        toward = nx * (mount[0] - x) + ny * (mount[1] - y) >= 0.0
        normals[i, 0] = nx if toward else -nx
        normals[i, 1] = ny if toward else -ny
    return normals


@njit(cache=True)
def _running_sums(points: Floats) -> Floats:
    """Return sums of x, y, x^2, x y and y^2 over all points before each, `(N + 1, 5)`."""
    sums = np.zeros((len(points) + 1, 5))
    for i in range(len(points)):
        x, y = points[i, 0], points[i, 1]
        sums[i + 1, 0] = sums[i, 0] + x
        sums[i + 1, 1] = sums[i, 1] + y
        sums[i + 1, 2] = sums[i, 2] + x * x
        sums[i + 1, 3] = sums[i, 3] + x * y
        sums[i + 1, 4] = sums[i, 4] + y * y
    return sums


@njit(cache=True)
def _short_axis(xx: float, xy: float, yy: float) -> tuple[float, float]:
    """Return the unit vector of least spread of a 2 x 2 covariance."""
    half = 0.5 * (xx - yy)
    spread = math.hypot(half, xy)
    if spread == 0.0:
        return 0.0, 1.0
    if half > 0.0:
        c = math.sqrt(0.5 * (1.0 + half / spread))
        return -0.5 * xy / (spread * c), c
    s = math.sqrt(0.5 * (1.0 - half / spread))
    return -s, 0.5 * xy / (spread * s)


@njit(cache=True)
def _densify(
    points: Floats, normals: Floats, linked: Bools, spacing: float
) -> tuple[Floats, Floats]:
    count = len(points)
    extra = np.zeros(count, np.int64)
    total = count
    for i in range(count - 1):
        dot = normals[i, 0] * normals[i + 1, 0] + normals[i, 1] * normals[i + 1, 1]
        if linked[i] and dot > _SAME_WALL:
            gap = math.hypot(points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1])
            extra[i] = int(gap / spacing)
            total += extra[i]
    dense_points, dense_normals = np.empty((total, 2)), np.empty((total, 2))
    k = 0
    for i in range(count):
        dense_points[k] = points[i]
        dense_normals[k] = normals[i]
        k += 1
        for j in range(extra[i]):
            ratio = (j + 1.0) / (extra[i] + 1.0)
            for axis in range(2):
                step = points[i + 1, axis] - points[i, axis]
                dense_points[k, axis] = points[i, axis] + ratio * step
                turn = normals[i + 1, axis] - normals[i, axis]
                dense_normals[k, axis] = normals[i, axis] + ratio * turn
            length = math.hypot(dense_normals[k, 0], dense_normals[k, 1])
            dense_normals[k, 0] /= length
            dense_normals[k, 1] /= length
            k += 1
    return dense_points, dense_normals
