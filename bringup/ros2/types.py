"""Interfaces by name: their Python classes, their packages and their definition files."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from ament_index_python import get_package_share_directory, get_resource, get_resources
from ament_index_python.packages import PackageNotFoundError

from arjuna_core.ros.context import add_environment_to_ament_index
from bringup.ros2.errors import Ros2Error

WORDS = {"msg": "message", "srv": "service", "action": "action"}


def interface_class(name: str, kind: str | None = None) -> Any:
    """Return the Python class of an interface.

    Args:
        name: `package/msg/Name`, or `package/Name` where the kind is known.
        kind: "msg", "srv" or "action"; None for any.

    Raises:
        Ros2Error: There is no such interface.
    """
    parts = name.split("/")
    if len(parts) == 2 and kind is not None:
        parts.insert(1, kind)
    valid = len(parts) == 3 and all(part.isidentifier() for part in parts)
    if valid and parts[1] in WORDS and kind in (None, parts[1]):
        try:
            return getattr(importlib.import_module(f"{parts[0]}.{parts[1]}"), parts[2])
        except (ModuleNotFoundError, AttributeError):
            pass  # said below
    if kind is None:
        raise Ros2Error(f"Could not find the interface '{name}'")
    raise Ros2Error(f"The passed {WORDS[kind]} type is invalid")


def nested_class(rosidl_type: Any) -> Any:
    """Return the Python class of a field's type that is a message."""
    module = importlib.import_module(".".join(rosidl_type.namespaces))
    return getattr(module, rosidl_type.name)


def packages() -> dict[str, list[str]]:
    """Return the interfaces of every package, `kind/Name`, all sorted."""
    add_environment_to_ament_index()
    return {name: interfaces_of(name) for name in sorted(get_resources("rosidl_interfaces"))}


def interfaces_of(package: str) -> list[str]:
    """Return the interfaces of a package, `kind/Name`, sorted.

    Raises:
        Ros2Error: There is no such package, or it has none.
    """
    add_environment_to_ament_index()
    try:
        content, _ = get_resource("rosidl_interfaces", package)
    except LookupError as error:
        raise Ros2Error(f"Unknown package '{package}'") from error
    lines = [line for line in content.splitlines() if line.endswith(".idl")]
    return sorted(line[: -len(".idl")] for line in lines)


def definition_file(name: str) -> Path:
    """Return the file that defines an interface.

    Args:
        name: `package/kind/Name`.

    Raises:
        Ros2Error: There is none.
    """
    parts = name.split("/")
    if len(parts) != 3:
        raise Ros2Error(f"Invalid name '{name}'. Expected three parts separated by '/'")
    add_environment_to_ament_index()
    package, kind, short = parts
    try:
        share = Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError) as error:
        raise Ros2Error(f"Unknown package '{package}'") from error
    path = share / kind / f"{short}.{kind}"
    if kind not in WORDS or not short.isidentifier() or not path.is_file():
        raise Ros2Error(f"Could not find the interface '{name}'")
    return path
