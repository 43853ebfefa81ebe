"""Sources beside parameter files: the command line's words and options, a robot's names."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.config import infos
from arjuna_core.errors import ConfigError
from arjuna_core.files.yaml_file import plain
from arjuna_core.param import ParamInfo
from arjuna_core.plugins import config_class_for
from bringup.parameters.files import EVERY_NODE, Parameters, Source, for_node, merged
from bringup.stack import ORIGINALS, Group, NodeSpec

COSTMAPS = ("local_costmap/local_costmap", "global_costmap/global_costmap")
ROBOT_NAMES: dict[str, dict[str, str]] = {
    "scan_topic": dict.fromkeys(("slam_toolbox", "amcl"), "scan_topic"),
    "cloud_topic": {},
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
        **dict.fromkeys(
            (*COSTMAPS, "bt_navigator", "behavior_server", "explorer"), "robot_base_frame"
        ),
        **dict.fromkeys(("docking_server", "route_server"), "base_frame"),
    },
    "odom_frame": {
        "slam_toolbox": "odom_frame",
        **dict.fromkeys(("amcl", "collision_monitor"), "odom_frame_id"),
        "local_costmap/local_costmap": "global_frame",
        "docking_server": "fixed_frame",
    },
    "wheel_odom": {"ekf_filter_node": "odom0"},
    "imu": {"ekf_filter_node": "imu0", "bt_navigator": "imu_topic"},
}
"""The parameter of each node that a name of the robot's sets; an option of that name sets all.

Plug-ins' own say so where they are declared (`of_robot`)."""
_SEEN = {
    **dict.fromkeys(("LaserScan", "scan"), "scan_topic"),
    **dict.fromkeys(("PointCloud2", "pointcloud"), "cloud_topic"),
}
"""The robot's name that a source of a type has, a costmap's or the collision monitor's."""
OUTLINE = ("footprint", "robot_radius")
"""The parameters of a costmap that are the robot's outline."""
_ROBOT_NODES = ("sim", "robot_state_publisher")
_OPTIONS: dict[str, tuple[tuple[str, ...], str]] = {
    "world": (("sim",), "world"),
    "robot": (_ROBOT_NODES, "robot"),
    "robot_arguments": (_ROBOT_NODES, "robot_arguments"),
    "viewer": (("sim",), "viewer"),
    "rtf": (("sim",), "real_time_factor"),
    "map": (("map_server",), "yaml_filename"),
    "maps_folder": (("map_saver", "map_server", "slam_toolbox"), "maps_folder"),
}
"""The nodes and the parameter that an option of the command line stands for."""


def of_words(words: Iterable[str]) -> Source:
    """Return the parameters of words as `rcl` reads them: `NAME:=VALUE` or `NODE:NAME:=VALUE`.

    Raises:
        ConfigError: A word is none, or its value is no YAML.
    """
    found: Parameters = {}
    for word in words:
        name, sign, text = word.partition(":=")
        node, _, key = name.rpartition(":")
        if not (sign and key):
            raise ConfigError(f"--param '{word}' is none; valid: NAME:=VALUE, NODE:NAME:=VALUE")
        try:
            value = plain(text)
        except yaml.YAMLError as error:
            raise ConfigError(f"--param {name}: {text!r} is no YAML value") from error
        if isinstance(value, list) and any(isinstance(each, list) for each in value):
            value = text  # no parameter is a list of lists: Nav2's outlines are their text
        section = node if node == EVERY_NODE else node.strip("/") or EVERY_NODE
        found.setdefault(section, {})[key] = "" if value is None else value
    return Source("--param", found)


def originals_of(options: Mapping[str, Any]) -> list[str]:
    """Return whose behaviour the command line's options ask for."""
    return [name for name in ORIGINALS if options.get(f"as_{name}")]


def as_theirs(parameters: Parameters, nodes: Iterable[NodeSpec], replaces: bool) -> Parameters:
    """Return parameters with the values that have their stack's behaviour, where one differs.

    Args:
        parameters: By node.
        nodes: Those that are meant.
        replaces: Whether values that are given go, else only those that are not given.
    """
    found: Parameters = {}
    for spec in nodes:
        values = for_node(parameters, spec.name)
        known = known_keys(spec, values)
        found[spec.name] = {
            key: list(info.theirs) if isinstance(info.theirs, tuple) else info.theirs
            for key, info in known.items()
            if info.theirs is not None and (replaces or key not in values)
        }
    return merged(parameters, {node: values for node, values in found.items() if values})


def of_options(
    options: Mapping[str, Any], groups: Iterable[Group], parameters: Parameters
) -> Parameters:
    """Return the parameters that the command line's options stand for.

    Raises:
        ConfigError: The starts of several robots are at odds.
    """
    found: Parameters = {}
    for option, (nodes, key) in _OPTIONS.items():
        value = options.get(option)
        if isinstance(value, Path):
            value = str(value.resolve())
        elif isinstance(value, list):
            value = shlex.join(value)
        if value is not None and value is not False and value != "":
            for node in nodes:
                found.setdefault(node, {})[key] = value
    if starts := _starts(options):
        found.setdefault("sim", {}).update(starts)
    if options.get("without_description"):
        # Neither our filter is there, nor are the frames that our robot_state_publisher adds.
        found.setdefault("sim", {}).update(fused_odometry=False, frames_of_file=True)
    running = [spec for group in groups for spec in group.nodes]
    for spec in running if options.get("seed") is not None else ():
        if "seed" in spec.config.__dataclass_fields__:
            found.setdefault(spec.name, {})["seed"] = options["seed"]
    return merged(found, of_names(options, groups, parameters))


