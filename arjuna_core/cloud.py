"""A cloud of points, free of ROS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Cloud:
    """What a depth camera or a lidar of several rows sees at once.

    Attributes:
        points: From the robot's base, heights from the ground, `(N, 3) float64` [m], all finite.
        sensor: Where they were seen from, likewise, `(3,) float64` [m].
        stamp: When [s].
    """

    points: NDArray[np.float64]
    sensor: NDArray[np.float64]
    stamp: float
