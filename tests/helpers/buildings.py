"""Seeded buildings as grids, each with a net of roads through it whose parts look alike.

Five kinds: rings of corridors, corridors side by side, halls with pillars, doors all alike, and
offices with rooms that are entered.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

RESOLUTION = 0.05
_BORDER = 2.0  # of solid wall around everything [m]
_DOOR_STEP_MIN = 4.0
Point = tuple[float, float]


@dataclass
class Building:
    """Walls, and a net of roads between points.

    Attributes:
        blocked: Cells of `RESOLUTION` metres, `(H, W) bool`; row 0 is at y = 0.
        points: Ends of the roads, from the outer corner of cell (0, 0) [m].
        roads: Pairs of points between which a robot drives straight.
    """

    blocked: NDArray[np.bool_]
    points: list[Point] = field(default_factory=list)
    roads: list[tuple[int, int]] = field(default_factory=list)

    def clear(self, x0: float, y0: float, x1: float, y1: float, *, solid: bool = False) -> None:
        """Make a rectangle free, or solid; what lies beyond the building's rim stays [m]."""
        rim = _BORDER / 2.0
        height, width = (RESOLUTION * size for size in self.blocked.shape)
        rows = slice(_cell(max(min(y0, y1), rim)), _cell(min(max(y0, y1), height - rim)))
        columns = slice(_cell(max(min(x0, x1), rim)), _cell(min(max(x0, x1), width - rim)))
        self.blocked[rows, columns] = solid

    def point(self, x: float, y: float) -> int:
        """Add an end of roads [m] and return its number; one that is there already is shared."""
        for k, (other_x, other_y) in enumerate(self.points):
            if math.hypot(x - other_x, y - other_y) < 0.3:
                return k
        self.points.append((x, y))
        return len(self.points) - 1

    def add_road(self, a: Point, b: Point) -> None:
        """Add a road."""
        first, last = self.point(*a), self.point(*b)
        if first != last:
            self.roads.append((first, last))

    def corridor(self, a: Point, b: Point, width: float) -> None:
        """Free a straight corridor, along x or y, and drive along it."""
        half = 0.5 * width
        low, high = np.minimum(a, b) - half, np.maximum(a, b) + half
        self.clear(low[0], low[1], high[0], high[1])
        self.add_road(a, b)

    def net(self, xs: Sequence[float], ys: Sequence[float], width: float) -> None:
        """Free corridors at the given positions along x and y, each crossing all of the others."""
        for y in ys:
            for a, b in pairwise(xs):
                self.corridor((a, y), (b, y), width)
        for x in xs:
            for a, b in pairwise(ys):
                self.corridor((x, a), (x, b), width)

    @property
    def length(self) -> float:
        """Of all roads [m]."""
        return sum(math.dist(self.points[a], self.points[b]) for a, b in self.roads)


def _cell(value: float) -> int:
    return round(value / RESOLUTION)


def _solid(width: float, height: float) -> Building:
    return Building(np.ones((_cell(height), _cell(width)), np.bool_))


def _steps(rng: np.random.Generator, low: float, high: float, step: float) -> list[float]:
    """Return positions from low to high about a step apart, jittered a little."""
    count = max(2, 1 + round((high - low) / step))
    marks = np.linspace(low, high, count)
    marks[1:-1] += rng.uniform(-0.15, 0.15, count - 2) * (marks[1] - marks[0])
    return [float(mark) for mark in marks]


def rings(rng: np.random.Generator, width: float, height: float) -> Building:
    """Corridors around blocks, doorways of every width at every distance along them."""
    return _blocks(rng, width, height, alike=False)


def doors_alike(rng: np.random.Generator, width: float, height: float) -> Building:
    """Corridors around blocks, every doorway the same distance from the next."""
    return _blocks(rng, width, height, alike=True)


def _blocks(rng: np.random.Generator, width: float, height: float, *, alike: bool) -> Building:
    building = _solid(width, height)
    step, wide = rng.uniform(14.0, 45.0), rng.uniform(1.8, 3.2)
    xs = _steps(rng, _BORDER + 2.0, width - _BORDER - 2.0, step)
    ys = _steps(rng, _BORDER + 2.0, height - _BORDER - 2.0, step)
    building.net(xs, ys, wide)
    _line_with_doors(rng, building, wide, alike=alike)
    return building


