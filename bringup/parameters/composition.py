"""Nodes made by name, so that the orchestrator imports no algorithm."""

from __future__ import annotations

import importlib
from typing import Any

from arjuna_core.config import load
from bringup.parameters.files import Parameters, check_nodes, for_node
from bringup.stack import Group, NodeSpec


def node_class(spec: NodeSpec) -> Any:
    """Import a node's class."""
    return getattr(importlib.import_module(spec.module), spec.cls)


def create_node(process: Any, spec: NodeSpec, parameters: Parameters) -> Any:
    """Make one node in a process.

    Raises:
        ConfigError: A parameter is unknown, of the wrong type or out of bounds.
    """
    namespace, _, name = spec.name.rpartition("/")
    values = for_node(parameters, spec.name)
    return node_class(spec)(process, values, name=name, namespace=namespace)


def check_parameters(parameters: Parameters, groups: tuple[Group, ...], known: list[str]) -> None:
    """Refuse parameters that some node of these groups would refuse, before anything starts.

    Raises:
        ConfigError: A node or key is unknown, or a value of the wrong type or out of bounds.
    """
    check_nodes(parameters, known)
    for group in groups:
        for spec in group.nodes:
            load(node_class(spec).Config, for_node(parameters, spec.name), spec.name)
