"""Checks of what callers hand to the filter; what fails here leaves the filter as it was."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

_PSD_TOLERANCE = 1e-9


class LocalizationError(ArjunaError, ValueError):
    """A pose, a covariance, a map or a limit cannot be used for localization."""


def check_map(grid: OccupancyGrid) -> None:
    """Raise unless the map has a resolution and both free and occupied cells.

    Raises:
        LocalizationError: A robot cannot be anywhere in the map, or nothing in it can be seen.
    """
    if not 0.0 < grid.frame.resolution < math.inf:
        raise LocalizationError(
            f"the map's resolution must be positive, got {grid.frame.resolution} m"
        )
    for name, mask in (("free", grid.free()), ("occupied", grid.occupied())):
        if not mask.any():
            raise LocalizationError(
                f"the map ({grid.frame.width} x {grid.frame.height} cells) has no {name} cell"
            )


def check_finite(pose: SE2, name: str) -> None:
    """Raise unless a pose is finite.

    Raises:
        LocalizationError: A coordinate is NaN or infinite.
    """
    if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
        raise LocalizationError(f"{name} must be finite, got {pose}")


def check_inside(pose: SE2, frame: GridFrame) -> None:
    """Raise unless a pose [m] of the map frame lies on a map.

    Raises:
        LocalizationError: The pose lies outside; the message gives the map's extent.
    """
    if not frame.contains(*frame.to_cell(pose.x, pose.y)):
        w, h = frame.width * frame.resolution, frame.height * frame.resolution
        corners = frame.origin.apply(np.array([[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]]))
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        raise LocalizationError(
            f"pose ({pose.x:.2f}, {pose.y:.2f}) m lies outside the map, "
            f"which spans x {x0:.2f} to {x1:.2f} m, y {y0:.2f} to {y1:.2f} m"
        )


def covariance_root(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a matrix L `(3, 3)` with `L @ L.T` the covariance `(3, 3)` of x, y, theta.

    Raises:
        LocalizationError: It is no finite, symmetric, positive semi-definite (3, 3) matrix.
    """
    covariance = np.asarray(covariance, dtype=np.float64)
    if covariance.shape != (3, 3) or not np.isfinite(covariance).all():
        raise LocalizationError("the covariance of x, y, theta must be a finite (3, 3) matrix")
    if not np.allclose(covariance, covariance.T, atol=_PSD_TOLERANCE):
        raise LocalizationError("the covariance of x, y, theta must be symmetric")
    values, vectors = np.linalg.eigh(covariance)
    if values[0] < -_PSD_TOLERANCE:
        raise LocalizationError(
            f"the covariance of x, y, theta must be positive semi-definite, "
            f"its least eigenvalue is {values[0]:.3g}"
        )
    root: NDArray[np.float64] = vectors * np.sqrt(np.maximum(values, 0.0))
    return root
