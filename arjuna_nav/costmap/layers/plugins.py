"""The list of layers, by Nav2's class names."""

from __future__ import annotations

from arjuna_core.plugins import PluginTypes

_HERE, _NAV2 = "arjuna_nav.costmap.layers", "nav2_costmap_2d"
_CONTACT = "arjuna_nav::ContactLayer"

LAYERS = PluginTypes(
    "layer",
    {
        f"{_NAV2}::StaticLayer": f"{_HERE}.static:StaticLayer",
        f"{_NAV2}::ObstacleLayer": f"{_HERE}.obstacle:ObstacleLayer",
        f"{_NAV2}::VoxelLayer": f"{_HERE}.voxel:VoxelLayer",
        f"{_NAV2}::RangeSensorLayer": f"{_HERE}.range_sensor:RangeSensorLayer",
        _CONTACT: f"{_HERE}.contact:ContactLayer",
        f"{_NAV2}::DenoiseLayer": f"{_HERE}.denoise:DenoiseLayer",
        f"{_NAV2}::InflationLayer": f"{_HERE}.inflation:InflationLayer",
        f"{_NAV2}::PluginContainerLayer": f"{_HERE}.container:PluginContainerLayer",
        "spatio_temporal_voxel_layer::SpatioTemporalVoxelLayer": (
            f"{_HERE}.spatio_temporal:SpatioTemporalVoxelLayer"
        ),
        f"{_NAV2}::KeepoutFilter": f"{_HERE}.filters:KeepoutFilter",
        f"{_NAV2}::SpeedFilter": f"{_HERE}.filters:SpeedFilter",
        f"{_NAV2}::BinaryFilter": f"{_HERE}.filters:BinaryFilter",
    },
    "",
    {
        "contact_layer": _CONTACT,
        "range_layer": f"{_NAV2}::RangeSensorLayer",
        **{
            f"{name}_layer": f"{_NAV2}::{name.capitalize()}Layer"
            for name in ("static", "obstacle", "voxel", "denoise", "inflation")
        },
    },
)
