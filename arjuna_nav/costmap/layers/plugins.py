"""The list of layers, by Nav2's class names."""

from __future__ import annotations

from arjuna_core.plugins import PluginTypes

_HERE = "arjuna_nav.costmap.layers"
_STATIC = "nav2_costmap_2d::StaticLayer"
_OBSTACLE = "nav2_costmap_2d::ObstacleLayer"
_VOXEL = "nav2_costmap_2d::VoxelLayer"
_RANGE = "nav2_costmap_2d::RangeSensorLayer"
_DENOISE = "nav2_costmap_2d::DenoiseLayer"
_CONTACT = "arjuna_nav::ContactLayer"
_INFLATION = "nav2_costmap_2d::InflationLayer"

LAYERS = PluginTypes(
    "layer",
    {
        _STATIC: f"{_HERE}.static:StaticLayer",
        _OBSTACLE: f"{_HERE}.obstacle:ObstacleLayer",
        _VOXEL: f"{_HERE}.voxel:VoxelLayer",
        _RANGE: f"{_HERE}.range_sensor:RangeSensorLayer",
        _CONTACT: f"{_HERE}.contact:ContactLayer",
        _DENOISE: f"{_HERE}.denoise:DenoiseLayer",
        _INFLATION: f"{_HERE}.inflation:InflationLayer",
        "nav2_costmap_2d::PluginContainerLayer": f"{_HERE}.container:PluginContainerLayer",
        "spatio_temporal_voxel_layer::SpatioTemporalVoxelLayer": (
            f"{_HERE}.spatio_temporal:SpatioTemporalVoxelLayer"
        ),
        "nav2_costmap_2d::KeepoutFilter": f"{_HERE}.filters:KeepoutFilter",
        "nav2_costmap_2d::SpeedFilter": f"{_HERE}.filters:SpeedFilter",
        "nav2_costmap_2d::BinaryFilter": f"{_HERE}.filters:BinaryFilter",
    },
    "",
    {
        "static_layer": _STATIC,
        "obstacle_layer": _OBSTACLE,
        "voxel_layer": _VOXEL,
        "range_layer": _RANGE,
        "contact_layer": _CONTACT,
        "denoise_layer": _DENOISE,
        "inflation_layer": _INFLATION,
    },
)
