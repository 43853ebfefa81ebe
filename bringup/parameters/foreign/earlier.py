"""A section in the forms that Nav2 has before Foxy, in those since.

Source: navigation2's params/nav2_params.yaml of Dashing and Eloquent. A server had one plug-in,
or listed names (`*_ids`, `plugin_names`) and classes (`*_types`) apart; a costmap's own
`observation_sources` fed its layers, and the controller itself had the goal's tolerances.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple


class _Server(NamedTuple):
    """Today's form of a server of one plug-in: list of plug-ins, the one's name and class."""

    plugins: str
    name: str
    cls: str


_DWB = _Server("controller_plugins", "FollowPath", "dwb_core::DWBLocalPlanner")
_NAVFN = _Server("planner_plugins", "GridBased", "nav2_navfn_planner::NavfnPlanner")
_SERVERS = {
    "dwb_controller": _DWB,
    "DwbController": _DWB,
    "navfn_planner": _NAVFN,
    "NavfnPlanner": _NAVFN,
}
_OF_SERVER = (
    *("use_sim_time", "controller_frequency", "expected_planner_frequency"),
    *("min_x_velocity_threshold", "min_y_velocity_threshold", "min_theta_velocity_threshold"),
)
_PROGRESS = ("required_movement_radius", "movement_time_allowance")
_GOAL = ("xy_goal_tolerance", "yaw_goal_tolerance", "stateful")
_LISTS = {
    **dict.fromkeys(("local_costmap", "global_costmap"), ("plugin_names", "plugins")),
    "recoveries_server": ("plugin_names", "recovery_plugins"),
    "controller_server": ("controller_plugin_ids", "controller_plugins"),
    "planner_server": ("planner_plugin_ids", "planner_plugins"),
}
"""By section, the list of its plug-ins' names and what it is called today."""
_NAMES = {"back_up": "backup"}
_SOURCES = "observation_sources"
_OBSTACLES = "ObstacleLayer", "VoxelLayer"


def as_since_foxy(section: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a section's values as Nav2 has them since Foxy.

    Args:
        section: Its name in the file.
    """
    name = section.rpartition("/")[2]
    values = _of_one_plugin(_SERVERS[name], given) if name in _SERVERS else dict(given)
    if name in _LISTS:
        values = _with_classes(values, *_LISTS[name])
    return _with_sources(values) if name.endswith("_costmap") else values


def _of_one_plugin(server: _Server, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a server of one plug-in as those of a server with a list of one."""
    plugin = server.name
    found: dict[str, Any] = {server.plugins: [plugin], f"{plugin}.plugin": server.cls}
    if server is _DWB:
        found |= _with_checkers(given, "")
    for key, value in given.items():
        if key not in _PROGRESS:
            found[key if key in _OF_SERVER else f"{plugin}.{key}"] = value
    return found


def _with_checkers(given: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    """Return the checkers of a controller that has their parameters itself."""
    goal = {f"goal_checker.{key}": given[prefix + key] for key in _GOAL if prefix + key in given}
    way = {f"progress_checker.{key}": given[key] for key in _PROGRESS if key in given}
    return {
        "goal_checker_plugins": ["goal_checker"],
        "goal_checker.plugin": "nav2_controller::SimpleGoalChecker",
        "progress_checker_plugins": ["progress_checker"],
        "progress_checker.plugin": "nav2_controller::SimpleProgressChecker",
        **goal,
        **way,
    }


def _with_classes(values: dict[str, Any], names: str, plugins: str) -> dict[str, Any]:
    """Return values in which the plug-ins of two lists have their classes as `NAME.plugin`."""
    types = re.sub("(names|ids)$", "types", names)
    classes, given = values.get(types), values.get(names)
    if not isinstance(classes, list) or not isinstance(given, list) or len(classes) != len(given):
        return values
    found = {key: value for key, value in values.items() if key not in (types, names)}
    found[plugins] = [_NAMES.get(name, name) for name in map(str, given)]
    for name, cls in zip(found[plugins], classes, strict=True):
        found.setdefault(f"{name}.plugin", cls)
    if plugins == "controller_plugins" and not any("goal_checker_plugin" in key for key in values):
        checkers = _with_checkers(values, f"{found[plugins][0]}." if given else "")
        found = {**checkers, **{key: v for key, v in found.items() if key not in _PROGRESS}}
    return found


def _with_sources(values: dict[str, Any]) -> dict[str, Any]:
    """Return a costmap's values in which its own sources of observations are its layers'."""
    sources = values.get(_SOURCES)
    if not isinstance(sources, str):
        return values
    own = (_SOURCES, *(f"{source}." for source in sources.split()))
    found = {key: value for key, value in values.items() if not key.startswith(own)}
    classes = {key: str(cls) for key, cls in values.items() if key.endswith(".plugin")}
    layers = [key.rpartition(".")[0] for key in classes if classes[key].endswith(_OBSTACLES)]
    for layer in layers or ["obstacle_layer"]:
        below = {f"{layer}.{key}": values[key] for key in values if key.startswith(own)}
        found = {**below, **found}
    return found
