"""Judges of `mapping`."""

from typing import Any

import numpy as np

from arjuna_core.se2 import SE2
from bringup.demo.measures import distance_to_surfaces, explored_fraction, map_error
from bringup.homework.exercise import Mark


def covers(attempt: Any) -> Mark:
    """Judge how much of the floor is known."""
    unknown = 1.0 - explored_fraction(attempt.map(), _surfaces(attempt), SE2())
    return Mark.of(100.0 * unknown, 5.0, 50.0, "{} % of the floor are not on the map")


def exact(attempt: Any) -> Mark:
    """Judge how far what is occupied is from what is there."""
    grid = attempt.map()
    if not grid.occupied().any():
        return Mark(0.0, "nothing is occupied on the map")
    error = map_error(grid, _surfaces(attempt))
    return Mark.of(100.0 * error, 5.0, 25.0, "walls are {} cm off on the average")


def clean(attempt: Any) -> Mark:
    """Judge how much is occupied where nothing is."""
    grid = attempt.map()
    points = grid.frame.to_points(np.argwhere(grid.occupied()))
    if not len(points):
        return Mark(0.0, "nothing is occupied on the map")
    far = float((distance_to_surfaces(points, _surfaces(attempt)) > 0.3).mean())
    return Mark.of(100.0 * far, 2.0, 20.0, "{} % of what is occupied is far from any wall")


def _surfaces(attempt: Any) -> Any:
    return attempt.robot.sim.simulator.robot.surfaces()
