"""A costmap's layers and sources as others name them, as those that our costmaps have."""

from __future__ import annotations

import difflib
import re
from typing import Any, NamedTuple

from arjuna_core.errors import nearest
from arjuna_core.plugins import canonical

COSTMAPS = ("local_costmap/local_costmap", "global_costmap/global_costmap")
_OURS = {
    "nav2_costmap_2d::StaticLayer": "static_layer",
    "nav2_costmap_2d::ObstacleLayer": "obstacle_layer",
    "nav2_costmap_2d::VoxelLayer": "obstacle_layer",
    "nav2_costmap_2d::RangeSensorLayer": "range_layer",
    "nav2_costmap_2d::DenoiseLayer": "denoise_layer",
    "nav2_costmap_2d::InflationLayer": "inflation_layer",
}
_SOURCES = {"LaserScan": "scan", "PointCloud2": "cloud"}
_WITHOUT = ("KeepoutFilter", "SpeedFilter", "BinaryFilter", "PluginContainerLayer")
_LAYER = re.compile(r"[^.]+\.plugin$")
_NEAR = 0.85  # likeness of a class to one of ours from which on it is taken for misspelt
_CLASSES = {ours: theirs for theirs, ours in reversed(_OURS.items())}


class Layers(NamedTuple):
    """A costmap's values with layers that we have.

    Attributes:
        values: By our names.
        left_out: Layers that others have, as a note says them.
        problems: Layers of a class that nobody knows, a sentence each.
    """

    values: dict[str, Any]
    left_out: list[str]
    problems: list[str]


def layers_as_ours(given: dict[str, Any], below: dict[str, Any]) -> Layers:
    """Return a costmap's values with its layers under our names.

    A layer may have any name, and a voxel layer's scans mark and clear as an obstacle layer's. A
    second layer of obstacles gives its sources to the first, as far as that has none of the type.
    A layer of a class that we do not have is left out. A name without a class stays: the node's
    own check tells of it.

    Args:
        given: A file's values by dotted name.
        below: Those that hold already.
    """
    names = given.get("plugins", below.get("plugins", ()))
    names = list(names) if isinstance(names, (list, tuple)) else []
    sections = [key.removesuffix(".plugin") for key in given if _LAYER.match(key)]
    ours: dict[str, str] = {}
    left, problems = dict[str, str](), list[str]()
    for name in dict.fromkeys([*names, *sections]):
        class_name = _class_of(name, given)
        kind = _OURS.get(class_name) if class_name else name
        if kind is not None and kind not in ours.values():
            ours[name] = kind
        elif kind == "obstacle_layer":
            given = _with_sources(given, name, next(n for n in ours if ours[n] == kind))
            left[name] = "its sources are obstacle_layer's, one of a type"
        elif kind is not None or _is_known_elsewhere(class_name):
            left[name] = class_name
        else:
            left[name] = ""
            problems.append(
                f"layer '{name}': no class '{class_name}'; {nearest(class_name, _OURS)}"
            )
    values = {}
    for key, value in given.items():
        layer, dot, rest = key.partition(".")
        if not dot or layer not in left:
            values[f"{ours[layer]}.{rest}" if dot and layer in ours else key] = value
    if "plugins" in given:
        values["plugins"] = [ours[name] for name in names if name in ours]
    for kind in set(ours.values()) & {k.partition(".")[0] for k in values}:
        if f"{kind}.plugin" in values:
            values[f"{kind}.plugin"] = _CLASSES[kind]
    notes = [f"layer {name} ({why})" for name, why in left.items() if why]
    return Layers(_source_as_ours(values), notes, problems)


def _class_of(name: str, given: dict[str, Any]) -> str:
    """Return the class of a layer, as the file or its name says; nothing where neither does."""
    default = _CLASSES.get(name, "nav2_costmap_2d::VoxelLayer" if "voxel" in name else "")
    return canonical(str(given.get(f"{name}.plugin", default)))


def _is_known_elsewhere(class_name: str) -> bool:
    """Tell whether a layer is Nav2's, without a counterpart here, or of a package of others."""
    package, _, last = class_name.rpartition("::")
    if package in ("", "nav2_costmap_2d"):
        return last in _WITHOUT
    return not difflib.get_close_matches(class_name, _OURS, 1, _NEAR)


def _with_sources(given: dict[str, Any], second: str, first: str) -> dict[str, Any]:
    """Return values in which a layer has those sources of another whose type it lacks."""
    values = dict(given)
    mine = str(given.get(f"{first}.observation_sources", "")).split()
    types = {_type_of(given, first, source) for source in mine}
    for source in str(given.get(f"{second}.observation_sources", "")).split():
        if (type_name := _type_of(given, second, source)) in types or source in mine:
            continue
        types.add(type_name)
        mine.append(source)
        start = f"{second}.{source}."
        moved = {key: value for key, value in given.items() if key.startswith(start)}
        values |= {f"{first}.{key.removeprefix(f'{second}.')}": v for key, v in moved.items()}
    return {**values, f"{first}.observation_sources": " ".join(mine)} if mine else values


def _source_as_ours(given: dict[str, Any]) -> dict[str, Any]:
    """Return values in which the first source of a type is called as ours of that type."""
    sources = str(given.get("obstacle_layer.observation_sources", "")).split()
    if not sources:
        return given
    types = {source: _type_of(given, "obstacle_layer", source) for source in reversed(sources)}
    first = {kind: source for source, kind in types.items()}
    ours = {first[kind]: name for kind, name in _SOURCES.items() if kind in first}
    values = {}
    for key, value in given.items():
        layer, _, rest = key.partition(".")
        source, dot, name = rest.partition(".")
        if layer == "obstacle_layer" and dot and source in ours:
            key = f"obstacle_layer.{ours[source]}.{name}"
        values[key] = value
    values["obstacle_layer.observation_sources"] = " ".join(ours.values()) or "scan"
    return values


def _type_of(values: dict[str, Any], layer: str, source: str) -> str:
    return str(values.get(f"{layer}.{source}.data_type", "LaserScan"))
