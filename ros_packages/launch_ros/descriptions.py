"""Descriptions of what an action takes: parameters, and nodes of containers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from launch_ros.parameter_descriptions import Parameter as Parameter
from launch_ros.parameter_descriptions import ParameterFile as ParameterFile
from launch_ros.parameter_descriptions import ParameterValue as ParameterValue


@dataclass(kw_only=True)
class ComposableNode:
    """A node of a container, by its package and plug-in."""

    package: Any
    plugin: Any
    name: Any = None
    namespace: Any = None
    parameters: Any = None
    remappings: Any = None
    extra_arguments: Any = None
    condition: Any = field(default=None)
