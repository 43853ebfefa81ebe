"""A planar laser scan, free of ROS."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2


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
    """

    ranges: NDArray[np.float64]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    stamp: float = 0.0
    time_increment: float = 0.0
    T_base_sensor: SE2 = field(default=IDENTITY)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Bearings of all beams in the sensor frame, `(N,) float64` [rad]."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges), dtype=np.float64)

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Mask of beams that hit something in range, `(N,) bool`."""
        with np.errstate(invalid="ignore"):
            return (self.ranges >= self.range_min) & (self.ranges < self.range_max)

    def points(self) -> NDArray[np.float64]:
        """End points of the valid beams in the base frame, `(M, 2) float64` [m]."""
        mask = self.valid
        ranges, angles = self.ranges[mask], self.angles[mask]
        local = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
        return self.T_base_sensor.apply(local)
