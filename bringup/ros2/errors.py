"""The one error of the `ros2` command."""

from __future__ import annotations

from arjuna_core.errors import ArjunaError


class Ros2Error(ArjunaError):
    """What a command says when it fails, in ros2cli's words."""
