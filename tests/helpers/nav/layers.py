"""Costmaps of layers as tests need them, and what is seen on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from arjuna_core.config import load
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import (
    CostmapConfig,
    LayeredCostmap,
    PlacedCloud,
    PlacedRange,
    PlacedScan,
)

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
