"""A list of entities to launch."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launch.action import Entities, LaunchDescriptionEntity
from launch.declare_launch_argument import DeclareLaunchArgument
from launch.launch_context import LaunchContext


class LaunchDescription(LaunchDescriptionEntity):
    """A list of entities to launch, and the arguments that they declare."""

    def __init__(self, initial_entities: Iterable[LaunchDescriptionEntity] | None = None) -> None:
        self.entities: list[LaunchDescriptionEntity] = list(initial_entities or ())

    def add_action(self, action: LaunchDescriptionEntity) -> None:
        self.entities.append(action)

    add_entity = add_action

    def visit(self, context: LaunchContext) -> Entities:
        return list(self.entities)

    def children(self) -> Iterable[LaunchDescriptionEntity]:
        return self.entities

    def get_launch_arguments(
        self, conditional_inclusion: bool = False
    ) -> list[DeclareLaunchArgument]:
        """Return the arguments that it and what it includes declare, each name once."""
        found: dict[str, DeclareLaunchArgument] = {}

        def walk(entity: Any) -> None:
            if isinstance(entity, DeclareLaunchArgument):
                found.setdefault(entity.name, entity)
            for child in entity.children():
                walk(child)

        walk(self)
        return list(found.values())
