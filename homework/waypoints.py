"""Judges of `waypoints`."""

from bringup.homework.judges import closes, finishes, stops
from bringup.homework.judges import visits as points

__all__ = ["closes", "finishes", "points", "stops"]
