"""The services of the graph, and their classes."""

from __future__ import annotations

from typing import Any

from rclpy.expand_topic_name import expand_topic_name
from rosidl_runtime_py.utilities import get_service

from bringup.ros2.client import Names, visible_types


def get_service_names_and_types(*, node: Any, include_hidden_services: bool = False) -> Names:
    """Return the services that a node sees, each with its types."""
    return visible_types(node.get_service_names_and_types(), include_hidden_services)


def get_service_names(*, node: Any, include_hidden_services: bool = False) -> list[str]:
    pairs = get_service_names_and_types(node=node, include_hidden_services=include_hidden_services)
    return [name for name, _ in pairs]


def get_service_class(node: Any, service: str, *_: Any, **__: Any) -> Any:
    """Return a service's class, None where nobody offers it; it does not wait for one."""
    name = expand_topic_name(service, node.get_name(), node.get_namespace())
    types = dict(node.get_service_names_and_types()).get(name, ())
    return get_service(types[0]) if types else None
