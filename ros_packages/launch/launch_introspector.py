"""A launch description as text for people."""

from __future__ import annotations

from launch.action import LaunchDescriptionEntity


class LaunchIntrospector:
    """Writes what a launch description holds."""

    def format_launch_description(self, launch_description: LaunchDescriptionEntity) -> str:
        """Return a line for each entity, those that it holds below it."""

        def lines(entity: LaunchDescriptionEntity, depth: int) -> list[str]:
            below = [line for one in entity.children() for line in lines(one, depth + 1)]
            return [f"{'    ' * depth}{entity.describe()}", *below]

        return "\n".join(lines(launch_description, 0))
