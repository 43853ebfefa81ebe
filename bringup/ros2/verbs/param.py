"""`ros2 param`."""

from __future__ import annotations

import argparse
import difflib
import re
import sys
from typing import Any

import yaml
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.parameter import get_parameter_value, parameter_value_to_python

from bringup.parameters.files import EVERY_NODE, load_parameters
from bringup.ros2.client import Client, say_failed
from bringup.ros2.errors import Ros2Error

_NAMES = {
    ParameterType.PARAMETER_NOT_SET: ("not set", "Parameter not set."),
    ParameterType.PARAMETER_BOOL: ("boolean", "Boolean value is:"),
    ParameterType.PARAMETER_INTEGER: ("integer", "Integer value is:"),
    ParameterType.PARAMETER_DOUBLE: ("double", "Double value is:"),
    ParameterType.PARAMETER_STRING: ("string", "String value is:"),
    ParameterType.PARAMETER_BYTE_ARRAY: ("byte array", "Byte values are:"),
    ParameterType.PARAMETER_BOOL_ARRAY: ("boolean array", "Boolean values are:"),
    ParameterType.PARAMETER_INTEGER_ARRAY: ("integer array", "Integer values are:"),
    ParameterType.PARAMETER_DOUBLE_ARRAY: ("double array", "Double values are:"),
    ParameterType.PARAMETER_STRING_ARRAY: ("string array", "String values are:"),
}


def list_(arguments: argparse.Namespace) -> None:
    """List the parameters of a node, or of all nodes that serve them."""
    wanted = re.compile(arguments.filter or "")
    with Client(arguments) as client:
        if arguments.node_name:
            nodes = [client.find_node(arguments.node_name, arguments.include_hidden_nodes)]
        else:
            client.discover()
            served = dict(client.node.get_service_names_and_types())
            names = sorted(set(client.nodes(arguments.include_hidden_nodes)))  # twins once
            nodes = [name for name in names if f"{name}/list_parameters" in served]
        for node in nodes:
            try:
                names = [name for name in _list(client, node, arguments) if wanted.match(name)]
                shown = _typed(client, node, names, arguments) if arguments.param_type else names
            except Ros2Error as error:
                if arguments.node_name:
                    raise
                say_failed(node, error)
                continue
            if shown and not arguments.node_name:
                print(f"{node}:")
            for line in shown:
                print(f"  {line}")


def _ask(client: Client, kind: Any, node: str, arguments: argparse.Namespace, **fields: Any) -> Any:
    service = re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()
    return client.call(kind, f"{node}/{service}", kind.Request(**fields), timeout=arguments.timeout)


def _list(client: Client, node: str, arguments: argparse.Namespace) -> list[str]:
    prefixes = list(getattr(arguments, "param_prefixes", []))
    return sorted(_ask(client, ListParameters, node, arguments, prefixes=prefixes).result.names)


def _nearest(client: Client, node: str, arguments: argparse.Namespace) -> str:
    """Return the names of a node's parameters that are near to one that it does not have."""
    name, names = arguments.parameter_name, _list(client, node, arguments)
    near = [] if name in names else difflib.get_close_matches(name, names, 3)
    return f"; the nearest to '{name}': {', '.join(near)}" if near else ""


def _typed(client: Client, node: str, names: list[str], arguments: argparse.Namespace) -> list[str]:
    found = _ask(client, DescribeParameters, node, arguments, names=names).descriptors
    return [f"{item.name} (type: {_NAMES[item.type][0]})" for item in found]


def get(arguments: argparse.Namespace) -> None:
    """Print a parameter."""
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        names = [arguments.parameter_name]
        found = _ask(client, GetParameters, node, arguments, names=names).values
        hint = "" if found else _nearest(client, node, arguments)
    if not found:
        raise Ros2Error(f"Parameter not set{hint}")
    kind, label = _NAMES[found[0].type]
    value = None if kind == "not set" else getattr(found[0], _field(kind))
    if arguments.hide_type:
        print(value)
    else:
        print(label) if value is None else print(label, value)


