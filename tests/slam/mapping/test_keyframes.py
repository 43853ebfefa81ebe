"""Scans are traced again where poses have moved by what would mark other cells."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_slam.mapping.keyframes import Mapper

CELL = 0.05


def mapper(count: int = 1) -> tuple[Mapper, Floats]:
    """Return a mapper that has drawn scans of a round room, and their poses."""
    drawn, poses = Mapper(CELL, 10.0), np.zeros((count, 3))
    for k in range(count):
        ranges = np.full(90, 2.0)
        drawn.add(Scan(ranges, -math.pi, math.radians(4.0), 0.1, 10.0, float(k)))
    drawn.grid(poses)
    return drawn, poses


@pytest.mark.parametrize(
    ("moved", "is_traced"),
    [
        ((0.4 * CELL, 0.0, 0.0), False),
        ((0.0, -0.6 * CELL, 0.0), True),
        ((0.4 * CELL, 0.4 * CELL, 0.0), True),
        ((0.0, 0.0, 0.004), False),
        ((0.0, 0.0, -0.006), True),
        ((0.0, 0.0, math.tau - 0.004), False),
    ],
)
def test_a_pose_that_moved_half_a_cell_is_traced_again(
    moved: tuple[float, float, float], is_traced: bool
) -> None:
    drawn, poses = mapper()
    assert not drawn.behind(poses)
    assert drawn.behind(poses + np.array(moved)) is is_traced


def test_what_moved_farthest_is_traced_first() -> None:
    drawn, poses = mapper(3)
    poses[:, 0] = (0.2, 0.5, 0.3)
    for first in (1, 2, 0):
        drawn.grid(poses, most_moved=1)
        poses[first, 0] = 0.0  # put back, it is behind again: it was drawn where it had moved
        assert drawn.behind(poses)
        poses[first, 0] = (0.2, 0.5, 0.3)[first]
    assert not drawn.behind(poses)


def test_a_new_scan_is_behind_and_each_needs_a_pose() -> None:
    drawn, poses = mapper()
    drawn.add(drawn.scans[0])
    assert drawn.behind(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="1 poses for 2 scans"):
        drawn.grid(poses)
    assert Mapper(CELL, 10.0).grid(np.zeros((0, 3))) is None


@pytest.mark.parametrize(("clear", "known_beyond"), [(True, True), (False, False)])
def test_beams_without_a_return_clear_cells_unless_they_are_left_out(
    clear: bool, known_beyond: bool
) -> None:
    """A half circle of walls at 2 m, nothing behind; 4 m is read, but beyond the longest range."""
    ranges = np.where(np.arange(90) < 45, 2.0, np.inf)
    ranges[60] = 4.0
    drawn = Mapper(CELL, 3.0, clear_without_return=clear)
    for _ in range(3):
        drawn.add(Scan(ranges, -math.pi, math.radians(4.0), 0.1, 10.0))
    grid = drawn.grid(np.zeros((3, 3)))
    assert grid is not None

    def value(beam: int, distance: float) -> int:
        angle = -math.pi + math.radians(4.0) * beam
        cell = grid.frame.to_cell(distance * math.cos(angle), distance * math.sin(angle))
        return int(grid.data[cell]) if grid.frame.contains(*cell) else -1

    assert value(20, 1.5) == value(60, 2.5) == 0
    assert (value(75, 2.5) == 0) is known_beyond
    assert value(75, 2.5) in (0, -1)
