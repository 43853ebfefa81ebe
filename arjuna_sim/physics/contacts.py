"""Contacts of robots with the world: what is touched rather than stood on, and how often."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Ints
from arjuna_sim.physics.scene import Scene

LEVEL, SUNK = 0.7, 0.02
"""A robot stands on what has a normal of so large a z (45 degrees), sunk in by at most [m]."""
GRAZED = 1e-9
"""A contact sunk in by less only grazes: it has no direction [m]."""


def touched(scene: Scene, data: Any, robot: str) -> tuple[str, ...]:
    """Return the names of what a robot touches, sorted; never what it stands on."""
    pairs = data.contact.geom
    if not any_of(pairs, scene.is_obstacle):
        return ()
    rows, side = np.nonzero(scene.robots[robot].is_solid[pairs])
    others = pairs[rows, 1 - side]
    is_hit = scene.is_obstacle[others]
    if not is_hit.any():
        return ()
    distance = data.contact.dist[rows]
    stands = (np.abs(data.contact.frame[rows, 2]) > LEVEL) & (distance > -SUNK)
    stands |= distance > -GRAZED
    found = np.flatnonzero(is_hit & ~stands)
    rolls = _rolls_over(scene, data, robot, pairs[rows, side][found], others[found])
    found = found[~rolls | (distance[found] < -SUNK)]
    return tuple(sorted({scene.names[geom] for geom in others[found]}))


def _rolls_over(scene: Scene, data: Any, robot: str, own: Ints, others: Ints) -> Bools:
    """Return which geoms are wheels on something that they meet from above, `(N,) bool`.

    Whatever the contact's direction: at an edge a wheel sinks into the face before it as well.

    Args:
        own: Geoms of the robot, `(N,) int`.
        others: What each touches, `(N,) int`.
    """
    model = scene.model
    bodies, tyres = model.geom_bodyid, list(scene.robots[robot].support.tyres)
    is_wheel: Bools = np.isin(bodies[own], bodies[tyres])
    radius = model.geom_size[own, 0]
    up, box = data.geom_xmat[others].reshape(-1, 3, 3)[:, 2], model.geom_aabb[others]
    reach = (up * box[:, :3] + np.abs(up) * box[:, 3:]).sum(axis=1)
    rise = data.geom_xpos[others, 2] + reach - (data.geom_xpos[own, 2] - radius)
    is_low: Bools = rise < (1.0 - LEVEL) * radius
    return is_wheel & is_low


@njit(cache=True)
def any_of(pairs: NDArray[np.int32], is_meant: Bools) -> bool:
    """Return whether any geom of pairs `(N, 2)` is meant, `(geoms,) bool`.

    `bench sim`: 1.5 us of a tick in NumPy.
    """
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
