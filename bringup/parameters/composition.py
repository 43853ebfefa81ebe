"""Nodes made by name, so that the orchestrator imports no algorithm."""

from __future__ import annotations

import contextlib
import gc
import importlib
import inspect
from collections.abc import Iterable
from typing import Any

from arjuna_core.config import load
from arjuna_core.errors import ConfigError
from bringup.parameters.files import Parameters, for_node
from bringup.stack import MESSAGES, Group, NodeSpec


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


def warm_up(groups: Iterable[Group], also: Iterable[str] = ()) -> None:
    """Import and compile what groups of nodes stand on, for processes that are forked then.

    It starts no thread, as rclpy's own modules would. What is missing, a process misses itself.

    Args:
        groups: The groups.
        also: Further modules, which import no rclpy.
    """
    import numba

    for name in (*MESSAGES, *(core for group in groups for core in group.cores), *also):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    compiled: Any = numba.njit(_nothing)
    compiled()  # the first compiled function takes ten times as long
    inspect.getmodule(warm_up.__code__)  # the first line that rclpy logs asks every module so
    gc.collect()
    gc.freeze()  # what is shared stays shared


def _nothing() -> int:
    return 0


def problems_of(parameters: Parameters, specs: Iterable[NodeSpec]) -> list[str]:
    """Return what these nodes would refuse: keys unknown, values not valid."""
    problems: list[str] = []
    for spec in specs:
        try:
            load(node_class(spec).Config, for_node(parameters, spec.name), spec.name)
        except ConfigError as error:
            problems += error.problems
    return problems


def problems_of_change(
    before: Parameters, after: Parameters, specs: Iterable[NodeSpec]
) -> list[str]:
    """Return what those of the nodes would refuse whose parameters changed."""
    changed = [spec for spec in specs if after.get(spec.name) != before.get(spec.name)]
    return problems_of(after, changed)


def check_parameters(parameters: Parameters, groups: tuple[Group, ...]) -> None:
    """Refuse parameters that some node of these groups would refuse, before anything starts.

    Raises:
        ConfigError: Keys are unknown, or values of the wrong type or out of bounds.
    """
    problems = problems_of(parameters, [s for group in groups for s in group.nodes])
    if problems:
        raise ConfigError(*problems)
