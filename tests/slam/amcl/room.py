"""A room of 9.8 m with four boxes, a map of it, and a robot that wanders there."""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.grid import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from tests.slam import slam_room
from tests.slam.slam_room import box

WALL = 4.9
BOXES = ((2.5, 0.0), (-1.5, 3.0), (-2.0, -2.5), (3.0, -3.0))
HALF = 0.25
RANGE_MAX = 12.0
RESOLUTION = 0.05
DT = 0.1
ORIGIN = SE2(-5.187, -5.213, 0.0)  # aligned with nothing


Boxes = tuple[tuple[float, float], ...]


def segments(boxes: Boxes = BOXES) -> Floats:
    """Return the room's walls and boxes, `(N, 4)` of x0, y0, x1, y1 [m]."""
    around = [(x - HALF, y - HALF, x + HALF, y + HALF) for x, y in boxes]
    return np.concatenate([box(*corners) for corners in [(-WALL, -WALL, WALL, WALL), *around]])


def ranges_at(pose: SE2, count: int, boxes: Boxes = BOXES) -> Floats:
    """Return the true ranges [m] of `count` beams around a pose."""
    angles = -math.pi + np.arange(count) * 2.0 * math.pi / count
    return slam_room.ranges_at(segments(boxes), pose, angles)


def scan_at(
    pose: SE2, stamp: float, rng: np.random.Generator, count: int = 360, boxes: Boxes = BOXES
) -> Scan:
    """A scan at a pose with a deviation of 1 cm."""
    ranges = ranges_at(pose, count, boxes) + rng.normal(0.0, 0.01, count)
    return Scan(ranges, -math.pi, 2.0 * math.pi / count, 0.1, RANGE_MAX, stamp)


def room_map(origin: SE2 = ORIGIN, size: int = 210, boxes: Boxes = BOXES) -> OccupancyGrid:
    """The map a mapper would make: one cell of surface, unknown behind it."""
    frame = GridFrame(RESOLUTION, size, size, origin)
    data = np.full(frame.shape, UNKNOWN, np.int8)
    rows, columns = np.indices(frame.shape)
    centres = frame.to_points(np.column_stack((rows.ravel(), columns.ravel())))
    inside = (np.abs(centres) < WALL).all(axis=1)
    for centre in boxes:
        inside &= ~(np.abs(centres - centre) < HALF).all(axis=1)
    data.ravel()[inside] = FREE
    along = np.arange(-WALL, WALL, 0.005)
    surfaces = [_square(along, WALL)]
    edge = np.arange(-HALF, HALF, 0.005)
    surfaces += [_square(edge, HALF) + centre for centre in boxes]
    cells = frame.to_cells(np.vstack(surfaces))
    data[cells[:, 0], cells[:, 1]] = OCCUPIED
    return OccupancyGrid(frame, data)


def _square(along: Floats, half: float) -> Floats:
    side = np.full_like(along, half)
    pairs = ((along, side), (along, -side), (side, along), (-side, along))
    return np.vstack([np.column_stack(pair) for pair in pairs])


def is_clear(x: float, y: float, margin: float = 0.4) -> bool:
    """Return whether a position has `margin` [m] around it."""
    if max(abs(x), abs(y)) > WALL - margin:
        return False
    return all(max(abs(x - bx), abs(y - by)) > HALF + margin for bx, by in BOXES)


def random_pose(rng: np.random.Generator) -> SE2:
    """A clear pose anywhere in the room."""
    while True:
        x, y = rng.uniform(-WALL, WALL, 2)
        if is_clear(x, y):
            return SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))


class Robot:
    """Wanders through the room, turning where it would hit something.

    Odometry errs by 5 % in translation and 8 % in rotation: half a scale error of the whole run,
    half chance of each step.
    """

    def __init__(
        self, rng: np.random.Generator, pose: SE2 | None = None, boxes: Boxes = BOXES
    ) -> None:
        self._rng = rng
        self._boxes = boxes
        self._scale = 1.0 + rng.choice([-1.0, 1.0], 3) * (0.05, 0.05, 0.08)
        self._turn = 0.0
        self.pose = pose or random_pose(rng)
        self.odometry = SE2()
        self.now = 0.0

    def step(self, speed: float = 0.4, spin: float = 0.5) -> Scan:
        """Advance one period and return the scan at its end."""
        ahead = self.pose @ SE2(0.3, 0.0, 0.0)
        if self._turn == 0.0 and is_clear(ahead.x, ahead.y, 0.3):
            turn = float(self._rng.normal(0.0, 0.3))
            self.move(SE2(speed * DT, 0.0, turn * DT))
        else:
            if self._turn == 0.0:
                self._turn = float(self._rng.uniform(0.8, 2.5)) * float(self._rng.choice([-1, 1]))
            step = math.copysign(min(spin * DT, abs(self._turn)), self._turn)
            self._turn = 0.0 if abs(self._turn) < spin * DT else self._turn - step
            self.move(SE2(0.0, 0.0, step))
        return self.scan()

    def move(self, delta: SE2) -> None:
        """Move by a step in the robot's frame; the odometry sees it with its errors."""
        self.pose = self.pose @ delta
        noise = self._rng.normal(0.0, (0.05, 0.05, 0.08))
        seen = delta.array() * (self._scale + noise)
        self.odometry = self.odometry @ SE2.from_array(seen)
        self.now += DT

    def scan(self) -> Scan:
        """A scan here and now."""
        return scan_at(self.pose, self.now, self._rng, boxes=self._boxes)


def error(a: SE2, b: SE2) -> tuple[float, float]:
    """Distance [m] and difference of heading [rad] of two poses."""
    return a.distance(b), abs(wrap(a.theta - b.theta))
