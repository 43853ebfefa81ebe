"""Costmaps of layers and of robots as tests need them, and what is seen on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import (
    CostmapConfig,
    LayeredCostmap,
    PlacedCloud,
    PlacedRange,
    PlacedScan,
)
from arjuna_nav.costmap.footprint import Footprint

SCAN = {"clearing": True, "inf_is_valid": True, "max_obstacle_height": 2.0}
CLOUD = {
    "data_type": "PointCloud2",
    "clearing": True,
    "min_obstacle_height": -10.0,  # the floor is seen too
    "max_obstacle_height": 10.0,
}
_TYPES = {PlacedScan: "LaserScan", PlacedCloud: "PointCloud2", PlacedRange: "Range"}


def scans(source: dict[str, Any] | None = None, **layer: Any) -> dict[str, Any]:
    """Return the values of an obstacle layer whose only source is a lidar that clears too."""
    return {"observation_sources": "scan", "scan": {**SCAN, **(source or {})}, **layer}


def clouds(source: dict[str, Any] | None = None, **layer: Any) -> dict[str, Any]:
    """Return the values of a voxel layer whose only source is a camera that clears too."""
    return {"observation_sources": "cloud", "cloud": {**CLOUD, **(source or {})}, **layer}


def costmap_config(**values: Any) -> CostmapConfig:
    """Return a costmap's parameters, given those that differ; an obstacle layer has a lidar."""
    used = "obstacle_layer" in values.get("plugins", ("obstacle_layer",))
    return load(CostmapConfig, {**({"obstacle_layer": scans()} if used else {}), **values})


def see(
    layered: LayeredCostmap,
    pose: SE2,
    now: float,
    *several: Sequence[PlacedScan] | Sequence[PlacedCloud] | Sequence[PlacedRange],
) -> None:
    """Update a costmap with what was seen; each thing goes to the first source of its type."""
    for seen in (one for group in several for one in group):
        for name, layer in layered.layers.items():
            kind = _TYPES[type(seen)]
            sources = [one.source for one in layer.inputs() if one.data_type == kind]
            if sources:
                layered.receive(name, sources[0], seen)
                break
    layered.update(pose, now)


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

    @property
    def stands_out(self) -> bool:
        """Whether its circle leaves some of it out, as the own robot's file is asked."""
        circle = self.radius > 0.0 and Footprint.circle(self.radius)
        return bool(circle and circle.outreach(Footprint.polygon(self.corners)))

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
        body=str(body.corners.tolist()) if body.stands_out else "",
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
