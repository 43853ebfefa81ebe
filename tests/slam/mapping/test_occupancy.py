"""Claims: noise does not thicken walls, and a map worked out piece by piece is the whole one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.arrays import Floats
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN
from arjuna_core.raycast import line_cells
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.occupancy import Occupancy

WALL = 3.02  # ahead [m]


def scans(noise: float, count: int = 60) -> list[Scan]:
    """Return scans of a wall ahead."""
    rng = np.random.default_rng(1)
    angles = np.radians(np.arange(-30.0, 30.5, 0.5))
    true = WALL / np.cos(angles)
    drawn = (true + rng.normal(0.0, noise, len(true)) for _ in range(count))
    return [Scan(ranges, angles[0], math.radians(0.5), 0.02, 10.0, 0.0) for ranges in drawn]


def cells(occupancy: Occupancy) -> tuple[NDArray[np.int8], Floats]:
    """The map, and the centres of its occupied cells."""
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


def test_robot_is_on_its_map_though_its_lidar_sees_ahead_alone() -> None:
    occupancy = Occupancy(0.05, 2, 0.1)
    for x in (1.0, 0.0):  # it has driven back
        for scan in scans(0.0, count=3):
            ahead = replace(scan, T_base_sensor=SE2(0.3))
            occupancy.trace(ahead, np.array([x, 0.0, 0.0]), 10.0, 1)
        grid = occupancy.grid(0.0)
        assert grid is not None
        assert grid.frame.contains(*grid.frame.to_cell(x, 0.0))


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


def beam(range_: float, pose: SE2, range_min: float = 0.02) -> tuple[Scan, Floats]:
    """Return a scan of one beam ahead, and where it is taken."""
    return Scan(np.array([range_]), 0.0, 0.1, range_min, 10.0, 0.0), pose.array()


def crossed(range_: float, pose: SE2) -> set[tuple[int, int]]:
    """Return the cells of 0.05 m, of which one has its middle at the origin, along a beam."""
    ends = np.array([[pose.x, pose.y], pose.apply(np.array([[range_, 0.0]]))[0]])
    (x0, y0), (x1, y1) = np.floor(ends / 0.05 + 0.5).astype(int).tolist()
    return {(int(r), int(c)) for r, c in line_cells(y0, x0, y1, x1)}


def values_of(occupancy: Occupancy) -> dict[tuple[int, int], int]:
    """Return the value of each known cell, by its row and column from the origin's."""
    grid = occupancy.grid(7.0)
    assert grid is not None
    assert grid.stamp == 7.0
    first = np.round(np.array([grid.frame.origin.y, grid.frame.origin.x]) / 0.05 + 0.5)
    known = np.argwhere(grid.data != UNKNOWN)
    for edge in (grid.data[0], grid.data[-1], grid.data[:, 0], grid.data[:, -1]):
        assert (edge != UNKNOWN).any()  # no larger than what was seen
    return {(int(r + first[0]), int(c + first[1])): int(grid.data[r, c]) for r, c in known.tolist()}


BEAMS = [
    (float(r), SE2(float(x), float(y), float(t)))
    for r, x, y, t in np.random.default_rng(4).uniform((1, -4, -4, -3), (9, 4, 4, 3), (12, 4))
]


def test_a_map_is_of_the_cells_that_beams_have_crossed_often_enough() -> None:
    occupancy = Occupancy(0.05, 2, 0.1)
    assert occupancy.grid(0.0) is None
    cells: set[tuple[int, int]] = set()
    for range_, pose in BEAMS:  # each grows the map another way
        for _ in range(2):
            occupancy.trace(*beam(range_, pose), 20.0, 1)
        once = known_cells(occupancy)
        assert not crossed(range_, pose) <= once
        occupancy.trace(*beam(range_, pose), 20.0, 1)
        cells |= crossed(range_, pose)
        assert set(values_of(occupancy)) == cells
    ends = {cell for cell, value in values_of(occupancy).items() if value == OCCUPIED}
    last = [SE2(x, y).apply(np.zeros((1, 2)))[0] for x, y in (end(*each) for each in BEAMS)]
    assert ends <= {(math.floor(y / 0.05 + 0.5), math.floor(x / 0.05 + 0.5)) for x, y in last}
    assert len(ends) >= len(BEAMS) - 1  # one may be crossed by others


def end(range_: float, pose: SE2) -> tuple[float, float]:
    x, y = pose.apply(np.array([[range_, 0.0]]))[0].tolist()
    return x, y


