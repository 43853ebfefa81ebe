"""Trajectories of joints: splines through points in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError


class TrajectoryError(ArjunaError):
    """A trajectory that cannot be followed."""


@dataclass(frozen=True)
class Trajectory:
    """Points of some joints in time.

    Between two points runs a straight line; a cubic where both have velocities, a quintic where
    both have accelerations too. Source: joint_trajectory_controller, Jazzy.

    Attributes:
        times: Of the points, rising [s], `(P,)`.
        positions: `(P, J)` [rad or m].
        velocities: `(P, J)`, not a number where a point has none.
        accelerations: `(P, J)`, not a number where a point has none.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats

    def __post_init__(self) -> None:
        """Refuse points that are out of order, not finite, or of which the last moves."""
        if not len(self.times):
            raise TrajectoryError("has no points")
        if not np.isfinite(self.positions).all() or not np.isfinite(self.times).all():
            raise TrajectoryError("each point needs a finite position of each of its joints")
        if self.times[0] < 0.0 or (np.diff(self.times) <= 0.0).any():
            raise TrajectoryError("time_from_start must rise from point to point")
        if np.nan_to_num(self.velocities[-1]).any():
            raise TrajectoryError("the last point's velocities must be 0: there it stops")

    @property
    def duration(self) -> float:
        """The time of the last point [s]."""
        return float(self.times[-1])

    def starting_at(self, position: Floats, velocity: Floats) -> Trajectory:
        """Return it with a first point at time 0, where the joints are."""
        if self.times[0] <= 0.0:
            return self
        return Trajectory(
            np.concatenate([[0.0], self.times]),
            np.vstack([position, self.positions]),
            np.vstack([velocity, self.velocities]),
            np.vstack([np.zeros_like(position), self.accelerations]),
        )

    def at(self, time: float) -> Floats:
        """Return the positions at a time [s], `(J,)`; beyond the points those of the nearest."""
        end = int(np.searchsorted(self.times, time, side="right"))
        if end == 0 or end == len(self.times):
            nearest: Floats = self.positions[min(end, len(self.times) - 1)]
            return nearest
        span = float(self.times[end] - self.times[end - 1])
        u = float(time - self.times[end - 1]) / span
        p, v = self.positions[end - 1 : end + 1], self.velocities[end - 1 : end + 1] * span
        a = self.accelerations[end - 1 : end + 1] * span**2
        line = p[0] + u * (p[1] - p[0])
        cubic = (
            (1 + 2 * u) * (1 - u) ** 2 * p[0]
            + u * (1 - u) ** 2 * v[0]
            + u**2 * (3 - 2 * u) * p[1]
            - u**2 * (1 - u) * v[1]
        )
        step = p[1] - p[0] - v[0] - a[0] / 2
        slope, bend = v[1] - v[0] - a[0], a[1] - a[0]
        quintic = p[0] + u * v[0] + u**2 * a[0] / 2
        quintic += u**3 * (
            10 * step
            - 4 * slope
            + bend / 2
            + u * (-15 * step + 7 * slope - bend)
            + u**2 * (6 * step - 3 * slope + bend / 2)
        )
        smooth = np.where(np.isfinite(quintic), quintic, cubic)
        found: Floats = np.where(np.isfinite(smooth), smooth, line)
        return found
