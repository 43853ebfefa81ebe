"""Interfaces by the names of their types, `package/msg/Name`."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from bringup.ros2.errors import Ros2Error
from bringup.ros2.types import definition_file, interface_class, packages


def _found(identifier: str, kind: str | None) -> Any:
    try:
        return interface_class(identifier, kind)
    except Ros2Error as error:
        valid = f"valid: package/{kind or 'msg'}/Name of a package that is installed"
        raise ValueError(f"'{identifier}' is no such interface; {valid}") from error


get_message = partial(_found, kind="msg")
"""Return the class of a message; ValueError if there is none."""
get_service = partial(_found, kind="srv")
"""The same of a service."""
get_action = partial(_found, kind="action")
"""The same of an action."""
get_interface = partial(_found, kind=None)
"""The same of whatever is of that name."""


def get_interface_path(interface_name: str) -> str:
    return str(definition_file(interface_name))


def is_message(interface: Any) -> bool:
    return hasattr(interface, "_fields_and_field_types")


def is_service(interface: Any) -> bool:
    return hasattr(interface, "Request") and hasattr(interface, "Response")


def is_action(interface: Any) -> bool:
    return hasattr(interface, "Goal") and hasattr(interface, "Feedback")


def get_interfaces(package_names: Iterable[str] = (), kind: str = "") -> dict[str, list[str]]:
    """Return the interfaces of packages, of all where none are named, as `kind/Name`."""
    wanted = set(package_names)
    return {
        package: [name for name in names if name.startswith(kind)]
        for package, names in packages().items()
        if package in wanted or not wanted
    }


get_message_interfaces = partial(get_interfaces, kind="msg/")
"""Return the messages of packages."""
get_service_interfaces = partial(get_interfaces, kind="srv/")
"""Return the services of packages."""
get_action_interfaces = partial(get_interfaces, kind="action/")
"""Return the actions of packages."""