def parallel(rng: np.random.Generator, width: float, height: float) -> Building:
    """Long corridors side by side, joined at the ends and here and there between."""
    building = _solid(width, height)
    wide = rng.uniform(1.6, 2.8)
    spacing = wide + rng.uniform(1.5, 6.0)
    count = int(np.clip((height - 2.0 * _BORDER - wide) / spacing, 2, rng.integers(2, 7)))
    ys = [_BORDER + 0.5 * wide + 1.0 + spacing * k for k in range(count)]
    xs = [_BORDER + 2.0, width - _BORDER - 2.0]
    if width > 60.0 and rng.random() < 0.6:
        xs.insert(1, float(rng.uniform(0.35, 0.65) * width))
    building.net(xs, ys, wide)
    _line_with_doors(rng, building, wide, alike=bool(rng.random() < 0.5), deepest=0.6)
    return building


def court(rng: np.random.Generator, width: float, height: float) -> Building:
    """Long corridors around a court, one of them twice side by side, and wings that end blind."""
    building = _solid(width, height)
    wide = rng.uniform(1.8, 3.2)
    xs = [_BORDER + 2.0, width - _BORDER - 2.0]
    if rng.random() < 0.5:
        xs.insert(1, float(rng.uniform(0.3, 0.7) * width))
    low, high = _BORDER + 2.0, 0.75 * height
    building.net(xs, [low, low + wide + rng.uniform(1.5, 5.0), high], wide)
    for x in xs:
        if rng.random() < 0.6:
            building.corridor((x, high), (x, height - _BORDER - 1.0), wide)
    deepest = float(rng.choice([0.15, 0.3, 1.0]))
    _line_with_doors(rng, building, wide, alike=bool(rng.random() < 0.3), deepest=deepest)
    return building


def hall(rng: np.random.Generator, width: float, height: float) -> Building:
    """One hall with pillars in rows, stands of some visitors among them, and lanes between."""
    building = _solid(width, height)
    building.clear(_BORDER, _BORDER, width - _BORDER, height - _BORDER)
    step, size = rng.uniform(5.0, min(11.0, 0.3 * height)), rng.uniform(0.3, 1.0)
    jitter = rng.choice([0.0, 0.0, 0.6])
    xs = np.arange(_BORDER + step, width - _BORDER - 0.9 * step, step)
    ys = np.arange(_BORDER + step, height - _BORDER - 0.9 * step, step)
    for x in xs:
        for y in ys:
            cx, cy = rng.normal((x, y), 0.5 * jitter).tolist()
            building.clear(cx - size / 2, cy - size / 2, cx + size / 2, cy + size / 2, solid=True)
    lanes = [np.concatenate(([a[0] - step / 2], a + step / 2)) for a in (xs, ys)]
    every = 1 if len(xs) * len(ys) < 60 else 2
    building.net(lanes[0][::every].tolist(), lanes[1][::every].tolist(), 0.0)
    for _ in range(int(rng.uniform(0.1, 0.5) * len(xs) * len(ys))):
        x, y = rng.choice(xs), rng.choice(ys)
        w, h = rng.uniform(0.5, 0.55 * step, 2)
        building.clear(x - w / 2, y - h / 2, x + w / 2, y + h / 2, solid=True)
    return building


def office(rng: np.random.Generator, width: float, height: float) -> Building:
    """Corridors around blocks, with furnished rooms that are entered."""
    building = _solid(width, height)
    step, wide = rng.uniform(16.0, 30.0), rng.uniform(1.8, 2.6)
    xs = _steps(rng, _BORDER + 2.0, width - _BORDER - 2.0, step)
    ys = _steps(rng, _BORDER + 2.0, height - _BORDER - 2.0, step)
    for x in xs:
        for a, b in pairwise(ys):
            building.corridor((x, a), (x, b), wide)
    _line_with_doors(rng, building, wide, alike=False, deepest=0.3)
    for y in ys:
        for a, b in pairwise(xs):
            _row_of_rooms(rng, building, (a, b, y), wide)
    return building


