"""Parameters of SLAM: slam_toolbox's names where it has the parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.graph.back_end import BackEndConfig
from arjuna_slam.mapping.lifelong import LifelongConfig
from arjuna_slam.mapping.mapper import Mapper
from arjuna_slam.mapping.reference_map import ReferenceConfig
from arjuna_slam.matching.tracking import TrackerConfig


@dataclass(frozen=True)
class SlamConfig(BackEndConfig, ReferenceConfig, TrackerConfig, LifelongConfig):
    """Parameters of SLAM, those of matching and of loop closure among them."""

    resolution: float = param(0.05, "Edge of a map cell.", unit="m", minimum=1e-3)
    minimum_travel_distance: float = param(
        0.2,
        "Travel after which a scan is a keyframe; 0.2 maps more exactly than slam_toolbox's 0.5.",
        unit="m",
        minimum=0.0,
    )
    minimum_travel_heading: float = param(
        0.2, "Turn after which a scan is a keyframe.", unit="rad", minimum=0.0
    )
    odometry_deviation: float = param(
        0.2, "Deviation of odometry per metre and per radian.", minimum=1e-3, maximum=10.0
    )

    min_pass_through: int = param(2, "A cell of the map is known where more beams came.", minimum=0)
    occupancy_threshold: float = param(
        0.1, "A known cell is occupied where more than this share of beams ended.",
        minimum=0.0,
    )  # fmt: skip

    def mapper(self) -> Mapper:
        """Return a mapper without scans."""
        return Mapper(
            self.resolution, self.max_laser_range, self.min_pass_through, self.occupancy_threshold
        )

    def keyframe_due(self, delta: SE2) -> bool:
        """Tell whether the robot has moved enough since the last keyframe for another."""
        return (
            math.hypot(delta.x, delta.y) >= self.minimum_travel_distance
            or abs(wrap(delta.theta)) >= self.minimum_travel_heading
        )

    def odometry_covariance(self, delta: SE2) -> NDArray[np.float64]:
        """Return the covariance of an odometry step, `(3, 3) float64` [m^2, m rad, rad^2]."""
        distance, turn = math.hypot(delta.x, delta.y), abs(delta.theta)
        position = 0.01 + self.odometry_deviation * (distance + 0.2 * turn)
        heading = 0.005 + self.odometry_deviation * (turn + 0.5 * distance)
        return np.diag([position**2, position**2, heading**2])
