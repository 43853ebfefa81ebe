"""Walls that close off a space."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.model.geometry.walls import enclosure_of


def _ring(
    corners: int, radius: float, middle: tuple[float, float], gap: float = 0.0
) -> NDArray[np.float64]:
    """Return a polygon of walls, whose last one ends a gap [m] before the first begins."""
    angles = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    points = radius * np.column_stack((np.cos(angles), np.sin(angles))) + middle
    last = points[-1] - points[-2]
    points[-1] -= gap * last / np.hypot(*last)
    return np.hstack((points[:-1], points[1:]))


@pytest.mark.parametrize("seed", range(30))
def test_closed_walls_separate_inside_from_outside(seed: int) -> None:
    """Of any size, form and position, with pillars within; narrow gaps are closed."""
    rng = np.random.default_rng(seed)
    size, middle = float(rng.uniform(1.5, 40.0)), tuple(rng.uniform(-50.0, 50.0, 2).tolist())
    walls = [_ring(int(rng.integers(3, 9)), size, middle, gap=0.15 * (seed % 2))]
    turns = rng.uniform(0.0, 2.0 * math.pi, (4, 2))
    for angle, _ in turns:
        at = (middle[0] + 0.2 * size * math.cos(angle), middle[1] + 0.2 * size * math.sin(angle))
        walls.append(_ring(8, 0.1, at))
    enclosure = enclosure_of(np.vstack(walls), 0.1)
    if enclosure is None:
        assert len(walls[0]) == 3  # a triangle is less than half of what is around it
        return
    for angle, _ in turns:
        far = (middle[0] + 1.1 * size * math.cos(angle), middle[1] + 1.1 * size * math.sin(angle))
        assert enclosure.is_outside(*far)
        x, y = enclosure.nearest_inside(*far)[0].tolist()
        assert not enclosure.is_outside(x, y)
        assert math.hypot(x - middle[0], y - middle[1]) < size
    assert not enclosure.is_outside(*middle)


@pytest.mark.parametrize(
    "walls",
    [
        np.zeros((0, 4)),
        _ring(4, 3.0, (0.0, 0.0), gap=1.5),  # a door
        np.vstack([_ring(4, 0.5, (x, y)) for x in (-9.0, 9.0) for y in (-9.0, 9.0)]),  # boxes
        np.vstack([_ring(4, 4.0, (0.0, 0.0)), _ring(4, 0.3, (30.0, 0.0))]),  # a house in a street
    ],
)
def test_what_is_open_encloses_nothing(walls: NDArray[np.float64]) -> None:
    assert enclosure_of(walls, 0.2) is None
