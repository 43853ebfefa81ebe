"""Refinement: a pose moved to where the scan fits the map best, finer than particles or cells."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_slam.amcl.field import DistanceField

_SIGMAS = (0.3, 0.3, 0.2, 0.1, 0.1, 0.1, 0.1)  # widths of the robust kernel, coarse to fine [m]
_DAMPING = 1e-6


def refine(
    field: DistanceField, pose: NDArray[np.float64], endpoints: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the pose at which beams end nearest to obstacles, near a given one.

    Gauss-Newton on the bilinearly interpolated distance field, with Welsch weights whose width
    shrinks so that the basin is wide and the end unmoved by what the map does not have.

    Args:
        field: The map's distances.
        pose: `(3,) float64` in the map frame [m, m, rad].
        endpoints: `(M, 2) float64` in the base frame [m].

    Returns:
        `(3,) float64` in the map frame; the given pose where no better one was found.

    Source: Hess et al., Real-time loop closure in 2D lidar SLAM, 2016, section IV (scan to map).
    """
    resolution = field.frame.resolution
    start = field.to_grid(pose[np.newaxis])[0]
    cells = endpoints / resolution
    outside = field.max_distance
    best = start
    for sigma in _SIGMAS:
        hessian, gradient, _ = _normal_equations(field.distances, outside, sigma, best, cells)
        damping = _DAMPING * (1.0 + np.trace(hessian))
        best = best - np.linalg.solve(hessian + damping * np.eye(3), gradient)
    before = _normal_equations(field.distances, outside, _SIGMAS[-1], start, cells)[2]
    after = _normal_equations(field.distances, outside, _SIGMAS[-1], best, cells)[2]
    return field.to_map(best).array() if after > before else pose


@njit(cache=True)
def _normal_equations(
    distances: NDArray[np.float32],
    outside: float,
    sigma: float,
    pose: NDArray[np.float64],
    endpoints: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the weighted `J.T J`, `J.T r` and the sum of weights; pose and endpoints in cells."""
    height, width = distances.shape
    hessian = np.zeros((3, 3))
    gradient = np.zeros(3)
    score = 0.0
    jacobian = np.empty(3)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for j in range(len(endpoints)):
        ex, ey = endpoints[j, 0], endpoints[j, 1]
        x = pose[0] + c * ex - s * ey - 0.5
        y = pose[1] + s * ex + c * ey - 0.5
        column, row = math.floor(x), math.floor(y)
        if not (0 <= column < width - 1 and 0 <= row < height - 1):
            continue
        u, v = x - column, y - row
        d00, d01 = distances[row, column], distances[row, column + 1]
        d10, d11 = distances[row + 1, column], distances[row + 1, column + 1]
        low, high = d00 + u * (d01 - d00), d10 + u * (d11 - d10)
        residual = low + v * (high - low)
        if residual >= outside:
            continue
        weight = math.exp(-residual * residual / (2.0 * sigma * sigma))
        jacobian[0] = (1.0 - v) * (d01 - d00) + v * (d11 - d10)
        jacobian[1] = high - low
        jacobian[2] = jacobian[0] * (-s * ex - c * ey) + jacobian[1] * (c * ex - s * ey)
        score += weight
        for a in range(3):
            gradient[a] += weight * jacobian[a] * residual
            for b in range(3):
                hessian[a, b] += weight * jacobian[a] * jacobian[b]
    return hessian, gradient, score
