"""Refinement: a pose moved to where the scan fits the map best, finer than particles or cells."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.se2 import wrap
from arjuna_slam.amcl.field import DistanceField
from arjuna_slam.amcl.sensors.agreement import agreement
from arjuna_slam.amcl.sensors.observation import Observation

_SIGMAS = np.array((0.3, 0.3, 0.2, 0.1, 0.1, 0.1, 0.1))  # of the robust kernel, coarse to fine [m]
_BEAM = 0.05  # deviation of a beam's end from the map, its neighbours' likeness included [m]
_SETTLED = 1e-3  # a shorter last step ends it [cells, rad]
_GOOD = 0.85  # agreement at which nobody looks further
_WORTH = 0.02  # agreement by which another start must be better
_STARTS = np.array(
    [(0.2 * math.cos(a), 0.2 * math.sin(a), 0.0) for a in np.arange(8) * math.pi / 4]
)
ANYWHERE = np.array((1.0, 1.0, 1.0))
_REFINED_WITHIN = np.array((0.5, 0.5, math.radians(15.0)))


def refine(
    field: DistanceField,
    pose: NDArray[np.float64],
    endpoints: NDArray[np.float64],
    deviations: NDArray[np.float64] = ANYWHERE,
) -> NDArray[np.float64]:
    """Return the pose at which beams end nearest to obstacles, near a given one.

    Gauss-Newton on the bilinearly interpolated distance field, with Welsch weights whose width
    shrinks so that the basin is wide and the end unmoved by what the map does not have. The given
    pose is a prior: along a bare corridor, where the scan says nothing, it stays.

    Args:
        field: The map's distances.
        pose: `(3,) float64` in the map frame [m, m, rad].
        endpoints: `(M, 2) float64` in the base frame [m].
        deviations: How far the pose may be off, `(3,) float64` [m, m, rad].

    Returns:
        `(3,) float64` in the map frame; the given pose where no better one was found near it.

    Source: Hess et al., Real-time loop closure in 2D lidar SLAM, 2016, section IV (scan to map).
    """
    resolution = field.frame.resolution
    start = field.to_grid(pose[np.newaxis])[0]
    metres = np.maximum(deviations, 1e-3)
    prior = (_BEAM / metres) ** 2 * (resolution**2, resolution**2, 1.0)
    best, gained = _descend(
        field.distances, field.max_distance, _SIGMAS, start, endpoints / resolution, prior
    )
    if not gained:
        return pose
    found = field.to_map(best).array()
    change = found - pose
    change[2] = wrap(change[2])
    return found if (np.abs(change) <= _REFINED_WITHIN).all() else pose


def refine_around(
    field: DistanceField,
    pose: NDArray[np.float64],
    seen: Observation,
    deviations: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Return the refined pose and its agreement; where that is poor, the best of several starts.

    A wall has two faces, and matching may settle on the wrong one.

    Args:
        field: The map's distances.
        pose: `(3,) float64` in the map frame [m, m, rad].
        seen: The scan.
        deviations: How far the pose may be off, `(3,) float64` [m, m, rad].
    """
    best = refine(field, pose, seen.many.endpoints, deviations)
    score = agreement(field, best, seen)
    if score >= _GOOD:
        return best, score
    for start in pose + _STARTS:
        other = refine(field, start, seen.many.endpoints, ANYWHERE)
        other_score = agreement(field, other, seen)
        if other_score > score + _WORTH:
            best, score = other, other_score
    return best, score


@njit(cache=True)
def _descend(
    distances: NDArray[np.float32],
    outside: float,
    sigmas: NDArray[np.float64],
    start: NDArray[np.float64],
    endpoints: NDArray[np.float64],
    prior: NDArray[np.float64],
) -> tuple[NDArray[np.float64], bool]:
    """Return the end of one Gauss-Newton step per width, and whether it is better; in cells."""
    best = start.copy()
    a, g = np.empty((3, 3)), np.empty(3)
    for sigma in sigmas:
        _normal_equations(distances, outside, sigma, best, endpoints, a, g)
        for k in range(3):
            a[k, k] += prior[k]
            g[k] += prior[k] * (best[k] - start[k])
        step = _solve(a, g)
        best -= step
        if sigma == sigmas[-1] and np.abs(step).max() < _SETTLED:
            break
    before = _normal_equations(distances, outside, sigmas[-1], start, endpoints, a, g)
    after = _normal_equations(distances, outside, sigmas[-1], best, endpoints, a, g)
    return best, after > before


@njit(cache=True)
def _solve(a: NDArray[np.float64], g: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a positive definite system of three equations by Cramer's rule."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    c11 = a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2]
    c12 = a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2]
    c22 = a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1]
    determinant = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    x = np.empty(3)
    x[0] = (c00 * g[0] + c01 * g[1] + c02 * g[2]) / determinant
    x[1] = (c01 * g[0] + c11 * g[1] + c12 * g[2]) / determinant
    x[2] = (c02 * g[0] + c12 * g[1] + c22 * g[2]) / determinant
    return x


@njit(cache=True)
def _normal_equations(
    distances: NDArray[np.float32],
    outside: float,
    sigma: float,
    pose: NDArray[np.float64],
    endpoints: NDArray[np.float64],
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> float:
    """Fill in the weighted `J.T J` and `J.T r`, return the sum of weights; places in cells."""
    height, width = distances.shape
    xx = xy = xt = yy = yt = tt = gx = gy = gt = score = 0.0
    c, s = math.cos(pose[2]), math.sin(pose[2])
    sharpness = -0.5 / (sigma * sigma)
    for j in range(len(endpoints)):
        ex = c * endpoints[j, 0] - s * endpoints[j, 1]
        ey = s * endpoints[j, 0] + c * endpoints[j, 1]
        x, y = pose[0] + ex - 0.5, pose[1] + ey - 0.5
        if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
            continue
        column, row = np.uint32(x), np.uint32(y)
        u, v = x - column, y - row
        d00, d01 = distances[row, column], distances[row, column + np.uint32(1)]
        row += np.uint32(1)
        d10, d11 = distances[row, column], distances[row, column + np.uint32(1)]
        low, high = d00 + u * (d01 - d00), d10 + u * (d11 - d10)
        residual = low + v * (high - low)
        if residual >= outside:
            continue
        weight = math.exp(sharpness * residual * residual)
        jx, jy = (1.0 - v) * (d01 - d00) + v * (d11 - d10), high - low
        jt = jy * ex - jx * ey
        score += weight
        wx, wy, wt = weight * jx, weight * jy, weight * jt
        xx += wx * jx
        xy += wx * jy
        xt += wx * jt
        yy += wy * jy
        yt += wy * jt
        tt += wt * jt
        gx += wx * residual
        gy += wy * residual
        gt += wt * residual
    hessian[0, 0], hessian[0, 1], hessian[0, 2] = xx, xy, xt
    hessian[1, 0], hessian[1, 1], hessian[1, 2] = xy, yy, yt
    hessian[2, 0], hessian[2, 1], hessian[2, 2] = xt, yt, tt
    gradient[0], gradient[1], gradient[2] = gx, gy, gt
    return score
