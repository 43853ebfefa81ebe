"""ROS parameter files: read, merged, split by node."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError, nearest
from arjuna_core.files.shipped import shipped_file
from arjuna_core.files.yaml_file import read_yaml

Parameters = dict[str, dict[str, Any]]
_KEY = "ros__parameters"
_ROS1 = "a file of ROS 1: 'python -m bringup params convert FILE'"
EVERY_NODE = "/**"
_CLASS = (".plugin", ".action_type")  # what a plug-in is of


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
    _collect(path, document, "", found)
    return found


def _collect(path: Path, item: Any, name: str, found: Parameters) -> None:
    """Walk namespaces down to `ros__parameters`."""
    if not isinstance(item, Mapping):
        problem = f"expected 'node: {{{_KEY}: {{name: value}}}}', got {item!r}; {_ROS1}"
        raise InputFileError(path, problem, name or None)
    for key, value in item.items():
        if key != _KEY:
            _collect(path, value, f"{name}/{key}".strip("/") if key != EVERY_NODE else key, found)
            continue
        if not isinstance(value, Mapping):
            raise InputFileError(path, f"must map names to values, got {value!r}", f"{name}.{_KEY}")
        found.setdefault(name, {}).update(_dotted(value))


def _dotted(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            flat.update(_dotted(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def for_node(parameters: Parameters, name: str) -> dict[str, Any]:
    """Return one node's values, those of `/**` under its own; use_sim_time is the process's."""
    values = {**parameters.get(EVERY_NODE, {}), **parameters.get(name, {})}
    values.pop("use_sim_time", None)
    return values


def in_namespace(parameters: Parameters, namespace: str) -> Parameters:
    """Return parameters in which nodes below the robot's namespace have their plain names."""
    if not namespace:
        return parameters
    return {node.removeprefix(f"{namespace}/"): values for node, values in parameters.items()}


def unknown_nodes(given: Iterable[str], known: Iterable[str]) -> list[str]:
    """Return a sentence for each node that does not exist, with the nearest that does."""
    names = [*known, EVERY_NODE]
    return [
        f"parameters for unknown node '{name}'; {nearest(name, names)}"
        for name in given
        if name not in names
    ]


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
    return load_parameters(sorted(shipped_file("params").glob("*.yaml")))
