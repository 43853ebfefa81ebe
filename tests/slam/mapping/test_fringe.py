"""What a cell beside a wall is: where more beams end in the next line, it is that one's fringe."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.occupancy import Occupancy


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
        ({11: 2}, [UNKNOWN] * 4),
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
