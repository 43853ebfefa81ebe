"""Continuous refinement: Gauss-Newton on the signed distances of a scan's points to the surface.

Each step solves sum w (d + n J delta)^2 + prior, with d and n the field's smoothed distance and
normal at the point and w a Geman-McClure weight. Sources: Deschaud, IMLS-SLAM, 2018, section III-C;
Zhang, Parameter estimation techniques, 1997 (M-estimators).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Weights rise from 0 to 1 between two values, because hard limits make the steps cycle.
_SUPPORT_MIN, _SUPPORT_FULL = 0.02, 0.2  # how much reference is around a point
_ALIGNED_MIN, _ALIGNED_FULL = 0.3, 0.7  # how well its normals agree; a thin wall's cancel
_FACING_MIN, _FACING_FULL = 0.3, 0.7  # cosine between the point's normal and the reference's
_STEP_DONE = 1e-4  # [m, rad]
_STEP_CLOSE = 3e-3  # [m, rad]; a cycle no larger than this counts as converged


@njit(cache=True)
def _ramp(value: float, low: float, high: float) -> float:
    """Rise linearly from 0 at low to 1 at high."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


@njit(cache=True)
def sample(
    index: NDArray[np.int32],
    planes: NDArray[np.float32],
    gx: float,
    gy: float,
    resolution: float,
) -> tuple[float, float, float, float]:
    """Return signed distance [m], normal and trust (0..1) of the surface near a point.

    The trust falls to 0 continuously where the reference thins out or its sides disagree.

    Args:
        index: The field's `(H, W) int32`.
        planes: The field's `(K, 4) float32`.
        gx: The point in cells from the field's origin.
        gy: As `gx`.
        resolution: Edge of a cell [m].
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
def _linearize(
    index: NDArray[np.int32],
    planes: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    pose: NDArray[np.float64],
    sigma: float,
    h: NDArray[np.float64],
    g: NDArray[np.float64],
) -> tuple[float, float]:
    """Fill the normal equations; return the sum of weights and of weighted squares [m^2]."""
    h[:] = 0.0
    g[:] = 0.0
    total = square = 0.0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(points)):
        rx = c * points[i, 0] - s * points[i, 1]
        ry = s * points[i, 0] + c * points[i, 1]
        gx = (rx + pose[0] - origin[0]) / resolution
        gy = (ry + pose[1] - origin[1]) / resolution
        d, nx, ny, trust = sample(index, planes, gx, gy, resolution)
        if trust == 0.0:
            continue
        ratio = d / sigma
        w = trust / (1.0 + ratio * ratio) ** 2
        qx, qy = normals[i, 0], normals[i, 1]
        if qx != 0.0 or qy != 0.0:
            facing = nx * (c * qx - s * qy) + ny * (s * qx + c * qy)
            w *= _ramp(facing, _FACING_MIN, _FACING_FULL)
        row = (nx, ny, ny * rx - nx * ry)
        total += w
        square += w * d * d
        for a in range(3):
            g[a] += w * row[a] * d
            for b in range(3):
                h[a, b] += w * row[a] * row[b]
    return total, square


@njit(cache=True)
def refine(
    index: NDArray[np.int32],
    planes: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    start: NDArray[np.float64],
    prior: NDArray[np.float64],
    prior_information: NDArray[np.float64],
    sigma: float,
    sigma_range: float,
    iterations: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, float, int]:
    """Return the refined pose and how well it fits.

    Args:
        index: The field's `(H, W) int32`.
        planes: The field's `(K, 4) float32`.
        resolution: Edge of a cell [m].
        origin: The field's `(2,) float64` [m].
        points: `(N, 2) float64` in the robot's base frame [m].
        normals: `(N, 2) float64` in the robot's base frame, zero where unknown.
        start: `(3,) float64` pose to start from.
        prior: `(3,) float64` pose that the prior information is about.
        prior_information: `(3, 3) float64`.
        sigma: Scale of the Geman-McClure weight [m].
        sigma_range: Deviation of a distance [m].
        iterations: Most steps; from the middle on they are halved.

    Returns:
        Pose `(3,) float64`; information of the match alone `(3, 3) float64`; sum of the weights;
        weighted mean of the squared distances [m^2]; iterations used, -1 if it did not converge.
    """
    pose, h, g = start.copy(), np.zeros((3, 3)), np.zeros(3)
    total = square = 0.0
    step, done = math.inf, 0
    while done < iterations and step >= _STEP_DONE:
        total, square = _linearize(
            index, planes, resolution, origin, points, normals, pose, sigma, h, g
        )
        h /= sigma_range * sigma_range
        g /= sigma_range * sigma_range
        error = pose - prior
        error[2] = (error[2] + math.pi) % (2.0 * math.pi) - math.pi
        delta = _solve3(h + prior_information, -g - prior_information @ error)
        if 2 * done > iterations:
            delta *= 0.5
        pose += delta
        step = np.abs(delta).max()
        done += 1
    return pose, h, total, square / max(total, 1e-12), done if step < _STEP_CLOSE else -1


@njit(cache=True)
def _solve3(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
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
