"""Robots that people and walls push out of themselves, played without physics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_nav.costmap.footprint import Footprint

_ROUNDS = 8  # of yielding to one after the other
_HAIR = 1e-4  # that is left to what has pressed [m]
_TYRES = 0.75  # how far out they stand, of the outline's corners
_OVER = 0.05  # so deep in it, who walks steps over a robot that cannot yield [m]


class _Press(NamedTuple):
    """A point at which something presses the robot, its direction and depth, in the base [m]."""

    point: NDArray[np.float64]
    direction: NDArray[np.float64]
    depth: float


class Pushes:
    """Moves and turns a robot out of people, and out of walls before all.

    Args:
        corners: The robot's outline about its base `(N, 2)` [m].
        walls: Segments `(N, 4)` x0, y0, x1, y1 of the world [m].

    Attributes:
        pinned: Whether a wall pressed the robot at last.

    Source: quasi-static pushing against friction on the ground, whose limit is an ellipsoid: Lynch
        and Mason, Stable pushing, International Journal of Robotics Research 1996.
    """

    def __init__(self, corners: NDArray[np.float64], walls: NDArray[np.float64]) -> None:
        self._outline, self._walls = Footprint.polygon(corners), walls
        self._arm = _TYRES * self._outline.circumscribed_radius  # of tyres' moment to their force
        self._over: set[int] = set()
        self.pinned = False

    def yield_to(self, pose: SE2, people: NDArray[np.float64]) -> SE2:
        """Return where people and walls push the robot to; the same pose if nothing does.

        Args:
            people: Their middles and radii `(N, 3)` [m].
        """
        self.pinned = False
        for _ in range(_ROUNDS):
            before = pose
            for k, person in enumerate(people):
                if k not in self._over:
                    pose = self._after(pose, self._by_person(pose, person))
            pose = self._off_walls(pose)
            if pose is before:
                break
        for k, person in enumerate(people):
            press = self._by_person(pose, person)
            if press is None:
                self._over.discard(k)
            elif press.depth > _OVER:
                self._over.add(k)
        return pose

    def _off_walls(self, pose: SE2) -> SE2:
        for _ in range(_ROUNDS):
            press = self._by_wall(pose)
            if press is None:
                break
            self.pinned = True
            pose = self._after(pose, press)
        return pose

    def _after(self, pose: SE2, press: _Press | None) -> SE2:
        if press is None:
            return pose
        (x, y), direction, depth = press
        lever = float(x * direction[1] - y * direction[0])
        turn = lever / self._arm**2
        step = (depth + _HAIR) / (1.0 + lever * turn)
        return pose @ SE2(step * float(direction[0]), step * float(direction[1]), step * turn)

    def _by_person(self, pose: SE2, person: NDArray[np.float64]) -> _Press | None:
        return self._by_discs(pose, person[None, :2], float(person[2]))

    def _by_wall(self, pose: SE2) -> _Press | None:
        """Return how the wall that is deepest in the robot presses it."""
        presses = self._by_discs(pose, self._walls[:, :2], 0.0), self._at_corner(pose)
        return max((p for p in presses if p is not None), key=lambda p: p.depth, default=None)

    def _by_discs(self, pose: SE2, middles: NDArray[np.float64], radius: float) -> _Press | None:
        """Return how the deepest of some discs presses the outline."""
        if not len(middles):
            return None
        seen = pose.inverse().apply(middles)
        gaps, away = self._outline.gaps(seen)
        k, gap = int(gaps.argmin()), float(gaps.min())
        if gap >= radius:
            return None
        return _Press(seen[k] - gap * away[k], -away[k], radius - gap)

    def _at_corner(self, pose: SE2) -> _Press | None:
        """Return how the wall presses that a corner of the outline is deepest behind."""
        corners, T_base_world = self._outline.points, pose.inverse()
        a, b = T_base_world.apply(self._walls[:, :2]), T_base_world.apply(self._walls[:, 2:])
        along = (b - a) / np.hypot(*(b - a).T)[:, None]
        normals = np.column_stack((-along[:, 1], along[:, 0]))
        base = -(a * normals).sum(axis=1)
        normals, base = normals * np.sign(base)[:, None], np.abs(base)
        depths = -((corners[:, None] - a) * normals).sum(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = corners[:, None] * (base / (base + depths))[..., None]
        share = ((crossing - a) * along).sum(axis=2)
        behind = (depths > 0.0) & (share >= 0.0) & (share <= np.hypot(*(b - a).T))
        if not behind.any():
            return None
        corner, wall = np.unravel_index(int(np.where(behind, depths, 0.0).argmax()), depths.shape)
        return _Press(corners[corner], normals[wall], float(depths[corner, wall]))
