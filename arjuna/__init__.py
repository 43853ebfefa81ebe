"""Arjuna for scripts and notebooks: `from arjuna import Robot`, `gymnasium.make("arjuna/...")`."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bringup.client.robot import Robot

__all__ = ["Robot"]


def __getattr__(name: str) -> Any:
    """Return `Robot`; learning does without ROS, and so need not wait for it."""
    if name != "Robot":
        raise AttributeError(f"module 'arjuna' has no attribute '{name}'; valid: {__all__}")
    from bringup.client.robot import Robot

    return Robot


if find_spec("gymnasium") is not None:
    from arjuna_sim.learning import register

    register()
