"""ROS 1's parameter files of gmapping, karto, amcl, move_base and its parts, as ours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from arjuna_core.errors import nearest
from bringup.parameters.files import Parameters
from bringup.parameters.foreign.ros1_names import (
    CLASSES,
    NODES,
    SECTIONS,
    TABLES,
    targets,
)
from bringup.parameters.foreign.ros1_others import WITHOUT

_COSTMAPS = ("global_costmap", "local_costmap")
_SOURCE = {
    **{name: name for name in ("topic", "data_type", "marking", "clearing", "inf_is_valid")},
    "expected_update_rate": "expected_update_rate",
    "obstacle_range": "obstacle_max_range",
    "raytrace_range": "raytrace_max_range",
}
_SOURCE_WITHOUT = ("sensor_frame", "observation_persistence")
_LAYERS = {
    "StaticLayer": "static_layer",
    "ObstacleLayer": "obstacle_layer",
    "VoxelLayer": "obstacle_layer",
    "InflationLayer": "inflation_layer",
}


class Converted(NamedTuple):
    """What a file means here.

    Attributes:
        parameters: By our names.
        without_meaning: Names that ROS 1 knows and that mean nothing here.
        unknown: A sentence for each name that nobody knows.
    """

    parameters: Parameters
    without_meaning: list[str]
    unknown: list[str]


def convert(document: Mapping[str, Any]) -> Converted:
    """Return a ROS 1 file's parameters by our names.

    A file may hold sections, as `amcl`, `move_base`, `DWAPlannerROS`, `local_costmap`, or the names
    of one of them alone; a costmap's names alone are for both costmaps.
    """
    conversion = _Conversion()
    conversion.take(document)
    return conversion.done()


class _Conversion:
    """What was found so far."""

    def __init__(self) -> None:
        self._parameters: Parameters = {}
        self._without: dict[str, None] = {}
        self._unknown: dict[str, None] = {}

    def take(self, document: Mapping[str, Any]) -> None:
        """Take a file, or a section that holds sections."""
        alone = {}
        for key, value in document.items():
            if _is_section(key, value):
                self._section(SECTIONS[key], value)
            elif key in WITHOUT:
                self._without[key] = None
            else:
                alone[key] = value
        sections = _sections_of(alone)
        for section in sections:
            self._section(section, alone)
        if alone and not sections:
            names = ", ".join(f"'{key}'" for key in alone)
            self._unknown[f"of no node that is known: {names}; valid: {', '.join(TABLES)}"] = None

    def done(self) -> Converted:
        """Return what was found, completed by what ROS 1 leaves unsaid."""
        follow = self._parameters.get("controller_server", {})
        for axis in ("x", "theta"):
            limit = follow.get(f"FollowPath.acc_lim_{axis}")
            if limit is not None:
                follow[f"FollowPath.decel_lim_{axis}"] = -float(limit)
        amcl = self._parameters.get("amcl", {})
        if any(key.startswith("initial_pose.") for key in amcl):
            amcl["set_initial_pose"] = True
        return Converted(self._parameters, list(self._without), list(self._unknown))

    def _section(self, section: str, values: Mapping[str, Any]) -> None:
        if section in ("DWAPlannerROS", "TrajectoryPlannerROS"):
            self._put("controller_server", "FollowPath.plugin", "dwb_core::DWBLocalPlanner")
        table = targets(section)
        for key, value in values.items():
            if _is_section(key, value):
                self._section(SECTIONS[key], value)
            elif section in _COSTMAPS and (isinstance(value, Mapping) or key == "plugins"):
                self._part(section, key, value)
            elif key in table and _has_meaning(key, value):
                for node, name in table[key]:
                    self._put(node, name, _ours(name, value))
                if not table[key]:
                    self._without[f"{section}: {key}"] = None
            elif key in table:
                self._without[f"{section}: {key}: {value}"] = None
            elif key in WITHOUT or any(key in targets(other) for other in TABLES):
                self._without[f"{section}: {key}"] = None  # another's: not read there in ROS 1
            else:
                self._unknown[f"{section}: nobody knows '{key}'; {nearest(key, table)}"] = None
        if section in _COSTMAPS and "static_map" in values and "plugins" not in values:
            static = ["static_layer"] if values["static_map"] else []
            self._put(NODES[section], "plugins", [*static, "obstacle_layer", "inflation_layer"])

    def _part(self, section: str, key: str, value: Any) -> None:
        """Take a costmap's list of layers, one of its layers, or one of its sources."""
        if key == "plugins":
            kinds = [str(layer.get("type", "")).rpartition("::")[2] for layer in value]
            layers = dict.fromkeys(_LAYERS[kind] for kind in kinds if kind in _LAYERS)
            self._put(NODES[section], "plugins", list(layers))
            for kind in (kind for kind in kinds if kind not in _LAYERS):
                self._without[f"{section}: the layer {kind}"] = None
        elif "topic" in value or "data_type" in value:
            for name, item in value.items():
                if name in _SOURCE:
                    place = f"obstacle_layer.{key}.{_SOURCE[name]}"
                    self._put(NODES[section], place, item)
                elif name in (*_SOURCE_WITHOUT, *targets(section)):
                    self._without[f"{section}: {key}.{name}"] = None
                else:
                    hint = nearest(name, _SOURCE)
                    self._unknown[f"{section}: nobody knows '{key}.{name}'; {hint}"] = None
        else:
            enabled = {name: item for name, item in value.items() if name == "enabled"}
            layer = "inflation_layer" if "infl" in key else "obstacle_layer"
            for item in enabled.values():
                self._put(NODES[section], f"{layer}.enabled", item)
            self._section(section, {k: v for k, v in value.items() if k not in enabled})

    def _put(self, node: str, name: str, value: Any) -> None:
        self._parameters.setdefault(node, {})[name] = value


def _is_section(key: str, value: Any) -> bool:
    return key in SECTIONS and isinstance(value, Mapping)


def _sections_of(values: Mapping[str, Any]) -> tuple[str, ...]:
    """Return whose names these are for the most part, nobody's if none is known."""
    known = {name: len(values.keys() & targets(name).keys()) for name in TABLES}
    best = max(known, key=lambda name: known[name])
    if not known[best]:
        return ()
    return _COSTMAPS if best in _COSTMAPS else (best,)


def _has_meaning(key: str, value: Any) -> bool:
    """Tell whether a value means anything here: a class that we have, an interval that is one."""
    if key in ("base_local_planner", "base_global_planner", "odom_model_type"):
        return value in CLASSES
    return not (key in ("temporalUpdate", "planner_frequency") and float(value) <= 0.0)


def _ours(name: str, value: Any) -> Any:
    """Return a value as our parameter takes it."""
    if name in ("width", "height"):
        return math.ceil(value)
    if name == "footprint" and not isinstance(value, str):
        return str(value)
    if isinstance(value, str) and ("frame" in name or value in CLASSES):
        return CLASSES.get(value, value.lstrip("/"))
    return value
