"""The parameters of other nodes."""

from __future__ import annotations

from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterValue
from rclpy.parameter import get_parameter_value as value_of_text
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient


def get_value(*, parameter_value: ParameterValue) -> Any:
    """Return a parameter's value, None where it is not set."""
    return parameter_value_to_python(parameter_value)


def get_parameter_value(*, string_value: str) -> ParameterValue:
    """Return the value that a text of YAML is."""
    return value_of_text(string_value)


def _asked(node: Any, node_name: str, method: str, *given: Any) -> Any:
    """Return the future of a node's answer, None where it has no parameters' services.

    The one that asks is spun until it comes.
    """
    asking = getattr(node, "node", node)
    client = AsyncParameterClient(asking, node_name)
    if not client.wait_for_services(timeout_sec=5.0):
        return None
    future = getattr(client, method)(*given)
    rclpy.spin_until_future_complete(asking, future)
    return future


def _answer(node: Any, node_name: str, method: str, *given: Any) -> Any:
    """Return a node's answer.

    Raises:
        RuntimeError: It does not answer.
    """
    future = _asked(node, node_name, method, *given)
    if future is None:
        raise RuntimeError("Wait for service timed out")
    if future.result() is None:
        problem = f"Exception while calling service of node '{node_name}': {future.exception()}"
        raise RuntimeError(problem)
    return future.result()


def call_describe_parameters(*, node: Any, node_name: str, parameter_names: Any = None) -> Any:
    return _answer(node, node_name, "describe_parameters", parameter_names or [])


def call_get_parameters(*, node: Any, node_name: str, parameter_names: Any) -> Any:
    """Return a node's answer with the values of parameters."""
    return _answer(node, node_name, "get_parameters", parameter_names)


def call_set_parameters(*, node: Any, node_name: str, parameters: Any) -> Any:
    """Set a node's parameters; return its answer, with a result for each."""
    return _answer(node, node_name, "set_parameters", parameters)


def call_list_parameters(*, node: Any, node_name: str, prefixes: Any = None) -> Any:
    """Return a future of the names of a node's parameters, None where it does not answer."""
    return _asked(node, node_name, "list_parameters", prefixes)
