"""ROS parameter files: read, merged, split by node."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from copy import deepcopy
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from arjuna_core.config import dotted
from arjuna_core.errors import InputFileError, closest
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.yaml_file import read_nodes, read_yaml

Parameters = dict[str, dict[str, Any]]
_KEY = "ros__parameters"
_ROS1 = "one of ROS 1: 'python -m bringup params convert FILE'"
_MAPPINGS = "a list of mappings, as of ROS 1, no node of ROS 2 reads: name each, as filter1: {...}"
_OTHERS = {
    "image": "a map: 'nav --map FILE', or a mask server's yaml_filename",
    "features": "a graph of routes: route_server's graph_filepath",
    "docks": "a list of docks: docking_server's dock_database",
    "waypoints": "a list of waypoints: 'tour FILE' drives to poses in the map",
    "ros_topic_name": "of ros_gz_bridge: its config_file",
    "Visualization Manager": "RViz's: 'view --config FILE'",
    "configById": "a layout of Foxglove, which 'view --foxglove' serves",
    ".lua": "of Cartographer, in whose place 'slam' maps, with slam_toolbox's parameters",
    ".xml": "XML: a behavior tree's is bt_navigator's default_nav_to_pose_bt_xml",
}
"""Files that hold no nodes' parameters: where each belongs, by its ending or a name in it."""
EVERY_NODE = "/**"
SIM_TIME = "use_sim_time"
SAFETY = ""
"""Stands for no node: by group, the lines on what keeps a robot from harm and has no effect."""
_CLASS = (".plugin", ".action_type")  # what a plug-in is of
_ANY_NAMESPACE = re.compile(r"\*+")
_PLACEHOLDER = re.compile(r"<\w+>")  # of a namespace: `<robot_namespace>/amcl`, `<PREFIX_>amcl`


class Source(NamedTuple):
    """Parameters of one origin.

    Attributes:
        name: The file, or the option of the command line.
        values: By node and dotted name; the node `/**` stands for every node.
        lines: The line of each section (name "") and name in a file.
        repeated: Each `node` and `node: name` of which a file has two values in one place.
    """

    name: str
    values: Parameters
    lines: Mapping[tuple[str, str], int] = {}
    repeated: Collection[str] = ()


def of_file(path: Path) -> Source:
    """Return the parameters of a ROS parameter file.

    Raises:
        InputFileError: It is missing, is no YAML or has another form.
    """
    return Source(str(path), load_parameters([path]), *lines_of(path))


def load_parameters(paths: Iterable[str | Path]) -> Parameters:
    """Read ROS parameter files; a later file's values win.

    Args:
        paths: YAML files of the form `node: {ros__parameters: {name: value}}`.

    Returns:
        `{node: {dotted name: value}}`; the node `/**` stands for every node.

    Raises:
        InputFileError: A file is missing, is no YAML or has another form.
    """
    return merged(*(_read(Path(path)) for path in paths))


def _read(path: Path) -> Parameters:
    document = read_yaml(path)
    if document is None:
        return {}
    found: Parameters = {}
    try:
        _collect(path, document, "", found)
    except InputFileError:
        first = document[0] if isinstance(document, list) and document else document
        names = {path.suffix, *(first if isinstance(first, Mapping) else ())}
        for kind in (text for name, text in _OTHERS.items() if name in names):
            raise InputFileError(path, f"holds no nodes' parameters; it is {kind}") from None
        raise
    return found


def _collect(path: Path, item: Any, name: str, found: Parameters) -> None:
    if item is None:  # as of a node all of whose lines are comments
        return
    if not isinstance(item, Mapping):
        problem = f"expected 'node: {{{_KEY}: {{name: value}}}}', got {item!r}; {_ROS1}"
        raise InputFileError(path, problem, name or None)
    for key, value in item.items():
        if key != _KEY:
            if hint := closest(str(key), [_KEY]):
                raise InputFileError(path, f"no node's parameters stand below '{key}'{hint}", name)
            _collect(path, value, _below(name, key), found)
            continue
        if not isinstance(value, Mapping | None):
            raise InputFileError(path, f"must map names to values, got {value!r}", f"{name}.{_KEY}")
        values = dotted(value or {})
        for one, held in values.items():
            if isinstance(held, list) and any(isinstance(each, Mapping) for each in held):
                raise InputFileError(path, _MAPPINGS, f"{name}.{one}")
        found.setdefault(name, {}).update(values)


