"""Keeping a time before any collision, as Nav2 does or so that a robot can leave; and of movers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.base import inside, parts

_SCALES = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Of the outline, until what touches the robot lies outside."""
_PARTS = (1.0, 0.7, 0.4, 0.2, 0.0)
"""Of a velocity, tried one after the other before what moves."""
_ROOM = 0.1  # kept to what moves, all round [m]
_TURNS = 0.5  # of its speed, that what goes away may come back with at once
_REACTION = 0.1  # from a scan to the wheels [s]
_AT_ONCE = 1e-3  # a robot that is at rest so soon stands [s]


@dataclass(frozen=True)
class ApproachConfig:
    """How far ahead a zone that approaches looks; the last four are ours."""

    time_before_collision: float = param(2.0, "Time kept.", unit="s", minimum=0.01)
    simulation_time_step: float = param(0.1, "Step of looking ahead.", unit="s", minimum=0.001)
    leave_obstacles: bool = param(
        False,
        "Whether a robot that touches something may move away; as Nav2 does, it is held there.",
    )
    moving_time: float = param(
        0.0,
        "How far ahead the paths of what moves are looked at; 0 takes all for standing, as Nav2.",
        unit="s",
        minimum=0.0,
    )
    deceleration: float = param(
        2.5, "What the robot brakes with before what moves.", unit="m/s^2", minimum=0.01
    )
    angular_deceleration: float = param(3.2, "The same of its turns.", unit="rad/s^2", minimum=0.01)