def is_fleet(options: Mapping[str, Any]) -> bool:
    """Return whether options name several robots, or one of several that Gazebo has in a world."""
    fewest = 0 if options.get("without_description") else 1
    return len(options.get("robots") or ()) > 1 or len(options.get("namespaces") or ()) > fewest


def _starts(options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of `sim` that say which robots there are, and where they start.

    One robot's file is that of all namespaces.
    """
    positions: Sequence[Sequence[float]] = options.get("ats") or []
    headings: Sequence[float] = options.get("yaws") or []
    if not is_fleet(options):
        if max(len(positions), len(headings)) > 1:
            raise ConfigError("--at or --yaw is given again, but there is one robot")
        given = dict(zip(("x", "y"), *positions, strict=True)) if positions else {}
        given |= dict(zip(("yaw",), headings, strict=False))
        return {f"initial_pose.{key}": value for key, value in given.items()}
    if headings and len(headings) != len(positions):
        problem = f"{len(positions)} places (--at) and {len(headings)} headings (--yaw) are given"
        raise ConfigError(f"{problem}; each place needs one, or none")
    names = options.get("namespaces") or []
    files = [str(path.resolve()) for path in options.get("robots") or []]
    starts = zip(positions, headings or [0.0] * len(positions), strict=True)
    values = {
        "namespaces": names,
        "robots": files * len(names) if len(files) == 1 else files,
        "starts": [number for (x, y), yaw in starts for number in (x, y, yaw)],
    }
    return {key: value for key, value in values.items() if value}


def of_names(
    names: Mapping[str, Any],
    groups: Iterable[Group],
    parameters: Parameters,
    is_set: Callable[[str, str], bool] = lambda node, key: False,
) -> Parameters:
    """Return the parameters that a robot's names stand for.

    Args:
        names: By a key of `ROBOT_NAMES`; None, or no name at all, for that of the other sources. Of
            several topics of scans or clouds, the first is heard by who takes one.
        groups: The groups that run; nodes of others are left alone.
        parameters: Of all nodes; which layers a costmap has, and which sources they have.
        is_set: Whether a node's parameter is not to change; of such a list, or a source's such
            topic, no others are made.
    """
    found: Parameters = {}
    given = {what: names[what] for what in ROBOT_NAMES if names.get(what) is not None}
    for spec in (spec for group in groups for spec in group.nodes if given):
        own = parameters.get(spec.name, {})
        keys, values = keys_by_name(spec, own), dict[str, Any]()
        for what, value in given.items():
            for key in keys[what]:
                is_seen = what in _SEEN.values()
                made = _sources(own, key, value.split() or [""]) if is_seen else {key: value}
                kept = any(is_set(spec.name, each) for each in made)
                values |= {key: made[key]} if kept else made
        if values:
            found[spec.name] = values
    return found


def _sources(values: Mapping[str, Any], key: str, topics: Sequence[str]) -> dict[str, Any]:
    """Return a parameter that names a scan or a cloud; of a source, others like it and the list."""
    source, found = key.removesuffix(".topic"), {key: topics[0]}
    prefix = source[: source.rfind(".") + 1]
    names = values.get(listed := f"{prefix}observation_sources")
    if not names or source == key:
        return found
    for number, topic in enumerate(topics[1:], start=2):
        name = f"{source}_{number}"
        own = {k.removeprefix(source): v for k, v in values.items() if k.startswith(f"{source}.")}
        found |= {f"{name}{k}": v for k, v in {**own, ".topic": topic}.items()}
        name = name.removeprefix(prefix)
        names = f"{names} {name}" if isinstance(names, str) else [*names, name]
    return {**found, listed: names} if topics[1:] else found


def known_keys(spec: NodeSpec, values: Mapping[str, Any]) -> dict[str, ParamInfo]:
    """Return what is known of each parameter of a node, those of its plug-ins too."""
    return infos(config_class_for(spec.config, dict(values), "", []))


def keys_by_name(spec: NodeSpec, values: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the parameters of a node, and of its plug-ins, that are each of the robot's names.

    Of several sources of plug-ins the first of each type is the robot's.
    """
    named = {what: [keys[spec.name]] for what, keys in ROBOT_NAMES.items() if spec.name in keys}
    found: dict[str, list[str]] = {what: named.get(what, []) for what in ROBOT_NAMES}
    taken = set()
    for key, info in known_keys(spec, values).items():
        what = info.of_robot
        if what == "scan_topic":
            source = key.rpartition(".")[0]
            kinds = (values.get(f"{source}.{of}", "scan") for of in ("data_type", "type"))
            what = next((_SEEN.get(kind, "") for kind in kinds if kind != "scan"), what)
            if what in taken:
                continue
            taken.add(what)
        if what:
            found[what].append(key)
    return found


def keys_of_robot(spec: NodeSpec, values: Mapping[str, Any]) -> frozenset[str]:
    """Return the parameters of a node that are the robot's own: topics, frames and outline."""
    named = (key for keys in keys_by_name(spec, values).values() for key in keys)
    return frozenset({*named, "robot_base_frame", *OUTLINE})


def with_base_frame(given: Parameters, below: Parameters) -> Parameters:
    """Return a file's parameters, with its one base frame at every node that names none.

    A file that names two, as Nav2's own base_link and base_footprint, stays as it is.
    """
    keys = ROBOT_NAMES["base_frame"]
    named = {node: frame for node, key in keys.items() if (frame := given.get(node, {}).get(key))}
    frames = {str(frame).lstrip("/") for frame in named.values()}
    if len(frames) != 1:
        return given
    (frame,) = frames
    unnamed = {node: key for node, key in keys.items() if node not in named}
    own = {n: {k: frame} for n, k in unnamed.items() if below.get(n, {}).get(k) != frame}
    return merged(own, given)
