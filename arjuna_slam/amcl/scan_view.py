"""The readings of one scan, in the form that the filter's parts use."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats, Singles
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.matching.map_field import MapField
from arjuna_slam.matching.surface import wall_normals

_SPARSE = 0.2  # share of beams from afar below which the map is not searched for them
BEAMS_MIN = 10  # fewer beams with a return say nothing about where the robot is


@dataclass(frozen=True)
class Beams:
    """Beams of a scan that say something: NaN and too short ones do not."""

    directions: Floats  # unit vectors in the base frame, `(B, 2) float64`
    ranges: Floats  # `(B,) float64` [m]; a beam without return carries the longest range
    returned: Bools  # which beams returned, `(B,) bool`
    endpoints: Floats  # of the beams that returned, `(M, 2) float64` in the base frame [m]
    normals: Floats  # of the walls there, `(M, 2) float64`; zero where there is none


@dataclass(frozen=True)
class ScanView:
    """One scan."""

    stamp: float  # [s]
    range_max: float  # the longest range used [m]
    T_base_sensor: SE2  # pose of the sensor in the base frame
    many: Beams  # beams for scan matching, from all around
    few: Beams  # at most `max_beams`, for the particles

    @staticmethod
    def of(scan: Scan, config: AmclConfig) -> ScanView:
        """Read a scan; few beams are taken at even steps over the sweep, as nav2_amcl does."""
        low = max(config.laser_min_range, scan.range_min)
        high = scan.range_max
        if config.laser_max_range > 0.0:
            high = min(config.laser_max_range, high)
        ranges = np.minimum(scan.ranges, high)
        mount = scan.T_base_sensor
        directions = _unit(scan.angles + mount.theta)
        if scan.motion != IDENTITY:
            ranges, directions = _deskewed(ranges, scan.rays(), mount, high)
        step = max(1, (len(ranges) - 1) // (config.max_beams - 1))
        enough = 180  # beams; more match no better, as the errors of neighbours are the same
        stride = max(1, math.ceil(len(ranges) / enough))

        def beams(each: int) -> Beams:
            some = np.ascontiguousarray(ranges[::each])
            directions_used = np.ascontiguousarray(directions[::each])
            usable = some >= low  # NaN is not
            numbers = np.flatnonzero(usable)
            if not usable.all():
                some, directions_used = some[usable], directions_used[usable]
            returned = some < high
            lengths, numbers = some[returned], numbers[returned]
            ends = directions_used[returned] * lengths[:, np.newaxis]
            ends += (mount.x, mount.y)
            normals = wall_normals(ends, numbers, lengths, each * scan.angle_increment, mount)
            return Beams(directions_used, some, returned, ends, normals)

        return ScanView(scan.stamp, high, mount, beams(stride), beams(step))

    @property
    def blind(self) -> bool:
        """True if too few beams returned to locate the robot."""
        return len(self.many.endpoints) < BEAMS_MIN

    @property
    def returned(self) -> float:
        """The share of the beams that returned."""
        return len(self.many.endpoints) / max(len(self.many.ranges), 1)

    @property
    def sparse(self) -> bool:
        """True if so few beams returned from afar that they fit anywhere.

        As of one thing in the open, or of people who stand about the robot.
        """
        return bool(self._from_afar.sum() < _SPARSE * len(self.many.ranges))

    @cached_property
    def _from_afar(self) -> Bools:
        """Which endpoints are no one's beside the robot, `(M,) bool`."""
        ends, mount = self.many.endpoints, self.T_base_sensor
        beside = 1.0  # [m]; who stands so near hides much of the map
        return np.hypot(ends[:, 0] - mount.x, ends[:, 1] - mount.y) > beside

    @property
    def readings(self) -> list[tuple[Floats, Floats]]:
        """Ends of beams to match and their normals, each `(M, 2) float64` in the base frame [m].

        All come first. Where many end near by, which may be walls or a crowd, the others come as a
        second reading.
        """
        ends, normals, far = self.many.endpoints, self.many.normals, self._from_afar
        hidden_min = 0.2  # share of the beams from which the crowd may matter
        hidden = BEAMS_MIN <= far.sum() < (1.0 - hidden_min) * len(ends)
        return [(ends, normals), *([(ends[far], normals[far])] if hidden else [])]


def _unit(bearings: Floats) -> Floats:
    return np.column_stack((np.cos(bearings), np.sin(bearings)))


def _deskewed(ranges: Floats, rays: Floats, mount: SE2, high: float) -> tuple[Floats, Floats]:
    """Return ranges and directions as seen from where the sensor was at beam 0."""
    directions = _unit(rays[:, 2])
    far = ~(np.isfinite(ranges) & (ranges < high))
    lengths = np.where(far, 1.0, np.maximum(ranges, 1e-6))
    offsets = rays[:, :2] - (mount.x, mount.y) + directions * lengths[:, np.newaxis]
    seen = np.hypot(offsets[:, 0], offsets[:, 1])
    directions = np.where(far[:, np.newaxis], directions, offsets / seen[:, np.newaxis])
    return np.where(far, ranges, np.minimum(seen, np.nextafter(high, 0.0))), directions


