"""Gaps hardly wider than the robot: their middle lines between the points that scans have hit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.motion import curvature_to
from arjuna_nav.planners import path as paths


@dataclass(frozen=True)
class Gap:
    """A gap and the middle line through it, in the frame of the obstacles.

    Attributes:
        line: The line's pose where the gap is narrowest, looking along it.
        width: Between its sides [m].
        first: Where along the line it begins to be narrow [m].
        last: Where it ends [m].
    """

    line: SE2
    width: float
    first: float
    last: float


def find_gap(
    path: Floats,
    points: Floats,
    half: float,
    room: float,
    *,
    spans: tuple[float, ...] = (0.3, 0.15),
    aside: float = 0.25,
    turned: float = 0.8,
) -> Gap | None:
    """Return the narrow gap that a path leads through, None where there is none.

    The line is the widest strip between points, so neither cells nor an error of the path count.

    Args:
        path: Poses ahead of the robot `(N, 3)`.
        points: Obstacles `(N, 2)` in the path's frame [m].
        half: The robot's half width [m].
        room: Beside the robot, within which obstacles make a gap narrow [m].
        spans: Of the strip before and behind the narrowest pose, the first that succeeds [m].
        aside: Greatest distance of the line from the path [m].
        turned: Greatest angle of the line to the path [rad].
    """
    if not len(points) or len(path) < 2:
        return None
    narrowest, distance = _narrowest(path, points)
    if distance > half + room:
        return None
    seen = narrowest.inverse().apply(points)
    for span in spans:
        strip = widest_strip(seen, (-span, span), aside, turned, 0.04)
        if strip is not None and 0.0 <= strip[1] - 2.0 * half <= 2.0 * room:
            line = narrowest @ strip[0]
            along = line.inverse().apply(points)
            beside = (np.abs(along[:, 1]) < half + room) & (np.abs(along[:, 0]) < 2.0 * span)
            along = along[beside, 0] if beside.any() else np.zeros(1)
            return Gap(line, strip[1], float(along.min()), float(along.max()))
    return None


def seen_again(
    gap: Gap,
    points: Floats,
    window: tuple[float, float],
    *,
    weight: float = 0.3,
    shift: float = 0.06,
    tilt: float = 0.1,
) -> Gap:
    """Return a gap whose line follows what scans hit now: odometry drifts, noise is averaged.

    Args:
        gap: As it was last seen.
        points: Obstacles `(N, 2)` [m].
        window: From where to where along the line points count [m].
        weight: Of the newest line in the mean.
        shift: Greatest distance of the newest line from the last [m].
        tilt: Greatest angle between them [rad].
    """
    middle = gap.line @ SE2(0.5 * (window[0] + window[1]), 0.0)
    half = 0.5 * (window[1] - window[0])
    strip = widest_strip(middle.inverse().apply(points), (-half, half), shift, tilt)
    if strip is None:
        return gap
    line, width = strip
    newest = SE2(weight * line.x, weight * line.y, weight * line.theta)
    return replace(gap, line=middle @ newest @ middle.inverse() @ gap.line, width=width)


def _narrowest(path: Floats, points: Floats) -> tuple[SE2, float]:
    """Return the path's pose nearest to an obstacle, looking along the path, and the distance."""
    gaps = np.hypot(*(path[:, None, :2] - points[None, :, :]).transpose(2, 0, 1)).min(axis=1)
    k, along = int(np.argmin(gaps)), paths.along(path)
    first, last = np.searchsorted(along, [along[k] - 0.2, along[k] + 0.2])
    dx, dy = path[min(int(last), len(path) - 1), :2] - path[int(first), :2]
    return SE2(float(path[k, 0]), float(path[k, 1]), math.atan2(dy, dx)), float(gaps[k])


