"""The parameter files that packages of others bring along, for launch files that name them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

_SOURCES = {
    "navigation": ("nav_vel", 0.5, 10),
    "joystick": ("joy_vel", 0.5, 100),
    "keyboard": ("key_vel", 0.5, 90),
    "tablet": ("tab_vel", 0.5, 100),
}
_LOCKS = {
    "pause": ("pause_navigation", 0.0, 100),
    "loop_closure": ("stop_closing_loop", 0.0, 200),
    "joystick": ("joy_priority", 0.0, 100),
}


def _filter(world: str, **sensors: tuple[str, str]) -> dict[str, Any]:
    """Return parameters of a filter: each sensor's topic, and which of its 15 values count."""
    found: dict[str, Any] = {"frequency": 30.0, "sensor_timeout": 0.1, "world_frame": world}
    found |= {"map_frame": "map", "odom_frame": "odom", "base_link_frame": "base_link"}
    for name, (topic, mask) in sensors.items():
        found |= {name: topic, f"{name}_config": [digit == "1" for digit in mask]}
        found |= {f"{name}_queue_size": 10}
        if name.startswith("imu"):
            found[f"{name}_remove_gravitational_acceleration"] = True
    return found


_EXAMPLE = {
    "odom0": ("example/odom", "110000000001000"),
    "imu0": ("example/imu", "000111000111111"),
}
_WHEELS = {
    "odom0": ("odometry/wheel", "000000111001000"),
    "imu0": ("imu/data", "000110000111111"),
}
_GPS = {"odom1": ("odometry/gps", "110000000000000")}
_NAVSAT = {"frequency": 30.0, "delay": 3.0, "publish_filtered_gps": True}
_EXPLORED = {
    "robot_base_frame": "base_link",
    "costmap_topic": "map",
    "visualize": True,
    "planner_frequency": 0.25,
    "progress_timeout": 30.0,
    "potential_scale": 3.0,
    "gain_scale": 1.0,
    "transform_tolerance": 0.3,
    "min_frontier_size": 0.75,
}
_FILES: dict[str, Mapping[str, Mapping[str, Any]]] = {
    "explore_lite/config/params": {"explore_node": _EXPLORED},
    "robot_localization/params/ekf": {"ekf_filter_node": _filter("odom", **_EXAMPLE)},
    "robot_localization/params/ukf": {"ukf_filter_node": _filter("odom", **_EXAMPLE)},
    "robot_localization/params/navsat_transform": {"navsat_transform_node": _NAVSAT},
    "robot_localization/params/dual_ekf_navsat_example": {
        "ekf_filter_node_odom": _filter("odom", **_WHEELS),
        "ekf_filter_node_map": _filter("map", **_WHEELS, **_GPS),
        "navsat_transform": _NAVSAT,
    },
    **{
        f"twist_mux/config/twist_mux_{kind}": {
            "twist_mux": {
                kind: {
                    name: dict(zip(("topic", "timeout", "priority"), each, strict=True))
                    for name, each in known.items()
                }
            }
        }
        for kind, known in (("topics", _SOURCES), ("locks", _LOCKS))
    },
}
STOCK_FILES = {
    f"{name}.yaml": yaml.safe_dump({node: {"ros__parameters": v} for node, v in nodes.items()})
    for name, nodes in _FILES.items()
}
"""Their texts, by the path below `share`."""