_DEEP = 0.5  # a beam this much longer than the map allows went through an obstacle [m] ...
_OUT = 1.5  # ... as did one that came out of it so far [cells]
_SHORT = 0.5  # what a beam that ends early counts, as someone may stand there ...
_WIDE = 3.0  # that far off; nearer by, less: there someone hides more of what the map has [m]
_HALF_DIAGONAL = math.sqrt(0.5)
_NOTHING, _INTO, _THROUGH = 0, 1, 2  # what a ray meets


def known_ends(field: MapField, pose: SE2, view: ScanView) -> int:
    """Return the number of beams that returned from what the map knows, at a pose of the base.

    The others end in the unknown, and nothing that the map has stands before them.
    """
    beams, origin = view.many, _origin(field, pose, view)
    some = beams.returned
    return int(
        _known(
            field.distances,
            field.unknown,
            field.frame.resolution,
            origin,
            beams.directions[some],
            beams.ranges[some],
        )
    )


def share_agreeing(
    field: MapField, pose: SE2, view: ScanView, near: float, doubt_unknown: bool = False
) -> float:
    """Return the share of beams (0..1) that agree with the map at a pose of the base.

    A beam agrees if it ends nearer than `near` [m] to an obstacle and crossed none before. One that
    crossed an obstacle speaks against the pose. One that ended in the open speaks half as much, as
    people and furniture come and go, and the less the nearer it ended: what the map does not have
    counts by its width, not by the angle that it takes up, so that one who stands at the robot and
    stops half of its beams is no more than one. A beam without return counts only against the pose,
    where the map has an obstacle along it; which distinguishes poses that end points alone do not
    separate. A beam that ends in the unknown says nothing, or, with `doubt_unknown`, as much as one
    that ended in the open: it is no evidence for a pose that nothing else speaks for.

    Source: the likelier a short reading, the nearer: Thrun, Burgard, Fox, Probabilistic Robotics,
        2005, section 6.3 (unexpected objects).
    """
    beams = view.many
    return _agreement(
        field.distances,
        field.unknown,
        field.frame.resolution,
        near,
        _origin(field, pose, view),
        beams.directions,
        beams.ranges,
        beams.returned,
        doubt_unknown,
    )


def _origin(field: MapField, pose: SE2, view: ScanView) -> Floats:
    sensor = pose @ view.T_base_sensor
    origin: Floats = field.to_grid(sensor.array()[np.newaxis])[0]
    origin[2] -= view.T_base_sensor.theta  # the beams' directions are the base's
    return origin


@njit(cache=True)
def _known(
    distances: Singles,
    unknown: Bools,
    resolution: float,
    origin: Floats,
    directions: Floats,
    ranges: Floats,
) -> int:
    known = 0
    cosine, sine = math.cos(origin[2]), math.sin(origin[2])
    for i in range(len(ranges)):
        c = cosine * directions[i, 0] - sine * directions[i, 1]
        s = sine * directions[i, 0] + cosine * directions[i, 1]
        length = ranges[i] / resolution
        seen = _is_known(unknown, origin[0] + c * length, origin[1] + s * length)
        known += seen or _crossing(distances, resolution, origin, c, s, length) != _NOTHING
    return known


@njit(cache=True)
def _is_known(unknown: Bools, x: float, y: float) -> bool:
    column, row = math.floor(x), math.floor(y)
    inside = 0 <= row < unknown.shape[0] and 0 <= column < unknown.shape[1]
    return inside and not unknown[row, column]


@njit(cache=True)
def _agreement(
    distances: Singles,
    unknown: Bools,
    resolution: float,
    limit: float,
    origin: Floats,
    directions: Floats,
    ranges: Floats,
    returned: Bools,
    doubt_unknown: bool,
) -> float:
    height, width = distances.shape
    near, through, short = 0, 0, 0.0
    cosine, sine = math.cos(origin[2]), math.sin(origin[2])
    for i in range(len(ranges)):
        c = cosine * directions[i, 0] - sine * directions[i, 1]
        s = sine * directions[i, 0] + cosine * directions[i, 1]
        length = ranges[i] / resolution
        crossing = _crossing(distances, resolution, origin, c, s, length)
        if crossing == _THROUGH:
            through += 1
        elif returned[i]:
            x, y = origin[0] + c * length, origin[1] + s * length
            column, row = math.floor(x), math.floor(y)
            inside = 0 <= row < height and 0 <= column < width
            if inside and distances[row, column] < limit:
                near += 1
            elif doubt_unknown or crossing == _INTO or _is_known(unknown, x, y):
                short += min(ranges[i] / _WIDE, 1.0)
    counted = near + through + _SHORT * short
    return near / counted if counted > 0.0 else 0.0


@njit(cache=True)
def _crossing(
    distances: Singles, resolution: float, origin: Floats, c: float, s: float, length: float
) -> int:
    """Return whether a ray of `length` [cells] meets nothing, an obstacle, or leaves it again.

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
            if free > _OUT or at - hit > _DEEP / resolution:
                return _THROUGH
            at += 1.0
        elif free == 0.0:
            hit = at
            at += 1.0
        else:
            at += max(free - 2.0 * _HALF_DIAGONAL, 1.0)
    return _INTO if hit < np.inf else _NOTHING