def _field(kind: str) -> str:
    """Return the field of a ParameterValue that holds a type of values."""
    return kind.replace("boolean", "bool").replace(" ", "_") + "_value"


def set_(arguments: argparse.Namespace) -> None:
    """Set a parameter."""
    try:
        value = get_parameter_value(arguments.value)
    except yaml.YAMLError as error:
        raise Ros2Error(f"The passed value is no YAML: {error}") from error
    _set(arguments, value, "Set parameter successful", "Setting parameter failed")


def delete(arguments: argparse.Namespace) -> None:
    """Delete a parameter."""
    done, failed = "Deleted parameter successfully", "Deleting parameter failed"
    _set(arguments, ParameterValue(), done, failed)


def _set(arguments: argparse.Namespace, value: Any, done: str, failed: str) -> None:
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        parameter = Parameter(name=arguments.parameter_name, value=value)
        (result,) = _ask(client, SetParameters, node, arguments, parameters=[parameter]).results
        hint = "" if result.successful else _nearest(client, node, arguments)
    reason = f": {result.reason}{hint}" if result.reason else hint
    stream = sys.stdout if result.successful else sys.stderr
    stream.write(f"{done if result.successful else failed}{reason}\n")


def describe(arguments: argparse.Namespace) -> None:
    """Print descriptions of parameters."""
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        names = arguments.parameter_names
        for item in _ask(client, DescribeParameters, node, arguments, names=names).descriptors:
            print("\n".join(_described(item)))


def _described(item: Any) -> list[str]:
    lines = [f"Parameter name: {item.name}", f"  Type: {_NAMES[item.type][0]}"]
    if item.description:
        lines.append(f"  Description: {item.description}")
    lines.append("  Constraints:")
    if item.read_only:
        lines.append("    Read only: true")
    for limits in [*item.floating_point_range, *item.integer_range][:1]:
        lines.append(f"    Min value: {limits.from_value}")
        lines.append(f"    Max value: {limits.to_value}")
        if limits.step:
            lines.append(f"    Step: {limits.step}")
    if item.additional_constraints:
        lines.append(f"    Additional constraints: {item.additional_constraints}")
    return lines


def dump(arguments: argparse.Namespace) -> None:
    """Print a node's parameters as YAML, in the form that `load` reads."""
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        names = _list(client, node, arguments)
        values = _ask(client, GetParameters, node, arguments, names=names).values
        if len(values) < len(names):  # a node of rclpy answers none where one is not set
            asked = (_ask(client, GetParameters, node, arguments, names=[one]) for one in names)
            values = [(*answer.values, ParameterValue())[0] for answer in asked]
    found = dict(zip(names, map(parameter_value_to_python, values), strict=True))
    found = {name: value for name, value in found.items() if value is not None}
    print(yaml.safe_dump({node: {"ros__parameters": nested(found)}}))


def nested(flat: dict[str, Any]) -> dict[str, Any]:
    """Return dotted names as dictionaries in dictionaries."""
    tree: dict[str, Any] = {}
    for name in flat:
        *groups, last = name.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[last] = flat[name]
    return tree


def load(arguments: argparse.Namespace) -> None:
    """Set a node's parameters from a file."""
    layers = load_parameters([arguments.parameter_file])
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        every = {} if arguments.no_use_wildcard else layers.get(EVERY_NODE, {})
        wanted = {**every, **layers.get(node.strip("/"), {})}
        if not wanted:
            raise Ros2Error(
                f"Param file does not contain parameters for {node},"
                f" only for nodes: {', '.join(layers) or 'none'}"
            )
        given = [
            RclpyParameter(name, value=value).to_parameter_msg() for name, value in wanted.items()
        ]
        results = _ask(client, SetParameters, node, arguments, parameters=given).results
    for parameter, result in zip(given, results, strict=True):
        reason = f": {result.reason}" if result.reason else ""
        word, stream = ("successful", sys.stdout) if result.successful else ("failed", sys.stderr)
        stream.write(f"Set parameter {parameter.name} {word}{reason}\n")
