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

    def __post_init__(self) -> None:
        self.__package, self.__parameters = self.package, self.parameters
        self.node_plugin = self.__node_plugin = self.plugin
        self.node_name = self.__node_name = self.name
        self.node_namespace = self.__node_namespace = self.namespace
        self.__remappings = self.remappings
