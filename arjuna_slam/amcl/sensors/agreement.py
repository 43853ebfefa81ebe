"""Agreement: what share of a scan's beams the map explains at a pose."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_slam.amcl.sensors.scan_view import ScanView
from arjuna_slam.matching.map_field import MapField

_THROUGH = 0.5  # a beam this much longer than the map allows went through an obstacle [m] ...
_OUT = 1.5  # ... as did one that came out of it so far [cells]
_SHORT = 0.5  # what a beam that ends early counts, as someone may stand there ...
_WIDE = 3.0  # that far off; nearer by, less: there someone hides more of what the map has [m]
_HALF_DIAGONAL = math.sqrt(0.5)


def share_agreeing(field: MapField, pose: SE2, view: ScanView, near: float) -> float:
    """Return the share of beams (0..1) that agree with the map at a pose.

    A beam agrees if it ends near an obstacle of the map and crossed none on its way. One that
    crossed an obstacle speaks against the pose. One that ended in the open speaks half as much, as
    people and furniture come and go, and the less the nearer it ended: what the map does not have
    counts by its width, not by the angle that it takes up, so that one who stands at the robot and
    stops half of its beams is no more than one. A beam without return counts only against the pose,
    where the map has an obstacle in its way; thus poses are told apart that end points alone do not
    tell apart.

    Args:
        field: The map.
        pose: Of the base in the map.
        view: The scan.
        near: Distance to an obstacle below which a beam hit it [m].

    Source: the likelier a short reading, the nearer: Thrun, Burgard, Fox, Probabilistic Robotics,
        2005, section 6.3 (unexpected objects).
    """
    sensor = pose @ view.T_base_sensor
    origin = field.to_grid(sensor.array()[np.newaxis])[0]
    origin[2] -= view.T_base_sensor.theta  # the beams' directions are the base's
    beams, resolution = view.many, field.frame.resolution
    return _agreement(
        field.distances, resolution, near, origin, beams.directions, beams.ranges, beams.returned
    )


@njit(cache=True)
def _agreement(
    distances: NDArray[np.float32],
    resolution: float,
    limit: float,
    origin: NDArray[np.float64],
    directions: NDArray[np.float64],
    ranges: NDArray[np.float64],
    returned: NDArray[np.bool_],
) -> float:
    height, width = distances.shape
    near, through, short = 0, 0, 0.0
    cosine, sine = math.cos(origin[2]), math.sin(origin[2])
    for i in range(len(ranges)):
        c = cosine * directions[i, 0] - sine * directions[i, 1]
        s = sine * directions[i, 0] + cosine * directions[i, 1]
        length = ranges[i] / resolution
        if _crossed(distances, resolution, origin, c, s, length):
            through += 1
        elif returned[i]:
            column = math.floor(origin[0] + c * length)
            row = math.floor(origin[1] + s * length)
            inside = 0 <= row < height and 0 <= column < width
            if inside and distances[row, column] < limit:
                near += 1
            else:
                short += min(ranges[i] / _WIDE, 1.0)
    counted = near + through + _SHORT * short
    return near / counted if counted > 0.0 else 0.0


@njit(cache=True)
def _crossed(
    distances: NDArray[np.float32],
    resolution: float,
    origin: NDArray[np.float64],
    c: float,
    s: float,
    length: float,
) -> bool:
    """Whether a ray of `length` [cells] meets an obstacle and comes out of it again.

    Free space is passed in leaps of the free distance. A ray that grazes a wall stays close to it.

    Source: Hart, Sphere tracing, The Visual Computer, 1996.
    """
    height, width = distances.shape
    at, hit = 0.0, np.inf
    while at < length:
        column = math.floor(origin[0] + c * at)
        row = math.floor(origin[1] + s * at)
        if not (0 <= row < height and 0 <= column < width):
            at += 1.0
            continue
        free = distances[row, column] / resolution
        if hit < np.inf:
            if free > _OUT or at - hit > _THROUGH / resolution:
                return True
            at += 1.0
        elif free == 0.0:
            hit = at
            at += 1.0
        else:
            at += max(free - 2.0 * _HALF_DIAGONAL, 1.0)
    return False
