"""`ros2 param dump`, `load`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

import yaml
from rclpy.parameter import Parameter

from bringup.parameters.files import EVERY_NODE, load_parameters
from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.param import set_all, values


def dump(arguments: argparse.Namespace) -> None:
    """Print a node's parameters as YAML, in the form that `load` reads."""
    with Client(arguments) as client:
        node = client.find_node(arguments.node_name, arguments.include_hidden_nodes)
        found = values(client, node, arguments)
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
    """Set a node's parameters from a file.

    Raises:
        InputFileError: The file cannot be read or has another form.
        Ros2Error: It holds nothing for the node.
    """
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
        given = [Parameter(name, value=value).to_parameter_msg() for name, value in wanted.items()]
        results = set_all(client, node, given, arguments)
    for parameter, result in zip(given, results, strict=True):
        reason = f": {result.reason}" if result.reason else ""
        word, stream = ("successful", sys.stdout) if result.successful else ("failed", sys.stderr)
        stream.write(f"Set parameter {parameter.name} {word}{reason}\n")
