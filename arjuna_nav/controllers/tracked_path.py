"""A path that is being followed: what of it is still ahead of the robot."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_nav.controllers.base import checked_path
from arjuna_nav.planners import path as paths


class TrackedPath:
    """A path and how far along it the robot is.

    Args:
        search: How far along the path the robot is looked for; below 0 all along [m].
        same_goal: Distance between the ends of two paths to the same goal [m].
    """

    def __init__(self, search: float, same_goal: float = 0.1) -> None:
        self._search = math.inf if search < 0.0 else search
        self._same_goal = same_goal
        self._path = np.empty((0, 3))
        self._index = 0

    @property
    def ahead(self) -> NDArray[np.float64]:
        """The poses from the one nearest to the robot on, `(N, 3) float64`."""
        return self._path[self._index :]

    @property
    def goal(self) -> SE2:
        """The last pose."""
        return SE2.from_array(self._path[-1])

    @property
    def length(self) -> float:
        """Length of what is ahead [m]."""
        return paths.length(self.ahead)

    def replace(self, path: NDArray[np.float64]) -> bool:
        """Take another path; tell whether it leads to another goal.

        Raises:
            PathError: The path is empty or not `(N, 3)`.
        """
        checked_path(path)
        gap = np.hypot(*(path[-1, :2] - self._path[-1, :2])) if len(self._path) else math.inf
        self._path, self._index = path, 0
        return bool(gap > self._same_goal)

    def advance(self, pose: SE2) -> None:
        """Find the robot on the path; it never goes back."""
        self._index = paths.nearest(self._path, pose, self._index, self._search)

    def within(self, distance: float) -> NDArray[np.float64]:
        """Return the first part of what is ahead, two poses at least where there are two [m]."""
        ahead = self.ahead
        along = np.cumsum(np.hypot(*np.diff(ahead[:, :2], axis=0).T))
        return ahead[: max(1 + int(np.searchsorted(along, distance, side="right")), 2)]
