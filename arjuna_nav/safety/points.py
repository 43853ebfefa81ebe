"""Points of what sensors tell as a whole: a cone's arc, a polygon's edges."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def on_arc(distance: float, field_of_view: float, step: float) -> NDArray[np.float64]:
    """Return points at a distance all over a field of view, `(N, 2) float64` [m].

    Args:
        distance: From the sensor [m].
        field_of_view: Of the sensor, half of it to each side [rad].
        step: Between two points [rad].

    Source: nav2_collision_monitor, Range::getData.
    """
    half = 0.5 * field_of_view
    angles = np.append(np.arange(-half, half, step), half)
    return distance * np.column_stack((np.cos(angles), np.sin(angles)))


def along_edges(corners: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """Return points along the edges of a closed polygon, its corners among them, `(N, 2)` [m].

    Args:
        corners: `(K, 2) float64` [m].
        spacing: Greatest distance between two points [m].

    Source: nav2_collision_monitor, PolygonSource::convertPolygonStampedToPoints.
    """
    edges = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        count = max(math.ceil(math.hypot(*(b - a)) / spacing), 1)
        edges.append(a + np.arange(count + 1)[:, None] / count * (b - a))
    return np.vstack(edges) if edges else np.zeros((0, 2))