def _below(name: str, key: str) -> str:
    return key if key == EVERY_NODE else f"{name}/{key}".strip("/")


def lines_of(path: Path) -> tuple[dict[tuple[str, str], int], set[str]]:
    """Return the line of each name of a file that `load_parameters` has read, by node and key.

    Beside them, what stands twice in one place with other values: YAML's readers keep the last.
    """
    found: dict[tuple[str, str], int] = {}
    repeated: set[str] = set()

    def walk(item: yaml.Node | None, node: str, key: str, inside: bool) -> None:
        before: dict[str, Any] = {}
        for name, value in item.value if isinstance(item, yaml.MappingNode) else ():
            below = f"{key}.{name.value}" if key else str(name.value)
            if before.get(name.value, value.value) != value.value:
                section = node if name.value == _KEY else _below(node, name.value)
                repeated.add(f"{node}: {below}" if inside else section)
            before[name.value] = value.value
            if inside:
                found[node, below] = name.start_mark.line + 1
                walk(value, node, below, inside)
            elif name.value == _KEY:
                walk(value, node, "", True)
            else:
                below = _below(node, name.value)
                found[below, ""] = name.start_mark.line + 1
                walk(value, below, "", False)

    walk(read_nodes(path), "", "", False)
    return found, repeated


def for_node(parameters: Parameters, name: str) -> dict[str, Any]:
    """Return one node's values, those of `/**` under its own; use_sim_time is the process's."""
    values = {**parameters.get(EVERY_NODE, {}), **parameters.get(name, {})}
    values.pop(SIM_TIME, None)
    return values


def sim_time_of(parameters: Parameters, names: Iterable[str]) -> bool:
    """Return whether nodes of one process take their time from /clock: what most of them say.

    Where none says it, `/**` does, and time is simulated where that does not.
    """
    said = [values[SIM_TIME] for name in names if SIM_TIME in (values := parameters.get(name, {}))]
    said = said or [parameters.get(EVERY_NODE, {}).get(SIM_TIME, True)]
    true = sum(str(value).lower() == "true" for value in said)  # launch files put it in as text
    return 2 * true >= len(said)


def node_of(name: str, known: Collection[str], namespace: str = "") -> str | None:
    """Return the node that a section of a file is of; None where there is none of the name.

    ROS' wildcards stand for any namespace, and so does a `<placeholder>` that a launch file fills.
    Where the robot has no namespace, a section of any one is taken.
    """
    tokens = _tokens(name)
    for node in known:
        own = node.split("/")
        if tokens[-len(own) :] == own and (
            not namespace or namespace_of(name, node) in ("", namespace)
        ):
            return node
    return None


def namespace_of(name: str, node: str) -> str:
    """Return the namespace in a node's section's name; none where it stands for any."""
    before = _tokens(name)[: -len(node.split("/"))]
    free = all(_ANY_NAMESPACE.fullmatch(token) for token in before)
    return "" if free else "/".join(before)


def _tokens(name: str) -> list[str]:
    return _PLACEHOLDER.sub("", name).strip("/").split("/")


def merged(*layers: Parameters) -> Parameters:
    """Return parameters in which a later layer's values win.

    Where a later layer gives a plug-in another class, nothing of the earlier one is kept.
    """
    result: Parameters = {}
    for layer in layers:
        for node, values in layer.items():
            known = result.setdefault(node, {})
            for key, value in values.items():
                if key.endswith(_CLASS) and known.get(key, value) != value:
                    _drop(known, key.rpartition(".")[0] + ".")
            known.update(values)
    return result


def _drop(values: dict[str, Any], prefix: str) -> None:
    for key in [key for key in values if key.startswith(prefix)]:
        del values[key]


def shipped_parameters() -> Parameters:
    """Return the parameters of the Arjuna robot that ship in `params/`."""
    paths = sorted(shipped_file("params").glob("*.yaml"))
    return deepcopy(_read_once(*((path, path.stat().st_mtime_ns) for path in paths)))


@lru_cache(maxsize=1)
def _read_once(*stamped: tuple[Path, int]) -> Parameters:
    """Read files as of their times: a process that makes many robots reads ours for each."""
    return load_parameters(path for path, _ in stamped)
