"""Config dataclasses as ROS parameters: declared, described, checked and changed at run time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from arjuna_core.config import ParamInfo, flatten, infos, load
from arjuna_core.errors import ConfigError


class ParameterBinding:
    """Keeps a node's `config`, a dataclass, and its parameters the same.

    Args:
        node: The node, whose attribute `config` is set.
        cls: The frozen dataclass; its defaults are the parameters'.
        values: Values that differ from the defaults, nested or dotted.
        on_change: Called with the new config after parameters were set at run time.

    Raises:
        ConfigError: A key is unknown, or a value of the wrong type or out of bounds.
    """

    def __init__(
        self, node: Any, cls: type[Any], values: Mapping[str, Any], on_change: Callable[[Any], None]
    ) -> None:
        self._node, self._cls = node, cls
        self._on_change = on_change
        node.config = load(cls, values, node.get_name())
        known = infos(type(node.config))
        for name, value in flatten(node.config).items():
            node.declare_parameter(name, _to_ros(value), _descriptor(value, known[name]))
        node.add_on_set_parameters_callback(self._check)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        node = self._node
        flat = flatten(node.config)
        ours = {item.name: _from_ros(item, flat) for item in parameters if item.name in flat}
        if not ours:
            return SetParametersResult(successful=True)
        before, taken = node.config, False
        try:
            node.config = load(self._cls, {**flat, **ours})
            self._on_change(node.config)
            taken = True
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        finally:
            if not taken:
                node.config = before
        return SetParametersResult(successful=True)


def describe_sim_time(node: Node) -> None:
    """Describe the parameter that rclpy declares without a word, and keep it as it is.

    All nodes of a process have one clock; rclpy's own would hear any topic clock unchecked.
    """
    name, now = "use_sim_time", node.get_parameter("use_sim_time").value
    text = "Whether time comes from the topic clock, as a simulator's does, or from the system."
    node.set_descriptor(
        name, ParameterDescriptor(description=text, type=ParameterType.PARAMETER_BOOL)
    )
    reason = f"{name} is {str(now).lower()} for all nodes of this process; set it at their start"

    def check(given: list[Parameter]) -> SetParametersResult:
        same = all(one.value == now for one in given if one.name == name)
        return SetParametersResult(successful=same, reason="" if same else reason)

    node.add_on_set_parameters_callback(check)


def _to_ros(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else "" if value is None else value


def _from_ros(parameter: Parameter, flat: Mapping[str, Any]) -> Any:
    value = parameter.value
    if value == "" and flat[parameter.name] is None:
        return None
    several = hasattr(value, "__iter__") and not isinstance(value, str | bytes)
    return tuple(value) if several else value


def _descriptor(value: Any, info: ParamInfo) -> ParameterDescriptor:
    unit = f" [{info.unit}]" if info.unit else ""
    descriptor = ParameterDescriptor(
        description=info.description + unit,
        read_only=info.read_only,
        additional_constraints=", ".join(str(choice) for choice in info.choices),
        dynamic_typing=value is None or value == (),
    )
    low, high = info.bounds
    if isinstance(value, float):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high))
        ]
    elif type(value) is int:
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    return descriptor
