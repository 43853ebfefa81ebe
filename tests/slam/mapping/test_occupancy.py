"""Claims: noise does not thicken walls, and a map worked out piece by piece is the whole one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.grid import OCCUPIED, UNKNOWN
from arjuna_core.scan import Scan
from arjuna_slam.mapping.occupancy import Occupancy

WALL = 3.02  # ahead [m]


def scans(noise: float, count: int = 60) -> list[Scan]:
    """What is seen of a wall across the way ahead."""
    rng = np.random.default_rng(1)
    angles = np.radians(np.arange(-30.0, 30.5, 0.5))
    true = WALL / np.cos(angles)
    drawn = (true + rng.normal(0.0, noise, len(true)) for _ in range(count))
    return [Scan(ranges, angles[0], math.radians(0.5), 0.02, 10.0, 0.0) for ranges in drawn]


def cells(occupancy: Occupancy) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """The map, and the places of its occupied cells."""
    grid = occupancy.grid(0.0)
    assert grid is not None
    return grid.data, grid.frame.to_points(np.argwhere(grid.data == OCCUPIED).astype(np.int64))


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_a_wall_is_as_thick_as_a_cell_however_noisy_the_ranges(noise: float) -> None:
    occupancy = Occupancy(0.05, 2, 0.1)
    for scan in scans(noise):
        occupancy.trace(scan, np.zeros(3), 10.0, 1)
    wall = cells(occupancy)[1]
    assert np.abs(wall[:, 0] - WALL).mean() < 0.025
    along = np.unique(np.round(wall[:, 1] / 0.05))
    assert len(along) >= 2.0 * WALL * math.tan(math.radians(29.0)) / 0.05


def test_what_lies_behind_a_wall_is_not_known() -> None:
    occupancy = Occupancy(0.05, 2, 0.1)
    for scan in scans(0.03):
        occupancy.trace(scan, np.zeros(3), 10.0, 1)
    grid = occupancy.grid(0.0)
    assert grid is not None
    behind = grid.frame.to_cells(np.array([[WALL + 0.08, y] for y in np.arange(-1.0, 1.0, 0.05)]))
    assert (grid.data[behind[:, 0], behind[:, 1]] == UNKNOWN).mean() > 0.8


def test_a_map_looked_at_after_each_scan_is_the_same_in_the_end() -> None:
    pieces, whole = Occupancy(0.05, 2, 0.1), Occupancy(0.05, 2, 0.1)
    for k, scan in enumerate(scans(0.03)):
        pose = np.array([0.02 * k, 0.01 * k, 0.05 * k])
        pieces.trace(scan, pose, 10.0, 1)
        pieces.grid(0.0)
        whole.trace(scan, pose, 10.0, 1)
    assert np.array_equal(cells(pieces)[0], cells(whole)[0])
