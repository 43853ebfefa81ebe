"""Arjuna for scripts and notebooks: `from arjuna import Robot`."""

from __future__ import annotations

from bringup.client.robot import Robot

__all__ = ["Robot"]
