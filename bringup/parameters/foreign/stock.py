"""Parameter files that others wrote for Nav2, slam_toolbox and AMCL, as our nodes' parameters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from arjuna_core.config import infos
from arjuna_core.errors import nearest
from arjuna_core.plugins import canonical, shaped
from bringup.parameters.composition import node_class
from bringup.parameters.files import EVERY_NODE, Parameters, merged, unknown_nodes
from bringup.parameters.foreign.known import known_elsewhere, known_node, known_value
from bringup.parameters.foreign.stock_layers import COSTMAPS, Layers, layers_as_ours
from bringup.stack import NodeSpec

_RENAMED_NODES = {"recoveries_server": "behavior_server"}  # Nav2 before Humble
_RENAMED = {
    "behavior_server": {
        "cmd_vel_teleop": "cmd_vel_teleop_topic",
        "recovery_plugins": "behavior_plugins",
    },
    "collision_monitor": {"scan.topic": "scan_topic"},
    "controller_server": {
        "progress_checker_plugin": "progress_checker_plugins",
        "goal_checker_plugin": "goal_checker_plugins",
    },
}
_OLDER = {
    ("amcl", "robot_model_type"): {
        "differential": "nav2_amcl::DifferentialMotionModel",
        "omnidirectional": "nav2_amcl::OmniMotionModel",
    },
}


class Understood(NamedTuple):
    """What a file means here.

    Attributes:
        parameters: Those below, with the file's over them.
        notes: What others know and we do without, a line a node.
        problems: What nobody knows, a sentence each.
    """

    parameters: Parameters
    notes: list[str]
    problems: list[str]


def understand(given: Parameters, below: Parameters, specs: Iterable[NodeSpec]) -> Understood:
    """Return what a file's parameters mean here, over those that hold already.

    A node's key that nobody knows stays: the node's own check names it and the nearest.

    Args:
        given: The file's parameters; those of `/**` go to each node that has them.
        below: What holds already; of plug-ins that the file replaces nothing is kept.
        specs: All nodes there are.
    """
    nodes = {spec.name: spec for spec in specs}
    given = merged(*({_RENAMED_NODES.get(name, name): v} for name, v in given.items()))
    result, taken = merged(below), set[str]()
    notes, problems = _strangers(given, nodes)
    everywhere = {k: v for k, v in given.get(EVERY_NODE, {}).items() if k != "use_sim_time"}
    for name in nodes if everywhere else [name for name in nodes if name in given]:
        values, left, unknown = _as_ours(name, given.get(name, {}), below.get(name, {}))
        problems += [f"{name}: {problem}" for problem in unknown]
        own = _own_keys(nodes[name], _over(result, name, {**everywhere, **values}))
        mine = {key: value for key, value in everywhere.items() if key in own}
        taken.update(mine)
        foreign = [key for key, value in values.items() if _foreign(name, key, value, own)]
        kept = {k: v for k, v in {**mine, **values}.items() if k not in foreign}
        whole = _over(result, name, kept)
        result[name] = {k: v for k, v in whole.items() if k in own or k in kept}
        notes += [f"{name}: {', '.join([*foreign, *left])}"] if foreign or left else []
    for key in (key for key in everywhere if key not in taken):
        if any(known_elsewhere(name, key) for name in nodes):
            notes.append(f"{EVERY_NODE}: {key}")
        else:
            valid = {k for spec in nodes.values() for k in _own_keys(spec, {})}
            problems.append(f"{EVERY_NODE}: no node has '{key}'; {nearest(key, valid)}")
    return Understood(result, notes, problems)


def _strangers(given: Parameters, nodes: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return a note or a problem for each node that we do not have."""
    names = [name for name in given if name not in nodes and name != EVERY_NODE]
    notes = [f"{name}: there is no such node here" for name in names if known_node(name)]
    return notes, unknown_nodes([name for name in names if not known_node(name)], nodes)


def _as_ours(name: str, given: dict[str, Any], below: dict[str, Any]) -> Layers:
    """Return a node's values by our names: of classes, of keys that moved, of layers."""
    values = {}
    for key, value in given.items():
        ours = _RENAMED.get(name, {}).get(key, key)
        if key.endswith("plugin") and isinstance(value, str):
            value = canonical(value).replace("nav2_recoveries::", "nav2_behaviors::")
            value = value if ours == key else [value]
        if isinstance(value, str):
            value = _OLDER.get((name, key), {}).get(value, value)
        values[ours] = value
    if name == "collision_monitor":
        values = _zones_as_ours(values)
    values.pop("use_sim_time", None)
    return layers_as_ours(values, below) if name in COSTMAPS else Layers(values, [], [])


def _zones_as_ours(values: dict[str, Any]) -> dict[str, Any]:
    """Return a collision monitor's values with zones as Nav2 has them since Iron."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        zone, _, last = key.rpartition(".")
        if last == "max_points" and isinstance(value, int):
            found[f"{zone}.min_points"] = value + 1
        elif last == "points" and isinstance(value, list):
            pairs = zip(value[::2], value[1::2], strict=False)
            found[key] = str([list(pair) for pair in pairs])
        else:
            found[key] = value
    return found


def _over(below: Parameters, name: str, values: dict[str, Any]) -> dict[str, Any]:
    return merged({name: below.get(name, {})}, {name: values})[name]


def _own_keys(spec: NodeSpec, values: dict[str, Any]) -> set[str]:
    """Return the keys that a node has, given its values.

    Those below a plug-in of no known class count: the node's own check speaks of the class.
    """
    left = dict(values)
    config = shaped(node_class(spec).Config, left, "", [])
    return {*infos(config), *(values.keys() - left.keys())}


def _foreign(name: str, key: str, value: Any, own: set[str]) -> bool:
    """Tell whether a parameter, or its value, is others' alone."""
    return known_value(name, key, value) or (key not in own and known_elsewhere(name, key))