class Approach:
    """Slows the robot down so that a collision stays a time away.

    Args:
        config: How far ahead it looks.
        least: Points within the outline that are a collision.
    """

    def __init__(self, config: ApproachConfig, least: int) -> None:
        self._config = config
        self._least = least

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
        speeds: NDArray[np.float64] | None = None,
    ) -> float:
        """Return how long nothing is met, as a part of the time to be kept.

        Args:
            velocity: What is asked for.
            points: What is seen, `(N, 2)` in the base frame [m].
            footprint: The zone's outline.
            motions: Their velocities over ground, `(N, 2)` in the base frame [m/s].
            speeds: At which each may turn to the robot, `(N,)` [m/s]; its motion's if None.
        """
        zone = self._config
        if velocity == Velocity():
            return 1.0
        if zone.leave_obstacles:
            allowed = self._before_what_stands(velocity, points, footprint)
        else:
            allowed = self._time_to_collision(velocity, points, footprint)
        if motions is not None and zone.moving_time > 0.0:
            speeds = np.hypot(*motions.T) if speeds is None else speeds
            moves = speeds > 0.0
            seen = points[moves], motions[moves], speeds[moves]
            ahead = self._before_what_moves(velocity, *seen, footprint)
            allowed = min(allowed, ahead)
        return allowed

    def _time_to_collision(
        self, velocity: Velocity, points: NDArray[np.float64], outline: Footprint
    ) -> float:
        """Return Nav2's time before a collision, as a part of that to be kept; 1 for none.

        Source: nav2_collision_monitor, Polygon::getCollisionTime and projectState.
        """
        kept, step = self._config.time_before_collision, self._config.simulation_time_step
        if inside(outline, points) >= self._least:
            return 0.0
        (vx, vy, w), x, y, time = parts(velocity), 0.0, 0.0, 0.0
        reach = outline.circumscribed_radius + math.hypot(vx, vy) * (kept + step)
        points = points[np.hypot(*points.T) <= reach + 1e-9]
        turn, theta = w * step, 0.0
        while time <= kept and len(points) >= self._least:
            x, y, theta = x + vx * step, y + vy * step, theta + turn
            vx, vy = (
                vx * math.cos(turn) - vy * math.sin(turn),
                vx * math.sin(turn) + vy * math.cos(turn),
            )
            if inside(outline, SE2(x, y, theta).inverse().apply(points)) >= self._least:
                return min(time / kept, 1.0)
            time += step
        return 1.0

    def _before_what_stands(
        self, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> float:
        """Return the time of the last step that is free, as a part of that to be kept.

        So the robot stands before an obstacle rather than creep into it. It may always move away.
        """
        zone = self._config
        duration, step = zone.time_before_collision, zone.simulation_time_step
        reach = footprint.circumscribed_radius + abs(velocity.x) * duration
        near = points[np.hypot(*points.T) <= reach]
        if len(near) < self._least:
            return 1.0
        near, outline = self._free(near, footprint)
        twist = np.array([velocity.x, 0.0, velocity.yaw_rate])
        for k in range(1, math.ceil(duration / step)):
            seen = SE2.exp(twist * (k * step)).inverse().apply(near)
            if inside(outline, seen) >= self._least:
                return (k - 1) * step / duration
        return 1.0

    def _before_what_moves(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        speeds: NDArray[np.float64],
        footprint: Footprint,
    ) -> float:
        """Return the greatest part of a velocity that keeps clear of what moves.

        Where all of them meet it the robot stands, unless it is met no sooner while it goes on.
        """
        time, radius = self._config.moving_time, footprint.circumscribed_radius
        swing = min(abs(velocity.yaw_rate) * time * radius, radius - footprint.inscribed_radius)
        reach = time * (speeds + abs(velocity.x)) + swing
        gaps, away = footprint.gaps(points)
        near = gaps <= reach + _ROOM
        if not near.any():
            return 1.0
        points, motions = points[near], motions[near]
        turned = _turned_here(away[near], motions, speeds[near])
        part = self._at_rest_in_time(velocity, gaps[near], away[near], turned, footprint)
        grown = footprint.scaled(1.0 + _ROOM / footprint.inscribed_radius)
        outline = grown if gaps.min() > _ROOM else footprint
        if gaps.min() <= 0.0:
            return part
        free = self._meetings(velocity, points, motions, outline)
        for k, time in enumerate(free):
            if time == math.inf:
                return min(part, _PARTS[k])
        return part if free[0] >= free[-1] else 0.0

    def _at_rest_in_time(
        self,
        velocity: Velocity,
        gaps: NDArray[np.float64],
        away: NDArray[np.float64],
        speeds: NDArray[np.float64],
        footprint: Footprint,
    ) -> float:
        """Return the greatest part that can be braked before what may come at speeds.

        The robot is at rest by then, or moves away: it may be walked into, but walks into nobody.

        Source: passive motion safety, as Macek et al., Towards safe vehicle navigation in dynamic
            urban scenarios, Automatika 2009.
        """
        zone = self._config
        closing = velocity.x * away[:, 0] + abs(velocity.yaw_rate) * footprint.circumscribed_radius
        meets = closing > 0.0
        if not meets.any():
            return 1.0
        speeds, closing = speeds[meets], closing[meets]
        stops = max(
            abs(velocity.x) / zone.deceleration, abs(velocity.yaw_rate) / zone.angular_deceleration
        )
        if stops < _AT_ONCE:
            return 1.0
        room = np.maximum(gaps[meets] - _ROOM - _REACTION * speeds, 0.0) / stops
        parts = (np.sqrt(np.square(speeds) + 2.0 * closing * room) - speeds) / closing
        return min(float(parts.min()), 1.0)

    def _meetings(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        outline: Footprint,
    ) -> NDArray[np.float64]:
        """Return when each of `_PARTS` of a velocity meets points that move, inf for never [s]."""
        step = self._config.simulation_time_step
        times = step * np.arange(1, math.ceil(self._config.moving_time / step) + 1)
        ways = points + motions * times[:, None, None]
        found = []
        for part in _PARTS:
            v, w = velocity.x * part, velocity.yaw_rate * part
            chord, turn = v * times * np.sinc(w * times / (2.0 * math.pi)), w * times
            x = ways[..., 0] - (chord * np.cos(0.5 * turn))[:, None]
            y = ways[..., 1] - (chord * np.sin(0.5 * turn))[:, None]
            c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
            seen = np.stack((c * x + s * y, c * y - s * x), axis=-1).reshape(-1, 2)
            within = outline.holds(seen).reshape(x.shape).any(axis=1)
            found.append(times[within.argmax()] if within.any() else math.inf)
        return np.array(found)

    def _free(
        self, points: NDArray[np.float64], footprint: Footprint
    ) -> tuple[NDArray[np.float64], Footprint]:
        """Return the points that a motion may meet, and the robot's outline, free of them now.

        What is within the outline is the robot's own part, or touches it: that must not hold it for
        ever. So the outline is taken smaller, or where that does not help, the points away.
        """
        for scale in _SCALES:
            outline = footprint.scaled(scale)
            if inside(outline, points) < self._least:
                return points, outline
        return points[~footprint.holds(points)], footprint


def _turned_here(
    away: NDArray[np.float64], motions: NDArray[np.float64], speeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how fast things may come, wherever they turn to; less only of what goes away."""
    nears: NDArray[np.float64] = 2.0 * (speeds - (away * motions).sum(axis=1))
    return nears.clip(_TURNS * speeds, speeds)