def widest_strip(
    points: Floats, window: tuple[float, float], aside: float, turn: float, step: float = 0.02
) -> tuple[SE2, float] | None:
    """Return the middle line of the widest strip that has points on both its sides.

    Args:
        points: Obstacles `(N, 2)`, seen from a pose between them [m].
        window: From where to where along the strip points count, from that pose [m].
        aside: Greatest distance of the middle line from that pose [m].
        turn: Greatest angle of the strip to the x axis [rad].
        step: Between the headings that are tried [rad].

    Returns:
        The line's nearest pose, looking along it, and the strip's width [m]; None where it has
        no sides.

    Source: the maximum-margin line between two sets of points (Vapnik 1963), here by trying
        headings: which point lies on which side need not be known.
    """
    count = max(math.ceil(turn / step), 1)
    found = _widest(points, window, aside, np.linspace(-turn, turn, 2 * count + 1), 0.03)
    if found[2] <= 0.0:
        return None
    heading, offset, width = found
    return SE2(-offset * math.sin(heading), offset * math.cos(heading), heading), width


@njit(cache=True)
def _widest(
    points: Floats, window: tuple[float, float], aside: float, headings: Floats, price: float
) -> tuple[float, float, float]:
    """Return heading, offset and width of the widest strip, 0 for none.

    The price of a turned strip is in width per angle [m/rad].
    """
    best = (0.0, 0.0, 0.0)
    for heading in headings:
        c, s = math.cos(heading), math.sin(heading)
        along = c * points[:, 0] + s * points[:, 1]
        across = c * points[:, 1] - s * points[:, 0]
        sides = np.sort(across[(along >= window[0]) & (along <= window[1])])
        for i in range(len(sides) - 1):
            width, middle = sides[i + 1] - sides[i], 0.5 * (sides[i + 1] + sides[i])
            better = width - price * abs(heading) > best[2] - price * abs(best[0])
            if abs(middle) <= aside and better:
                best = (heading, middle, width)
    return best


@njit(cache=True)
def steered_onto(
    pose: Floats, lookahead: float, sharpest: float, end: float, step: float
) -> Floats:
    """Return the poses of a robot that is steered onto the x axis, `(N, 3)`, the first as given.

    Args:
        pose: Seen from the line, looking along it by less than a right angle [m, m, rad].
        lookahead: Along the line [m].
        sharpest: Greatest curvature [1/m].
        end: Where it ends along the line [m].
        step: Between two poses [m].
    """
    poses = [pose]
    x, y, theta = pose
    while x < end and abs(theta) < 0.5 * math.pi and len(poses) * step < 4.0 * (end - pose[0]):
        c, s = math.cos(theta), math.sin(theta)
        curvature = curvature_to(c * lookahead - s * y, -s * lookahead - c * y)
        theta += 0.5 * min(max(curvature, -sharpest), sharpest) * step
        x += step * math.cos(theta)
        y += step * math.sin(theta)
        theta += 0.5 * min(max(curvature, -sharpest), sharpest) * step
        poses.append(np.array([x, y, theta]))
    result = np.empty((len(poses), 3))
    for i in range(len(poses)):
        result[i] = poses[i]
    return result


@njit(cache=True)
def first_contact(poses: Floats, points: Floats, outline: Floats) -> int:
    """Return the index of the first pose at which a point lies in the outline, else their number.

    Args:
        poses: `(N, 3)` [m, m, rad].
        points: Obstacles `(N, 2)` [m].
        outline: Corners in the robot's frame `(K, 2)` [m].
    """
    for n in range(len(poses)):
        c, s = math.cos(poses[n, 2]), math.sin(poses[n, 2])
        for i in range(len(points)):
            dx, dy = points[i, 0] - poses[n, 0], points[i, 1] - poses[n, 1]
            px, py = c * dx + s * dy, c * dy - s * dx
            inside = False
            for k in range(len(outline)):
                ax, ay = outline[k]
                bx, by = outline[k - 1]
                if (ay > py) != (by > py) and px < (bx - ax) * (py - ay) / (by - ay) + ax:
                    inside = not inside
            if inside:
                return n
    return len(poses)
