"""Continuous refinement: Gauss-Newton on the distances of a scan's points to the reference.

Each step solves sum w (d + n J delta)^2 + prior, with d and n the distance and its gradient at the
point and w a Geman-McClure weight. SLAM's reference is an implicit surface with normals, AMCL's a
map's distance field; where a field has no planes, its values are distances.

Sources: Deschaud, IMLS-SLAM, 2018, section III-C; Hess et al., Real-time loop closure in 2D LIDAR
SLAM, 2016, section IV (scan to map); Zhang, Parameter estimation techniques, 1997 (M-estimators).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Singles

# A field's values `(H, W)`, which are rows of its planes, or distances [m] where it has none; its
# planes `(K, 4) float32`; edge of a cell [m]; origin `(2,) float64` [m]
Reference = tuple[NDArray[Any], Singles | None, float, Floats]

# Weights rise from 0 to 1 between two values, because hard limits make the steps cycle.
_SUPPORT_MIN, _SUPPORT_FULL = 0.02, 0.2  # how much reference is around a point
_ALIGNED_MIN, _ALIGNED_FULL = 0.3, 0.7  # how well its normals agree; a thin wall's cancel
_FACING_MIN, _FACING_FULL = 0.3, 0.7  # cosine between the point's normal and the reference's
_ASKEW = math.cos(0.3)  # between a wall's direction and what a normal's noise may make of it
_DEGENERATE = 0.1  # share of the best seen direction below which another is looked at closely
_DOUBTED = 3.0  # deviations from which odometry is doubted
_ONE_THING = 4.0  # how much more odometry counts along a direction that few points see
_WHOLE_STEPS = 10  # after so many, steps are halved, so that a cycle comes to rest
_STEP_DONE = 1e-4  # [m, rad]
_STEP_CLOSE = 3e-3  # [m, rad]; a cycle no larger than this counts as converged


@njit(cache=True)
def _ramp(value: float, low: float, high: float) -> float:
    return min(max((value - low) / (high - low), 0.0), 1.0)


@njit(cache=True)
def sample_surface(
    index: NDArray[np.uint16 | np.int32], planes: Singles, gx: float, gy: float, resolution: float
) -> tuple[float, float, float, float]:
    """Return signed distance [m], normal and trust (0..1) of the surface near a point [cells].

    The trust falls to 0 continuously where the reference thins out or its sides disagree.
    """
    height, width = index.shape
    fx, fy = gx - 0.5, gy - 0.5
    column, row = math.floor(fx), math.floor(fy)
    if row < 0 or column < 0 or row + 1 >= height or column + 1 >= width:
        return 0.0, 0.0, 0.0, 0.0
    a = bx = by = d = 0.0
    for q in range(4):
        r, c = row + q // 2, column + q % 2
        weight = (1.0 - abs(fx - c)) * (1.0 - abs(fy - r))
        k = index[r, c]
        if k == 0:
            continue
        pa, px, py, pd = planes[k]
        a += weight * pa
        bx += weight * px
        by += weight * py
        d += weight * ((px * (fx - c) + py * (fy - r)) * resolution - pd)
    length = math.hypot(bx, by)
    if a <= _SUPPORT_MIN or length <= _ALIGNED_MIN * a:
        return 0.0, 0.0, 0.0, 0.0
    trust = _ramp(a, _SUPPORT_MIN, _SUPPORT_FULL) * _ramp(length / a, _ALIGNED_MIN, _ALIGNED_FULL)
    return d / length, bx / length, by / length, trust


@njit(cache=True)
def sample_distance(
    distances: Singles, gx: float, gy: float, resolution: float
) -> tuple[float, float, float, float]:
    """Return the distance [m], interpolated between cells, its gradient and trust (0 or 1)."""
    height, width = distances.shape
    x, y = gx - 0.5, gy - 0.5
    if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
        return 0.0, 0.0, 0.0, 0.0
    column, row = np.uint32(x), np.uint32(y)  # spares the check for Python's negative indices
    u, v = x - column, y - row
    d00, d01 = distances[row, column], distances[row, column + np.uint32(1)]
    row += np.uint32(1)
    d10, d11 = distances[row, column], distances[row, column + np.uint32(1)]
    low, high = d00 + u * (d01 - d00), d10 + u * (d11 - d10)
    nx = ((1.0 - v) * (d01 - d00) + v * (d11 - d10)) / resolution
    return low + v * (high - low), nx, (high - low) / resolution, 1.0


@njit(cache=True)
def _linearize(
    values: NDArray[Any],
    planes: Singles | None,
    resolution: float,
    origin: Floats,
    points: Floats,
    normals: Floats | None,
    pose: Floats,
    scale: float,
    u: float,
    v: float,
) -> tuple[Floats, Floats, float, float]:
    """Return the normal equations, the sum of weights and that of weighted squares [m^2].

    Normals near the direction `(u, v)` are taken for it; `(0, 0)` for none.
    """
    xx = xy = xt = yy = yt = tt = gx = gy = gt = total = square = 0.0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(points)):
        rx, ry = c * points[i, 0] - s * points[i, 1], s * points[i, 0] + c * points[i, 1]
        column = (rx + pose[0] - origin[0]) / resolution
        row = (ry + pose[1] - origin[1]) / resolution
        if planes is None:
            d, nx, ny, trust = sample_distance(values, column, row, resolution)
        else:
            d, nx, ny, trust = sample_surface(values, planes, column, row, resolution)
        if trust == 0.0:
            continue
        ratio = d / scale
        w = trust / (1.0 + ratio * ratio) ** 2
        if normals is not None and (normals[i, 0] != 0.0 or normals[i, 1] != 0.0):
            along = nx * normals[i, 0] + ny * normals[i, 1]
            facing = c * along + s * (ny * normals[i, 0] - nx * normals[i, 1])
            if planes is None:  # a distance grows on either side of a wall
                facing = abs(facing)
            w *= _ramp(facing, _FACING_MIN, _FACING_FULL)
        along = nx * u + ny * v
        if abs(along) > _ASKEW:
            nx, ny = math.copysign(1.0, along) * u, math.copysign(1.0, along) * v
        nt = ny * rx - nx * ry
        wx, wy, wt = w * nx, w * ny, w * nt
        xx, xy, xt = xx + wx * nx, xy + wx * ny, xt + wx * nt
        yy, yt, tt = yy + wy * ny, yt + wy * nt, tt + wt * nt
        gx, gy, gt = gx + wx * d, gy + wy * d, gt + wt * d
        total, square = total + w, square + w * d * d
    h = np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
    return h, np.array([gx, gy, gt]), total, square


@njit(cache=True)
def observed(
    reference: Reference, points: Floats, normals: Floats, pose: Floats, scale: float
) -> Floats:
    """Return how much each direction is seen, `(3, 3) float64`, noise of the normals left out.

    Along a corridor the normals of its walls, each some degrees off, add up to a certainty that is
    none: what lies within `_ASKEW` of the walls' common direction counts as lying in it. Arguments
    as of `refine`.

    Source: the idea of Zhang, Kaess and Singh, On degeneracy of optimization-based state
    estimation problems, 2016.
    """
    values, planes, resolution, origin = reference
    h = _linearize(values, planes, resolution, origin, points, normals, pose, scale, 0.0, 0.0)[0]
    half = 0.5 * (h[0, 0] - h[1, 1])
    spread = math.hypot(half, h[0, 1])
    mean = 0.5 * (h[0, 0] + h[1, 1])
    if mean - spread > _DEGENERATE * (mean + spread):
        return h
    angle = 0.5 * math.atan2(h[0, 1], half)
    u, v = math.cos(angle), math.sin(angle)
    return _linearize(values, planes, resolution, origin, points, normals, pose, scale, u, v)[0]


@njit(cache=True)
def refine(
    reference: Reference,
    points: Floats,
    normals: Floats | None,
    start: Floats,
    prior: Floats,
    prior_information: Floats,
    scales: Floats,
    deviation: float,
) -> tuple[Floats, Floats, float, float, int]:
    """Return the refined pose and how well it fits.

    Args:
        points: `(N, 2) float64` in the robot's base frame [m].
        normals: Theirs, `(N, 2) float64`, zero where unknown; None for none.
        start: Pose to start from, `(3,) float64`.
        prior: Pose that the prior information is about, `(3,) float64`.
        prior_information: `(3, 3) float64`, which counts for more where little else is seen; where
            the field has planes it is odometry's, doubted where it is far off, as of a wheel that
            slips.
        scales: Of the Geman-McClure weight in each step, `(K,) float64` [m]; the last ones alike.
        deviation: Of a distance [m].

    Returns:
        Pose `(3,) float64`; information of the match alone `(3, 3) float64`; sum of the weights;
        weighted mean of the squared distances [m^2]; steps used, -1 if it did not converge.
    """
    values, planes, resolution, origin = reference
    pose, h = start.copy(), np.zeros((3, 3))
    total, square, step, done = 0.0, 0.0, math.inf, 0
    while done < len(scales) and (step >= _STEP_DONE or scales[done] != scales[done - 1]):
        h, g, total, square = _linearize(
            values, planes, resolution, origin, points, normals, pose, scales[done], 0.0, 0.0
        )
        h /= deviation * deviation
        error = pose - prior
        error[2] = (error[2] + math.pi) % (2.0 * math.pi) - math.pi
        held = prior_information.copy()
        if planes is not None:
            held /= 1.0 + error @ prior_information @ error / _DOUBTED**2
        _hold_unseen(held, h)
        pull = g / (deviation * deviation) + held @ error
        delta = solve(h + held, -pull)
        if done > _WHOLE_STEPS:
            delta *= 0.5
        pose += delta
        step, done = np.abs(delta).max(), done + 1
    return pose, h, total, square / max(total, 1e-12), done if step < _STEP_CLOSE else -1


@njit(cache=True)
def _hold_unseen(held: Floats, h: Floats) -> None:
    """Let odometry's information count for more along a direction that few points see.

    Those few are the corner of one thing, with one error.
    """
    half = 0.5 * (h[0, 0] - h[1, 1])
    spread = math.hypot(half, h[0, 1])
    mean = 0.5 * (h[0, 0] + h[1, 1])
    if mean - spread >= _DEGENERATE * (mean + spread):
        return
    angle = 0.5 * math.atan2(-h[0, 1], -half)
    u, v = math.cos(angle), math.sin(angle)
    known = u * u * held[0, 0] + 2.0 * u * v * held[0, 1] + v * v * held[1, 1]
    seen = (mean - spread) / (_DEGENERATE * (mean + spread))
    more = _ONE_THING * (1.0 - seen) * known
    held[0, 0] += more * u * u
    held[0, 1] += more * u * v
    held[1, 0] += more * u * v
    held[1, 1] += more * v * v


@njit(cache=True)
def solve(a: Floats, b: Floats) -> Floats:
    """Solve a positive definite 3 x 3 system by Cholesky decomposition."""
    l00 = math.sqrt(a[0, 0])
    l10, l20 = a[1, 0] / l00, a[2, 0] / l00
    l11 = math.sqrt(max(a[1, 1] - l10 * l10, 1e-12))
    l21 = (a[2, 1] - l20 * l10) / l11
    l22 = math.sqrt(max(a[2, 2] - l20 * l20 - l21 * l21, 1e-12))
    y0 = b[0] / l00
    y1 = (b[1] - l10 * y0) / l11
    y2 = (b[2] - l20 * y0 - l21 * y1) / l22
    x = np.empty(3)
    x[2] = y2 / l22
    x[1] = (y1 - l21 * x[2]) / l11
    x[0] = (y0 - l10 * x[1] - l20 * x[2]) / l00
    return x
