"""Judges of `square`."""

from bringup.homework.judges import closes, finishes, stops
from bringup.homework.judges import visits as corners

__all__ = ["closes", "corners", "finishes", "stops"]
