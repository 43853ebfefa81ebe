"""ROS 1's parameter files of gmapping, karto, amcl, move_base and its parts, as ours."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from arjuna_core.errors import nearest
from bringup.parameters.files import Parameters
from bringup.parameters.foreign.ros1_names import (
    CLASSES,
    COSTMAPS,
    LAYERS,
    PROGRAMS,
    REASONS,
    SECTIONS,
    TABLES,
    TOPICS,
    WITHOUT,
    holds_sections,
    is_section,
    nested,
    other_program,
    renamed_section,
    sections_of,
    targets,
)

_SOURCE = {name: key for name, [(_, key)] in targets("source").items()}
"""Our name of each parameter of a source of observations."""
_LEAST_TURNS = (
    "min_vel_theta",
    "min_rot_vel",
    "min_in_place_vel_theta",
    "min_in_place_rotational_vel",
)
_WEIGHTS = [f"FollowPath.{of}{what}.scale" for of in ("Path", "Goal") for what in ("Dist", "Align")]
_LAYER = "obstacle_layer."
_OF_VOXELS = "origin_z z_resolution z_voxels mark_threshold unknown_threshold publish_voxel_map"


class Converted(NamedTuple):
    """A file by our names."""

    parameters: Parameters
    without_meaning: list[str]
    unknown: list[str]


def convert(
    document: Mapping[str, Any], topics: Mapping[str, Mapping[str, str]] | None = None
) -> Converted:
    """Return a ROS 1 file's parameters by our names.

    A file may hold sections, as `amcl`, `move_base`, `DWAPlannerROS`, `local_costmap`, in a
    namespace or by path (`/amcl/min_particles`), or the names of one of them alone; a costmap's
    names alone are for both costmaps. A launch file gives new names of topics by section.
    """
    conversion = _Conversion()
    conversion.take(nested(document))
    return conversion.done(topics or {})


class _Conversion:
    def __init__(self) -> None:
        self._parameters: Parameters = {}
        self._without: dict[str, None] = {}
        self._unknown: dict[str, None] = {}
        self._misspelt: dict[str, dict[str, None]] = {}
        self._weighs_metres: bool | None = None

    def take(self, document: Mapping[str, Any]) -> None:
        """Take a file, or a section that holds sections."""
        alone = {}
        for key, value in document.items():
            if is_section(key, value):
                self._section(SECTIONS[key], value)
            elif key in WITHOUT:
                self._without[key] = None
            elif holds_sections(value):
                self.take(value)
            elif section := renamed_section(value):
                self._section(section, value)
            else:
                alone[key] = value
        self._take_alone(alone)

    def _take_alone(self, values: Mapping[str, Any]) -> None:
        names = ", ".join(f"'{key}'" for key in values)
        if other := other_program(values):
            remedy = PROGRAMS[other]["remedy"]
            self._unknown[f"of {other}, which is not here: {names}; {remedy}"] = None
            return
        sections = sections_of(values)
        for section in sections:
            self._section(section, values)
        if values and not sections:
            self._unknown[f"of no node that is known: {names}; valid: {', '.join(TABLES)}"] = None

    def done(self, topics: Mapping[str, Mapping[str, str]]) -> Converted:
        """Return what was found, completed by ROS 1's defaults and the new names of topics."""
        follow = self._parameters.get("controller_server", {})
        for axis in ("x", "theta"):
            limit = follow.get(f"FollowPath.acc_lim_{axis}")
            if isinstance(limit, int | float):
                follow[f"FollowPath.decel_lim_{axis}"] = -float(limit)
        for section in COSTMAPS:
            _complete_sources(self._parameters.get(TABLES[section]["of"], {}))
        if self._weighs_metres is not None:
            self._weigh(follow)
        amcl = self._parameters.get("amcl", {})
        if any(key.startswith("initial_pose.") for key in amcl):
            amcl["set_initial_pose"] = True
        self._rename_topics(topics)
        unknown = [line for item in self._misspelt.items() for line in _misspelt_lines(*item)]
        return Converted(self._parameters, list(self._without), [*unknown, *self._unknown])

    def _rename_topics(self, topics: Mapping[str, Mapping[str, str]]) -> None:
        """Put new names of topics into parameters; note those that have none for it."""
        for section, names in topics.items():
            for old, new in names.items():
                ours = TOPICS.get(f"{SECTIONS[section]}/{old.strip('/')}", "").split()
                for node, _, key in (one.partition(":") for one in ours):
                    self._put(node, key, new)
                if not ours:
                    self._without[f"{section}: remap from {old} to {new}"] = None

    def _weigh(self, follow: dict[str, Any], cell: float = 0.05) -> None:
        """Write TrajectoryPlanner's weights, of a metre or a cell, as DWB's, of half a metre.

        Source: base_local_planner, trajectory_planner.cpp; dwb_critics, map_grid.cpp. A cell's
        size [m] is that of costmap_2d (Costmap2D.cfg) where the file gives none.
        """
        costmap = self._parameters.get(TABLES["local_costmap"]["of"], {})
        unit = 1.0 if self._weighs_metres else costmap.get("resolution", cell)
        for key in _WEIGHTS:
            if isinstance(follow.get(key), int | float):
                follow[key] = round(2.0 * follow[key] / unit, 3)

    def _section(self, section: str, values: Mapping[str, Any]) -> None:
        if section == "TrajectoryPlannerROS":
            self._weighs_metres = bool(values.get("meter_scoring"))
        if section in ("DWAPlannerROS", "TrajectoryPlannerROS"):
            self._put("controller_server", "FollowPath.plugin", "dwb_core::DWBLocalPlanner")
        table, recoveries = targets(section), _recoveries(values)
        for key, value in values.items():
            if is_section(key, value):
                self._section(SECTIONS[key], value)
            elif section in COSTMAPS and (isinstance(value, Mapping) or key == "plugins"):
                self._part(section, key, value)
            elif key in table and _has_meaning(key, value, values):
                for node, name in table[key]:
                    self._put(node, name, _ours(name, value))
                if not table[key]:
                    self._leave(f"{section}: {key}", key)
            elif key in table:
                said = str(value).lower() if isinstance(value, bool) else value
                self._leave(f"{section}: {key}: {said}", key)
            elif key in WITHOUT | recoveries or any(key in targets(other) for other in TABLES):
                self._without[f"{section}: {key}"] = None  # another's: not read there in ROS 1
            else:
                self._misspelt.setdefault(section, {})[key] = None
        if section in COSTMAPS and "static_map" in values and "plugins" not in values:
            static = ["static_layer"] if values["static_map"] else []
            self._put_layers(section, [*static, "obstacle_layer", "inflation_layer"])

    def _part(self, section: str, key: str, value: Any) -> None:
        if key == "plugins":
            types = [item.get("type", "") for item in value or () if isinstance(item, Mapping)]
            kinds = [str(name).rpartition("::")[2] for name in types]
            self._put_layers(section, [LAYERS[kind] for kind in kinds if kind in LAYERS])
            for kind in (kind for kind in kinds if kind not in LAYERS):
                self._without[f"{section}: the layer {kind}"] = None
        elif "topic" in value or "data_type" in value:
            self._take_source(section, key, value)
        else:
            if "enabled" in value:
                layer = _layer_of(key, value)
                self._put(TABLES[section]["of"], f"{layer}.enabled", value["enabled"])
            self._section(section, {k: v for k, v in value.items() if k != "enabled"})

    def _take_source(self, section: str, source: str, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if name in _SOURCE:
                self._put(TABLES[section]["of"], f"{_LAYER}{source}.{_SOURCE[name]}", value)
            elif name in targets(section):
                self._without[f"{section}: {source}.{name}"] = None
            else:
                hint = nearest(name, _SOURCE)
                self._unknown[f"{section}: nobody knows '{source}.{name}'; {hint}"] = None

    def _put_layers(self, section: str, layers: Iterable[str]) -> None:
        self._put(TABLES[section]["of"], "plugins", list(dict.fromkeys(layers)))

    def _leave(self, what: str, key: str) -> None:
        """Note what has no meaning here, and why where that is known."""
        self._without[f"{what} ({REASONS[key]})" if key in REASONS else what] = None

    def _put(self, node: str, name: str, value: Any) -> None:
        self._parameters.setdefault(node, {})[name] = value


def _complete_sources(values: dict[str, Any], highest: float = 2.0) -> None:
    """Give each source of a costmap what ROS 1 says for all of them, and voxels their class.

    In ROS 1 a source without max_obstacle_height takes points up to a height [m].
    """
    sources = str(values.get(f"{_LAYER}observation_sources", "")).split()
    every = f"{_LAYER}scan."  # where the tables put the ranges of all
    ranges = {name: value for name, value in values.items() if name.startswith(every)}
    for name in ranges if sources and "scan" not in sources else ():
        del values[name]
    for source in sources:
        values.setdefault(f"{_LAYER}{source}.max_obstacle_height", highest)
        for name, value in ranges.items():
            if name.endswith("_range"):
                values.setdefault(f"{_LAYER}{source}.{name.removeprefix(every)}", value)
    if any(f"{_LAYER}{name}" in values for name in _OF_VOXELS.split()):
        values[f"{_LAYER}plugin"] = "nav2_costmap_2d::VoxelLayer"


def _misspelt_lines(section: str, names: Iterable[str]) -> list[str]:
    table, far, lines = targets(section), [], []
    for name in names:
        hint = nearest(name, table)
        if hint.startswith("valid"):
            far.append(f"'{name}'")
        else:
            lines.append(f"{section}: nobody knows '{name}'; {hint}")
    if far:
        lines.append(f"{section}: nobody knows {', '.join(far)}; valid: {', '.join(table)}")
    return lines


def _recoveries(values: Mapping[str, Any]) -> set[str]:
    """Return how a file calls its recoveries: each has a section that means nothing here."""
    listed = values.get("recovery_behaviors") or ()
    return {str(item.get("name")) for item in listed if isinstance(item, Mapping)}


def _layer_of(name: str, values: Mapping[str, Any]) -> str:
    if "infl" in name or values.keys() & {"inflation_radius", "cost_scaling_factor"}:
        return "inflation_layer"
    is_static = "static" in name or values.keys() & {"map_topic", "first_map_only"}
    return "static_layer" if is_static else "obstacle_layer"


def _has_meaning(key: str, value: Any, beside: Mapping[str, Any]) -> bool:
    """Return whether a value means anything here: a class that we have, an interval that is one."""
    if key in ("base_local_planner", "base_global_planner", "odom_model_type"):
        return value in CLASSES
    if key in ("recovery_behavior_enabled", "clearing_rotation_allowed"):
        return value is False
    if key == "maxRange":
        return "maxUrange" not in beside
    if key == "max_planning_retries" and beside.get("recovery_behavior_enabled") is False:
        return False
    if not isinstance(value, int | float):
        return True
    if key == "escape_vel":
        return value < 0.0
    above = ("temporalUpdate", "planner_frequency", *_LEAST_TURNS)
    return not (key in above and value <= 0.0)


def _ours(name: str, value: Any) -> Any:
    if name.endswith(".use_astar"):
        return not value
    if name in ("number_of_retries", "spin_dist") and value is False:
        return 0 if name == "number_of_retries" else 0.0
    if name == "backup_speed":
        return abs(value)
    if name in ("width", "height") and isinstance(value, float):
        return math.ceil(value)
    if name == "footprint" and not isinstance(value, str):
        return str(value)
    if isinstance(value, str) and ("frame" in name or value in CLASSES):
        return CLASSES.get(value, value.lstrip("/"))
    return value
