"""Robots that are played, and the costmaps of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_nav.costmap import CostmapConfig
from arjuna_nav.costmap.footprint import Footprint
from tests.helpers.nav.layers import costmap_config, scans

_INFLATION = {"inflation_radius": 0.6, "cost_scaling_factor": 5.0}


@dataclass(frozen=True)
class Body:
    """A robot.

    Attributes:
        corners: Its true outline `(N, 2)` [m].
        radius: Of a robot that is navigated as a circle; 0 for its outline.
        padding: Of what it is navigated as [m].
    """

    corners: NDArray[np.float64]
    radius: float = 0.0
    padding: float = 0.01

    @staticmethod
    def box(length: float, width: float) -> Body:
        """Return a rectangle about its middle."""
        x, y = length / 2.0, width / 2.0
        return Body(np.array([[x, y], [x, -y], [-x, -y], [-x, y]]))

    @staticmethod
    def disc(radius: float) -> Body:
        """Return a round robot."""
        return Body(Footprint.circle(radius).points, radius)

    @property
    def parameters(self) -> dict[str, Any]:
        """A costmap's parameters of it."""
        outline = "[]" if self.radius else str(self.corners.tolist())
        radius = {"robot_radius": self.radius} if self.radius else {}
        return {"footprint": outline, "footprint_padding": self.padding, **radius}


def window(edge: int, reach: float, body: Body) -> CostmapConfig:
    """Return a window of some metres that goes with the robot and sees as far as `reach` [m]."""
    return costmap_config(
        global_frame="odom",
        rolling_window=True,
        width=edge,
        height=edge,
        resolution=0.05,
        plugins=("obstacle_layer", "inflation_layer"),
        obstacle_layer=_obstacles(reach),
        inflation_layer=_INFLATION,
        **body.parameters,
    )


def whole_map(body: Body) -> CostmapConfig:
    """Return the costmap of a map."""
    return costmap_config(
        resolution=0.05,
        track_unknown_space=True,
        obstacle_layer=_obstacles(3.0),
        inflation_layer=_INFLATION,
        **body.parameters,
    )


def _obstacles(reach: float) -> dict[str, Any]:
    return scans({"obstacle_max_range": reach, "raytrace_max_range": reach + 1.0})
