"""Contacts of the robot, and their counts by name."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_sim.physics.scene import Scene


def touched(scene: Scene, data: Any, robot: str) -> tuple[str, ...]:
    """Return the names of what a robot touches, sorted; never what it stands on."""
    pairs = data.contact.geom
    if not _any_of(pairs, scene.is_obstacle):
        return ()
    rows, side = np.nonzero(scene.robots[robot].is_solid[pairs])
    others = pairs[rows, 1 - side]
    is_hit = scene.is_obstacle[others]
    if not is_hit.any():
        return ()
    # A robot stands on what is less steep than 45 degrees and within 0.02 m of its surface.
    stands = (np.abs(data.contact.frame[rows, 2]) > 0.7) & (data.contact.dist[rows] > -0.02)
    return tuple(sorted({scene.names[geom] for geom in others[is_hit & ~stands]}))


@njit(cache=True)
def _any_of(pairs: NDArray[np.int32], is_meant: NDArray[np.bool_]) -> bool:
    """Return whether any geom of pairs is meant (`bench sim`: 1.5 us of a tick in NumPy)."""
    found = False
    for i in range(len(pairs)):
        found |= is_meant[pairs[i, 0]] or is_meant[pairs[i, 1]]
    return found


class ContactLog:
    """Counts contacts by name: one begins when the robot touches what it did not touch before."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all."""
        self.touched: tuple[str, ...] = ()
        self.counts: dict[str, int] = {}

    def update(self, touched: tuple[str, ...]) -> bool:
        """Take the names of what the robot touches now; return whether they have changed."""
        if touched == self.touched:
            return False
        for name in touched:
            if name not in self.touched:
                self.counts[name] = self.counts.get(name, 0) + 1
        self.touched = touched
        return True

    @property
    def total(self) -> int:
        """The number of contacts since the start or the last reset."""
        return sum(self.counts.values())
