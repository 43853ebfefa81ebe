"""Arjuna for scripts and notebooks: `Robot`, `simulate`, `gymnasium.make("arjuna/...")`."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bringup.client.robot import Robot
    from bringup.simulated import simulate

__all__ = ["Robot", "simulate"]
_MODULES = {"Robot": "bringup.client.robot", "simulate": "bringup.simulated"}


def __getattr__(name: str) -> Any:
    """Import what is asked for; learning does without ROS, and so need not wait for it."""
    if name not in _MODULES:
        raise AttributeError(f"module 'arjuna' has no attribute '{name}'; valid: {__all__}")
    return getattr(import_module(_MODULES[name]), name)


if find_spec("gymnasium") is not None:
    from arjuna_sim.learning import register

    register()
