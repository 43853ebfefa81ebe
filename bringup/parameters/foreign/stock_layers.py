"""A costmap's layers and sources as others name them, as those that our costmaps have."""

from __future__ import annotations

from typing import Any

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
_CLASSES = {ours: theirs for theirs, ours in reversed(_OURS.items())}


def layers_as_ours(given: dict[str, Any], below: dict[str, Any]) -> dict[str, Any]:
    """Return a costmap's values with its layers under our names.

    A layer may have any name, and a voxel layer's scans mark and clear as an obstacle layer's. A
    layer of a class that we do not have, or the second of a class, is left out of `plugins`; its
    values keep their names. A name without a class stays: the node's own check tells of it.

    Args:
        given: A file's values by dotted name.
        below: Those that hold already.
    """
    names = given.get("plugins", below.get("plugins", ()))
    names = list(names) if isinstance(names, (list, tuple)) else []
    sections = [key.removesuffix(".plugin") for key in given if key.endswith(".plugin")]
    ours: dict[str, str] = {}
    for name in dict.fromkeys([*names, *sections]):
        default = _CLASSES.get(name, "nav2_costmap_2d::VoxelLayer" if "voxel" in name else "")
        class_name = str(given.get(f"{name}.plugin", default))
        kind = _OURS.get(canonical(class_name)) if class_name else name
        if kind is not None and kind not in ours.values():
            ours[name] = kind
    values = {}
    for key, value in given.items():
        layer, dot, rest = key.partition(".")
        values[f"{ours[layer]}.{rest}" if dot and layer in ours else key] = value
    if "plugins" in given:
        values["plugins"] = [ours[name] for name in names if name in ours]
    for kind in set(ours.values()) & {k.partition(".")[0] for k in values}:
        if f"{kind}.plugin" in values:
            values[f"{kind}.plugin"] = _CLASSES[kind]
    return _source_as_ours(values)


def _source_as_ours(given: dict[str, Any]) -> dict[str, Any]:
    """Return values in which the first source of a type is called as ours of that type."""
    sources = str(given.get("obstacle_layer.observation_sources", "")).split()
    if not sources:
        return given
    types = {source: _type_of(given, source) for source in reversed(sources)}
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


def _type_of(values: dict[str, Any], source: str) -> str:
    return str(values.get(f"obstacle_layer.{source}.data_type", "LaserScan"))
