"""Readings of range sensors: planar scans, clouds, cones."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.se2 import IDENTITY, SE2, wrap


@dataclass(frozen=True)
class Scan:
    """One sweep of a planar lidar.

    Attributes:
        ranges: `(N,) float64` [m]; inf is no return, NaN is invalid (REP 117).
        angle_min: Bearing of beam 0 in the sensor frame [rad].
        angle_increment: Bearing from one beam to the next [rad]; negative sweeps clockwise.
        range_min: Shortest valid range [m].
        range_max: Longest valid range [m].
        stamp: Instant of beam 0 [s].
        time_increment: Time from one beam to the next [s].
        T_base_sensor: Pose of the sensor in the robot's base frame.
        motion: Pose of the base at the last beam in the base frame at beam 0.
    """

    ranges: Floats
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    stamp: float = 0.0
    time_increment: float = 0.0
    T_base_sensor: SE2 = field(default=IDENTITY)
    motion: SE2 = field(default=IDENTITY)

    @property
    def angles(self) -> Floats:
        """Bearings of all beams in the sensor frame, `(N,) float64` [rad]."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges), dtype=np.float64)

    @property
    def valid(self) -> Bools:
        """Mask of beams that hit something in range, `(N,) bool`."""
        with np.errstate(invalid="ignore"):
            return (self.ranges >= self.range_min) & (self.ranges < self.range_max)

    def rays(self) -> Floats:
        """Start and bearing of every beam in the base frame at beam 0, `(N, 3) float64` [m, rad].

        The base moves along a circular arc from the first beam to the last.
        """
        from arjuna_core.sweep import rays_of_sweep

        moving = self.motion != IDENTITY
        twist = self.motion.log() if moving else np.zeros(3)
        mount = self.T_base_sensor
        return rays_of_sweep(
            len(self.ranges), self.angle_min, self.angle_increment,
            mount.x, mount.y, mount.theta, twist,
        )  # fmt: skip

    @property
    def bearings(self) -> Floats:
        """Bearings of all beams as the base sees them, in -pi to pi, `(N,) float64` [rad]."""
        return np.asarray(wrap(self.angles + self.T_base_sensor.theta))

    def nearest(self, bearing: float = 0.0, width: float = 2.0 * math.pi) -> float:
        """Return the shortest valid range within a sector of the base's bearings [m]; inf if none.

        Args:
            bearing: Middle of the sector, 0 ahead, positive to the left [rad].
            width: Of the sector [rad].
        """
        off = np.abs(wrap(self.bearings - bearing))
        return float(np.min(self.ranges[self.valid & (off <= width / 2.0)], initial=math.inf))

    def mirrored(self) -> Scan:
        """Return the scan of a sensor mounted upside down, as it is seen from above."""
        return replace(self, angle_min=-self.angle_min, angle_increment=-self.angle_increment)

    def points(self) -> Floats:
        """End points of the valid beams in the base frame at beam 0, `(M, 2) float64` [m]."""
        mask = self.valid
        rays, ranges = self.rays()[mask], self.ranges[mask]
        return np.column_stack(
            (rays[:, 0] + ranges * np.cos(rays[:, 2]), rays[:, 1] + ranges * np.sin(rays[:, 2]))
        )


@dataclass(frozen=True, eq=False)
class Cloud:
    """One reading of a depth camera or of a lidar of several rows.

    Attributes:
        points: From the robot's base, heights from the ground, `(N, 3) float64` [m], all finite.
        sensor: Where they were seen from, likewise, `(3,) float64` [m].
        stamp: When [s].
    """

    points: Floats
    sensor: Floats
    stamp: float


@dataclass(frozen=True)
class RangeReading:
    """The distance to the nearest thing in a cone.

    Attributes:
        distance: To it [m]; of a sensor of fixed distance -inf for something, inf for nothing.
        field_of_view: Angle of the cone [rad].
        range_min: Shortest valid distance [m].
        range_max: Longest valid distance [m]; the shortest again for a fixed distance.
        stamp: When [s].
        T_base_sensor: Pose of the sensor in the robot's base frame, the cone about its x axis.
    """

    distance: float
    field_of_view: float
    range_min: float
    range_max: float
    stamp: float
    T_base_sensor: SE2

    @property
    def fixed(self) -> bool:
        """True where the sensor only detects an object at one fixed distance."""
        return self.range_min == self.range_max
