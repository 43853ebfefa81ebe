"""What a robot calls its topics and frames, as parameters of each node."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bringup.parameters.files import Parameters, merged
from bringup.stack import Group

_COSTMAPS = ("local_costmap/local_costmap", "global_costmap/global_costmap")
KEYS: dict[str, dict[str, str]] = {
    "scan_topic": {
        **dict.fromkeys(("slam_toolbox", "amcl", "collision_monitor"), "scan_topic"),
        **dict.fromkeys(_COSTMAPS, "obstacle_layer.scan.topic"),
    },
    "odom_topic": dict.fromkeys(
        ("ekf_filter_node", "controller_server", "velocity_smoother", "bt_navigator"), "odom_topic"
    ),
    "cmd_vel_topic": {
        "collision_monitor": "cmd_vel_out_topic",
        "docking_server": "cmd_vel_topic",
    },
    "base_frame": {
        "slam_toolbox": "base_frame",
        **dict.fromkeys(("amcl", "collision_monitor"), "base_frame_id"),
        **dict.fromkeys((*_COSTMAPS, "bt_navigator", "explorer"), "robot_base_frame"),
        **dict.fromkeys(("docking_server", "route_server"), "base_frame"),
    },
    "odom_frame": {
        "slam_toolbox": "odom_frame",
        **dict.fromkeys(("amcl", "collision_monitor"), "odom_frame_id"),
        "local_costmap/local_costmap": "global_frame",
        "docking_server": "fixed_frame",
    },
    "wheel_odom": {"ekf_filter_node": "odom0"},
    "imu": {"ekf_filter_node": "imu0"},
}
"""The parameter of each node that a name is set by; an option of that name sets them all."""


def of_names(
    names: Mapping[str, str | None], groups: Iterable[Group], parameters: Parameters
) -> Parameters:
    """Return the parameters that a robot's names stand for.

    Args:
        names: By a key of `KEYS`; None, or no name at all, for that of the shipped parameters.
        groups: The groups that run; nodes of others are left alone.
        parameters: Of all nodes; which layers a costmap has, and which sources they have.
    """
    found: Parameters = {}
    running = {spec.name for group in groups for spec in group.nodes}
    for what, keys in KEYS.items():
        value = names.get(what)
        for node, key in keys.items() if value is not None else ():
            if what == "scan_topic" and node in _COSTMAPS:
                key = _first_scan(parameters.get(node, {}))
            if node in running and key:
                found.setdefault(node, {})[key] = value
    return found


def _first_scan(values: Mapping[str, Any]) -> str:
    """Return the parameter that names the topic of a costmap's first scan; empty for none."""
    for layer in values.get("plugins", ()):
        for source in str(values.get(f"{layer}.observation_sources", "")).split():
            if values.get(f"{layer}.{source}.data_type", "LaserScan") == "LaserScan":
                return f"{layer}.{source}.topic"
    return ""


def keys_of_robot(node: str) -> frozenset[str]:
    """Return the parameters of a node that are the robot's own: topics, frames and outline."""
    names = {keys[node] for keys in KEYS.values() if node in keys}
    return frozenset({*names, "robot_base_frame", "footprint", "robot_radius"})


def with_base_frame(given: Parameters, below: Parameters) -> Parameters:
    """Return a file's parameters, with its one base frame at every node that names none.

    A file that names two, as Nav2's own base_link and base_footprint, stays as it is.

    Args:
        given: The file's parameters.
        below: What holds without it: a node that has the frame there already needs no word.
    """
    keys = KEYS["base_frame"]
    named = {str(given[node][key]).lstrip("/") for node, key in keys.items() if _names(given, node)}
    if len(named) != 1:
        return given
    (frame,) = named
    silent = {node: key for node, key in keys.items() if not _names(given, node)}
    own = {n: {k: frame} for n, k in silent.items() if below.get(n, {}).get(k) != frame}
    return merged(own, given)


def _names(given: Parameters, node: str) -> bool:
    """Return whether a file names a node's base frame."""
    return bool(given.get(node, {}).get(KEYS["base_frame"][node]))
