"""A 10 x 10 m room with four boxes, its scanner and a drive with noisy odometry."""

from __future__ import annotations

import math

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2

Log = list[tuple[Scan, SE2, SE2]]
"""Scan, odometry and true pose."""
BOXES = ((2.0, 2.5), (7.0, 3.0), (3.0, 7.5), (7.5, 7.0))
BOX = 0.5


def box(x0: float, y0: float, x1: float, y1: float) -> Floats:
    """Segments `(4, 4)` of x0, y0, x1, y1 [m] around a rectangle."""
    return np.array([(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)])


def room() -> Floats:
    """Segments of the room and its boxes, `(20, 4)` [m]."""
    walls = [box(0.0, 0.0, 10.0, 10.0)]
    walls += [box(x, y, x + BOX, y + BOX) for x, y in BOXES]
    return np.concatenate(walls)


ROOMS = np.concatenate([box(0.0, 0.0, 7.0, 4.0), box(8.0, -1.0, 13.0, 5.0)])
ROOMS = np.concatenate([ROOMS, box(1.5, 0.5, 2.0, 0.9), box(10.5, 3.0, 11.0, 4.0)])
"""Segments of two rooms beside each other."""


def ranges_at(segments: Floats, pose: SE2, angles: Floats) -> Floats:
    """Exact distance from a pose to the first segment along each angle, inf for none."""
    direction = np.column_stack((np.cos(angles + pose.theta), np.sin(angles + pose.theta)))
    start, edge = segments[:, :2] - (pose.x, pose.y), segments[:, 2:] - segments[:, :2]
    cross = direction[:, None, 0] * edge[None, :, 1] - direction[:, None, 1] * edge[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / cross
        u = start[None, :, 0] * direction[:, None, 1] - start[None, :, 1] * direction[:, None, 0]
        u = u / cross
    hit = (t > 0.0) & (u >= 0.0) & (u <= 1.0)
    nearest: Floats = np.where(hit, t, np.inf).min(axis=1, initial=np.inf)
    return nearest


def scan_at(
    segments: Floats,
    pose: SE2,
    *,
    beams: int = 360,
    field_of_view: float = 2.0 * math.pi,
    sigma: float = 0.0,
    rng: np.random.Generator | None = None,
    stamp: float = 0.0,
    clockwise: bool = False,
    T_base_sensor: SE2 = SE2(),  # noqa: B008
) -> Scan:
    """Scan the segments from a pose of the robot."""
    sign = -1.0 if clockwise else 1.0
    increment = sign * field_of_view / beams
    angle_min = -sign * 0.5 * field_of_view
    angles = angle_min + increment * np.arange(beams, dtype=np.float64)
    ranges = ranges_at(segments, pose @ T_base_sensor, angles)
    if rng is not None:
        ranges = ranges + rng.normal(0.0, sigma, beams)
    return Scan(ranges, angle_min, increment, 0.1, 30.0, stamp, 0.0, T_base_sensor)


def drive(seed: int, laps: float = 1.25) -> Log:
    """Scan, odometry (3 % long, 1 degree a metre drift) and true pose along a ring, 10 Hz."""
    rng = np.random.default_rng(seed)
    segments, result = room(), []
    centre, radius, speed = (5.0, 5.0), 2.0, 0.5
    odometry = SE2()
    previous: SE2 | None = None
    for k in range(int(laps * 2.0 * math.pi * radius / speed * 10)):
        angle = speed / radius * 0.1 * k
        truth = SE2(
            centre[0] + radius * math.sin(angle),
            centre[1] - radius * math.cos(angle),
            math.remainder(angle, 2.0 * math.pi),
        )
        if previous is not None:
            step = previous.inverse() @ truth
            length = math.hypot(step.x, step.y)
            noise = rng.normal(0.0, 0.02, 2)
            odometry = odometry @ SE2(
                step.x * (1.03 + noise[0]),
                step.y,
                step.theta * (1.0 + noise[1]) + math.radians(1.0) * length,
            )
        previous = truth
        result.append(
            (scan_at(segments, truth, sigma=0.01, rng=rng, stamp=0.1 * k), odometry, truth)
        )
    return result


def distance_to_walls(segments: Floats, points: Floats) -> Floats:
    """Distance [m] of each point `(N, 2)` to the nearest segment, `(N,)`."""
    start, edge = segments[:, :2], segments[:, 2:] - segments[:, :2]
    offset = points[:, None, :] - start[None]
    ratio = (offset * edge).sum(axis=2) / (edge * edge).sum(axis=1)
    nearest = start + np.clip(ratio, 0.0, 1.0)[..., None] * edge
    gap = points[:, None, :] - nearest
    distance: Floats = np.sqrt((gap * gap).sum(axis=2)).min(axis=1)
    return distance
