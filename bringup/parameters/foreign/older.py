"""Names and forms of Nav2 before Jazzy, as today's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arjuna_core.plugins import canonical

_NODES = {"recoveries_server": "behavior_server"}  # Nav2 before Humble
_KEYS = {
    "behavior_server": {
        "cmd_vel_teleop": "cmd_vel_teleop_topic",
        "recovery_plugins": "behavior_plugins",
    },
    "controller_server": {
        "progress_checker_plugin": "progress_checker_plugins",
        "goal_checker_plugin": "goal_checker_plugins",
    },
}
_VALUES = {
    ("amcl", "robot_model_type"): {
        "differential": "nav2_amcl::DifferentialMotionModel",
        "omnidirectional": "nav2_amcl::OmniMotionModel",
    },
}


def section_as_today(name: str) -> str:
    """Return a section's name with the node's name of today."""
    before, slash, node = name.rpartition("/")
    return f"{before}{slash}{_NODES.get(node, node)}"


def as_today(node: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a node's values with keys, classes and forms of today."""
    values: dict[str, Any] = {}
    for key, value in given.items():
        today = _KEYS.get(node, {}).get(key, key)
        if key.endswith("plugin") and isinstance(value, str):
            value = canonical(value).replace("nav2_recoveries::", "nav2_behaviors::")
            value = value if today == key else [value]
        if isinstance(value, str):
            value = _VALUES.get((node, key), {}).get(value, value)
        values[today] = value
    return _zones_as_today(values) if node == "collision_monitor" else values


def _zones_as_today(values: dict[str, Any]) -> dict[str, Any]:
    """Return a collision monitor's values with zones as Nav2 has them since Iron."""
    flat = {k: v for k, v in values.items() if k.endswith(".points") and isinstance(v, list)}
    pairs = {key: zip(value[::2], value[1::2], strict=False) for key, value in flat.items()}
    return values | {key: str([list(pair) for pair in each]) for key, each in pairs.items()}
