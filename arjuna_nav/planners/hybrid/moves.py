"""The pieces that a search over poses puts together: from each heading where they lead."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats, Ints
from arjuna_core.se2 import SE2
from arjuna_nav.planners.hybrid.curves import along

STEP = 0.5
"""Between two poses that are looked at for collisions [cells]."""


class Moves(NamedTuple):
    """Pieces, sorted by the heading from which they start; lengths in cells.

    Attributes:
        angles: `(H,) float64` the headings [rad].
        start: Number of the heading where the search begins.
        first: `(H + 1,) int64` the first piece of each heading, and the number of pieces.
        ends: `(N,) int64` the heading after each piece.
        sides: `(N,) int64` 1 where it bends left, -1 right, 0 straight on.
        costs: `(N,) float64` in free space, in cells straight ahead.
        changes: `(N,) float64` cost added where it bends to the other side than the last.
        begins: `(N + 1,) int64` the first of each piece's poses, and the number of poses.
        poses: `(M, 3) float64` from the piece's start [cells, cells, rad], the start left out.
    """

    angles: Floats
    start: int
    first: Ints
    ends: Ints
    sides: Ints
    costs: Floats
    changes: Floats
    begins: Ints
    poses: Floats

    def turned(self, angle: float) -> Moves:
        """Return them from headings turned by an angle [rad]."""
        points = SE2(theta=angle).apply(self.poses[:, :2])
        poses = np.column_stack((points, self.poses[:, 2]))
        return self._replace(angles=self.angles + angle, poses=poses)


@njit(cache=True)
def _turns(bins: int, tight: int, every: bool) -> list[int]:
    """Return by how many bins pieces turn: none, the tightest bends, and gentle or all others.

    Where the tightest turn by much, as on coarse grids, the robot could else but drive along the
    grid.
    """
    # A bend by the 24th of a turn, 15 degrees, is gentle.
    gentle = max(bins // 24, 1)
    turns = [0, tight, -tight]
    if every:
        for turn in range(1, tight):
            turns += [turn, -turn]
        return turns
    if tight > 2 * gentle:
        turns += [gentle, -gentle]
    return turns


@njit(cache=True)
def arcs(
    first: float,
    bins: int,
    radius: float,
    reverse: bool,
    factors: tuple[float, float, float],
    every: bool,
) -> Moves:
    """Return bends by whole bins that leave their cell, and straights as long.

    Args:
        first: The heading that is to be the first [rad].
        bins: Number of headings.
        radius: Of the tightest bends [cells].
        reverse: Whether it may be driven back.
        factors: On the cost of what is driven back, of bends, and added to that where the side
            changes.
        every: Whether there is a bend by each number of headings up to the tightest.

    Source: Dolgov et al.; nav2_smac_planner, HybridMotionTable.
    """
    one = 2.0 * math.pi / bins
    tight = math.ceil(2.0 * math.asin(min(math.sqrt(2.0) / (2.0 * radius), 1.0)) / one)
    turns = _turns(bins, tight, every)
    piece = radius * tight * one
    steps = int(piece / STEP) + 1
    directions = [1.0, -1.0] if reverse else [1.0]
    angles = np.empty(bins)
    angles[:] = first + one * np.arange(bins)
    count = len(turns) * len(directions)
    total = bins * count
    ends, sides = np.empty(total, np.int64), np.empty(total, np.int64)
    costs, changes = np.empty(total), np.empty(total)
    poses = np.empty((total * steps, 3))
    for i in range(total):
        heading, turn = i // count, turns[i % len(turns)]
        direction = directions[i % count // len(turns)]
        ends[i], sides[i] = (heading + turn) % bins, np.sign(turn) * direction
        changes[i] = piece * (factors[0] if direction < 0.0 else 1.0)
        costs[i] = changes[i] * (1.0 if turn == 0 else factors[1])
        changes[i] *= factors[2]
        at = np.array([0.0, 0.0, angles[heading]])
        bent = piece / (abs(turn) * one) if turn else radius
        curve = np.array([[float(sides[i])], [direction * piece / bent]])
        trace = along(at, curve, bent, piece / steps + 1e-9)
        poses[i * steps : (i + 1) * steps] = trace - at
    begins = steps * np.arange(total + 1)
    return Moves(angles, 0, count * np.arange(bins + 1), ends, sides, costs, changes, begins, poses)
