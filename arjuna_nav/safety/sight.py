"""Points that sensors see round the robot: of any source, of a cone's arc, of a polygon's edges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.moving.tracker import HIDDEN


class Sight(NamedTuple):
    """Points seen from the robot's present pose.

    Attributes:
        points: `(N, 2) float64` in the base frame [m].
        motions: Their velocities over ground, `(N, 2)` in the base frame [m/s].
        speeds: At which each may turn to the robot, `(N,)` [m/s].
        sources: Number of the source of each point, `(N,) int64`.
    """

    points: Floats
    motions: Floats
    speeds: Floats
    sources: Ints

    @staticmethod
    def of(
        points: Floats, motions: Floats | None = None, speeds: Floats | None = None, source: int = 0
    ) -> Sight:
        """Return points of one source, which stand unless motions are given."""
        motions = np.zeros((len(points), 2)) if motions is None else motions
        speeds = np.hypot(*motions.T) if speeds is None else speeds
        return Sight(points, motions, speeds, np.full(len(points), source, np.int64))

    def later(self, time: float) -> Sight:
        """Return what is seen as it may be a time [s] later: what comes nearer has moved on.

        What goes away may have turned about, and stays.
        """
        nearer = (self.points * self.motions).sum(axis=1) < 0.0
        return self._replace(
            points=self.points + np.where(nearer, time, 0.0)[:, None] * self.motions
        )

    def at(self, index: Any) -> Sight:
        """Return the points of an index or a mask."""
        return Sight(*(each[index] for each in self))

    @staticmethod
    def joined(sights: Sequence[Sight]) -> Sight:
        """Return the points of all."""
        parts = zip(Sight.of(np.zeros((0, 2))), *sights, strict=True)
        return Sight(*(np.concatenate(each) for each in parts))


class Touching:
    """Remembers that who moves has come into the robot's outline: who is there moves for a while.

    A lidar inside a body sees its skin where it was before, so that nothing seems to move any more.
    """

    def __init__(self) -> None:
        self._speed, self._at = 0.0, -math.inf

    def keep(self, sight: Sight, outline: Footprint, now: float) -> Sight:
        """Return what is seen at a time [s], with the speed of who is, or just was, within."""
        recent = now - self._at <= HIDDEN
        if not recent and not sight.speeds.any():
            return sight
        within = outline.holds(sight.points)
        speed = float(sight.speeds[within].max(initial=0.0))
        if speed > 0.0:
            self._speed, self._at = speed, now
        elif not recent:
            return sight
        speeds = np.where(within, np.maximum(sight.speeds, self._speed), sight.speeds)
        return sight._replace(speeds=speeds)


def on_arc(distance: float, field_of_view: float, step: float) -> Floats:
    """Return points at a distance [m] all over a field of view [rad], `(N, 2) float64` [m].

    Source: nav2_collision_monitor, Range::getData.
    """
    half = 0.5 * field_of_view
    angles = np.append(np.arange(-half, half, step), half)
    return distance * np.column_stack((np.cos(angles), np.sin(angles)))


def along_edges(corners: Floats, spacing: float) -> Floats:
    """Return points along a closed polygon of corners `(K, 2)`, a spacing apart at most [m].

    Source: nav2_collision_monitor, PolygonSource::convertPolygonStampedToPoints.
    """
    edges = [np.zeros((0, 2))]
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        count = max(math.ceil(math.hypot(*(b - a)) / spacing), 1)
        edges.append(a + np.arange(count + 1)[:, None] / count * (b - a))
    return np.vstack(edges)
