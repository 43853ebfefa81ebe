"""The one error with which a `ros2` command ends."""

from __future__ import annotations

from arjuna_core.errors import ArjunaError


class Ros2Error(ArjunaError):
    """A command failed, in ros2cli's words."""
