"""Parameters of the slam_toolbox node."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import param
from arjuna_slam.config import SlamConfig


@dataclass(frozen=True)
class SlamNodeConfig(SlamConfig):
    """Parameters of the node; slam_toolbox's names."""

    odom_frame: str = param("odom", "Frame of the odometry.", read_only=True)
    map_frame: str = param("map", "Frame of the map.", read_only=True)
    base_frame: str = param("base_footprint", "Frame of the robot's base.", read_only=True)
    scan_topic: str = param("/scan", "Topic of the scans.", read_only=True)
    map_name: str = param("/map", "Topic of the map.", read_only=True)
    map_update_interval: float = param(
        5.0, "Time between two maps.", unit="s", minimum=0.02, read_only=True
    )
    transform_publish_period: float = param(
        0.05, "Time between two transforms; 0 for none.", unit="s", minimum=0.0, read_only=True
    )
    transform_timeout: float = param(
        0.2, "How far past its scan a transform is dated.", unit="s", minimum=0.0
    )
    position_covariance_scale: float = param(
        1.0, "Factor on the covariance of the position.", minimum=1e-6
    )
    yaw_covariance_scale: float = param(1.0, "Factor on the covariance of the yaw.", minimum=1e-6)
    maps_folder: str = param(".", "Folder that save_map may write to.")