def _row_of_rooms(
    rng: np.random.Generator, building: Building, along: tuple[float, float, float], wide: float
) -> None:
    """Free a corridor along x at y with rooms on its upper side, where there is room for them."""
    first, last, y = along
    free = building.blocked.shape[0] * RESOLUTION - _BORDER - y
    stops = [first]
    x = first + wide
    depth = rng.uniform(3.5, 5.5)
    while x < last - wide - 3.0 and free > depth + wide + 2.0:
        size = min(rng.uniform(3.0, 6.0), last - wide - x)
        if size > 2.5 and rng.random() < 0.6:
            stops.append(_room(rng, building, (x, y, size, depth), wide))
        x += size + 0.3
    stops.append(last)
    for a, b in pairwise(stops):
        building.corridor((a, y), (b, y), wide)


def _room(
    rng: np.random.Generator,
    building: Building,
    mark: tuple[float, float, float, float],
    wide: float,
) -> float:
    """Free a room above a corridor and return where its door is along it."""
    x, y, size, depth = mark
    floor = y + wide / 2 + 0.2
    building.clear(x, floor, x + size, floor + depth)
    door = float(x + rng.uniform(0.8, size - 0.8))
    building.clear(door - 0.5, y, door + 0.5, floor + 0.1)
    for _ in range(rng.integers(1, 5)):
        w, h = rng.uniform(0.3, 1.4, 2)
        cx, cy = rng.uniform(x, x + size), floor + rng.uniform(0.3, 1.0) * depth
        if abs(cx - door) > 0.7 + w / 2:
            building.clear(cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2, solid=True)
    if rng.random() < 0.5:
        building.add_road((door, y), (door, floor + 0.55 * depth))
    return door


def _line_with_doors(
    rng: np.random.Generator,
    building: Building,
    wide: float,
    *,
    alike: bool,
    deepest: float = 3.0,
) -> None:
    """Set doorways and niches into both sides of every road."""
    step, size, depth = rng.uniform(_DOOR_STEP_MIN, 9.0), rng.uniform(0.8, 1.2), 0.15
    for a, b in building.roads:
        start, end = np.array(building.points[a]), np.array(building.points[b])
        span = float(np.abs(end - start).sum())
        along = np.abs(end - start) / span
        across = along[::-1]
        for side in (-1.0, 1.0):
            at = wide + (0.5 * step if alike else rng.uniform(0.0, step))
            while at < span - wide - 1.0:
                if not alike:
                    size = rng.uniform(0.7, 2.0)
                    depth = min(float(rng.choice([0.1, 0.15, 0.3, 1.0, 3.0])), deepest)
                near = np.minimum(start, end) + at * along + side * (0.5 * wide - 0.05) * across
                far = near + size * along + side * (depth + 0.05) * across
                building.clear(near[0], near[1], far[0], far[1])
                at += step if alike else rng.uniform(2.0, 2.0 * step)


KINDS: dict[str, Callable[[np.random.Generator, float, float], Building]] = {
    "rings": rings,
    "parallel": parallel,
    "hall": hall,
    "doors alike": doors_alike,
    "office": office,
}
CHOSEN_KINDS = {"court": court}
"""Kinds that take no turn among the others, but are built where they are asked for."""


def building(seed: int, largest: float = 1.0, kind: str | None = None) -> tuple[str, Building]:
    """Return a building and its kind, 20 x 20 to 300 x 200 m.

    Args:
        seed: Of all that is random; the kinds take turns.
        largest: Factor on the greatest size.
        kind: Its kind, from half the greatest size on; None for the one whose turn it is.
    """
    rng = np.random.default_rng([seed, 1])
    top = np.maximum(np.array([300.0, 200.0]) * largest, 21.0)
    low = np.maximum(20.0, 0.5 * top) if kind else 20.0
    kind = kind or list(KINDS)[seed % len(KINDS)]
    width, height = np.exp(rng.uniform(np.log(low), np.log(top)))
    make = (KINDS | CHOSEN_KINDS)[kind]
    return kind, make(rng, float(max(width, height)), float(min(width, height)))
