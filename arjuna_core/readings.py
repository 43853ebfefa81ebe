"""Readings of depth cameras, sonars and infrared sensors, free of ROS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2


@dataclass(frozen=True, eq=False)
class Cloud:
    """One reading of a depth camera or of a lidar of several rows.

    Attributes:
        points: From the robot's base, heights from the ground, `(N, 3) float64` [m], all finite.
        sensor: Where they were seen from, likewise, `(3,) float64` [m].
        stamp: When [s].
    """

    points: NDArray[np.float64]
    sensor: NDArray[np.float64]
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
