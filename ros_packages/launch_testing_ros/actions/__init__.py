"""Actions for tests of nodes."""

from __future__ import annotations

from typing import Any

from launch.action import Action


class EnableRmwIsolation(Action):
    """Does nothing: each launch test has a ROS domain of its own."""

    def execute(self, context: Any) -> None:
        """Do nothing."""