def known_cells(occupancy: Occupancy) -> set[tuple[int, int]]:
    """Return which cells are known, of a map whose rim may not be."""
    grid = occupancy.grid(0.0)
    assert grid is not None
    first = np.round(np.array([grid.frame.origin.y, grid.frame.origin.x]) / 0.05 + 0.5)
    return {(int(r + first[0]), int(c + first[1])) for r, c in np.argwhere(grid.data != UNKNOWN)}


@pytest.mark.parametrize("gone", range(0, 12, 3))
def test_what_is_taken_away_leaves_the_map_as_it_was_without(gone: int) -> None:
    whole, without = Occupancy(0.05, 2, 0.1), Occupancy(0.05, 2, 0.1)
    for k, (range_, pose) in enumerate(BEAMS):
        for each in (whole, without) if k != gone else (whole,):
            for _ in range(3):
                each.trace(*beam(range_, pose), 20.0, 1)
    assert values_of(whole) != values_of(without)
    for _ in range(3):
        whole.trace(*beam(*BEAMS[gone]), 20.0, -1)
    assert values_of(whole) == values_of(without)


def test_beams_out_of_range_hit_nothing_or_say_nothing() -> None:
    occupancy, pose = Occupancy(0.05, 2, 0.1), SE2(1.0, 0.5, 0.3)
    for _ in range(3):
        occupancy.trace(*beam(0.01, pose), 20.0, 1)  # too near
        occupancy.trace(*beam(math.nan, pose), 20.0, 1)
    assert occupancy.grid(0.0) is None
    for _ in range(3):
        occupancy.trace(*beam(9.0, pose), 4.0, 1)
    assert set(values_of(occupancy)) == crossed(4.0, pose)
    assert OCCUPIED not in values_of(occupancy).values()


def before_a_wall(ends: dict[int, int], heading: float) -> list[int]:
    """Return the values of cells 9 to 12 ahead, of so many beams in each of seven lines.

    Args:
        ends: How many of them end in which cell.
        heading: Along which they go [rad].
    """
    occupancy = Occupancy(0.05, 2, 0.1)
    ranges = np.repeat(0.05 * np.array(list(ends)), list(ends.values()))
    scan = Scan(ranges, 0.0, 1e-12, 0.02, 10.0, 0.0)
    turn = SE2(0.0, 0.0, heading)
    for line in range(-3, 4):
        occupancy.trace(scan, (turn @ SE2(0.0, 0.05 * line, 0.0)).array(), 10.0, 1)
    grid = occupancy.grid(0.0)
    assert grid is not None
    ahead = turn.apply(np.column_stack((0.05 * np.arange(9.0, 13.0), np.zeros(4))))
    inside = [grid.frame.to_cell(x, y) for x, y in ahead.tolist()]
    return [int(grid.data[cell]) if grid.frame.contains(*cell) else UNKNOWN for cell in inside]


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2])
@pytest.mark.parametrize(
    ("ends", "cells"),
    [
        ({11: 300}, [FREE, FREE, OCCUPIED, UNKNOWN]),
        # One beam is not enough; of two that end in a cell each counts twice, as Karto has it.
        ({11: 1}, [UNKNOWN] * 4),
        ({11: 2}, [UNKNOWN, UNKNOWN, OCCUPIED, UNKNOWN]),
        ({11: 3}, [FREE, FREE, OCCUPIED, UNKNOWN]),
        ({10: 100, 11: 200}, [FREE, FREE, OCCUPIED, UNKNOWN]),
        # Clearly fewer end before it: 0.65 of those beside, less half a deviation of that number.
        ({10: 114, 11: 186}, [FREE, FREE, OCCUPIED, UNKNOWN]),
        ({10: 115, 11: 185}, [FREE, OCCUPIED, OCCUPIED, UNKNOWN]),
        # Behind it none go on, so what ended there says nothing.
        ({11: 186, 12: 114}, [FREE, FREE, OCCUPIED, UNKNOWN]),
        ({11: 185, 12: 115}, [FREE, FREE, OCCUPIED, OCCUPIED]),
        # A tenth and no more of those that come.
        ({10: 30, 12: 270}, [FREE, FREE, FREE, OCCUPIED]),
    ],
)
def test_the_fringe_of_a_wall_is_not_the_wall(
    ends: dict[int, int], cells: list[int], heading: float
) -> None:
    assert before_a_wall(ends, heading) == cells
