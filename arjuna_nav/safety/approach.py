"""Zones that approach: time before a collision with what stands, and room before what moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, length_param, param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.sight import Sight

_OUTLINE_SCALES = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Of the outline, tried until what touches the robot lies outside."""
_VELOCITY_PARTS = (1.0, 0.7, 0.4, 0.2, 0.0)
"""Of a velocity, tried in this order before what moves."""


@dataclass(frozen=True)
class ApproachConfig:
    """Limits of a zone that approaches; from `leave_obstacles` on not Nav2's."""

    time_before_collision: float = duration_param(2.0, "Time kept.", minimum=0.01)
    simulation_time_step: float = duration_param(0.1, "Step of looking ahead.", minimum=0.001)
    leave_obstacles: bool = param(
        False,
        "Whether a robot that touches something may move away; as Nav2 does, it is held there.",
        theirs=False,
    )
    moving_time: float = duration_param(
        0.0,
        "How far ahead the paths of what moves are predicted; 0 takes all for standing, as Nav2.",
        theirs=0.0,
    )
    deceleration: float = param(2.5, "What the robot brakes with.", unit="m/s^2", minimum=0.01)
    angular_deceleration: float = param(3.2, "The same of its turns.", unit="rad/s^2", minimum=0.01)
    moving_clearance: float = length_param(0.1, "Distance kept from what moves.")
    reaction_time: float = duration_param(0.1, "From a scan to the wheels.")

    def step(self, duration: float) -> float:
        """Return the step of looking a duration ahead [s]; 500 are enough for any velocity."""
        return max(self.simulation_time_step, duration / 500)


class Approach:
    """Slows the robot down so that a collision stays a time away.

    Args:
        least: Points within the outline that are a collision.
    """

    def __init__(self, config: ApproachConfig, least: int) -> None:
        self._config = config
        self._least = least

    def allowed(self, velocity: Velocity, sight: Sight, outline: Footprint) -> float:
        """Return the part of a velocity that the zone's outline allows, 0 to 1."""
        if velocity == Velocity():
            return 1.0
        velocity = outline.base_velocity(velocity)
        stands = self._config.leave_obstacles
        part = (self._before_what_stands if stands else self._time_to_collision)(
            velocity, sight.points, outline
        )
        if self._config.moving_time > 0.0:
            part = min(
                part, self._before_what_moves(velocity, sight.at(sight.speeds > 0.0), outline)
            )
        return part

    def _time_to_collision(self, velocity: Velocity, points: Floats, outline: Footprint) -> float:
        """Return Nav2's time before a collision, as a part of that to be kept; 1 for none.

        Source: nav2_collision_monitor, Polygon::getCollisionTime and projectState.
        """
        kept = self._config.time_before_collision
        step = self._config.step(kept)
        if inside(outline, points) >= self._least:
            return 0.0
        vx, vy, x, y, time = velocity.x, velocity.y, 0.0, 0.0, 0.0
        reach = outline.circumscribed_radius + velocity.speed * (kept + step)
        points = points[np.hypot(*points.T) <= reach + 1e-9]
        turn, theta = velocity.yaw_rate * step, 0.0
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
        self, velocity: Velocity, points: Floats, footprint: Footprint
    ) -> float:
        """Return the time of the last step that is free, as a part of that to be kept.

        So the robot stands before an obstacle rather than creep into it. It may always move away.
        The time is that of the way in which it can brake, if that is longer.
        """
        zone = self._config
        braking = 0.5 * self._stops(velocity) + zone.reaction_time
        duration = max(zone.time_before_collision, braking)
        step = zone.step(duration)
        reach = footprint.circumscribed_radius + velocity.speed * duration
        near = points[np.hypot(*points.T) <= reach]
        if len(near) < self._least:
            return 1.0
        near, outline = self._free(near, footprint)
        twist = np.array([velocity.x, velocity.y, velocity.yaw_rate])
        for k in range(1, math.ceil(duration / step)):
            seen = SE2.exp(twist * (k * step)).inverse().apply(near)
            if inside(outline, seen) >= self._least:
                return (k - 1) * step / duration
        return 1.0

    def _before_what_moves(self, velocity: Velocity, sight: Sight, outline: Footprint) -> float:
        """Return the greatest part of a velocity that keeps clear of what moves.

        Where all of them meet it the robot stands, unless it touches no sooner if it continues.
        """
        zone, radius = self._config, outline.circumscribed_radius
        time, room = zone.moving_time, zone.moving_clearance
        swing = min(abs(velocity.yaw_rate) * time * radius, radius - outline.inscribed_radius)
        reach = time * (sight.speeds + velocity.speed) + swing
        gaps, away = outline.gaps(sight.points)
        near = gaps <= reach + room
        if not near.any():
            return 1.0
        sight, gaps, away = sight.at(near), gaps[near], away[near]
        part = self._at_rest_in_time(velocity, gaps, away, sight.speeds, radius)
        if gaps.min() <= 0.0:
            return part
        if gaps.min() > room:
            outline = outline.widened(room)
        free = self._meetings(velocity, sight, outline)
        for k, contact in enumerate(free):
            if contact == math.inf:
                return min(part, _VELOCITY_PARTS[k])
        return part if free[0] >= free[-1] else 0.0

    def _at_rest_in_time(
        self, velocity: Velocity, gaps: Floats, away: Floats, speeds: Floats, radius: float
    ) -> float:
        """Return the greatest part that can be braked before what may come at speeds.

        The robot is at rest by then, or moves away: it may be walked into, but walks into nobody.
        Where somebody goes does not count: who walks away may turn about, and of two who pass each
        other the scan shows one thing that goes with the one while the other comes.

        Source: passive motion safety, as Macek et al., Towards safe vehicle navigation in dynamic
            urban scenarios, Automatika 2009.
        """
        zone = self._config
        vx, vy, turning = velocity.x, velocity.y, abs(velocity.yaw_rate)
        closing = away @ (vx, vy) + turning * radius
        meets = closing > 0.0
        stops = self._stops(velocity)
        if not meets.any() or stops < 1e-3:  # a robot that is at rest in a millisecond stands
            return 1.0
        speeds, closing = speeds[meets], closing[meets]
        room = gaps[meets] - zone.moving_clearance - zone.reaction_time * speeds
        room = np.maximum(room, 0.0) / stops
        parts = (np.sqrt(np.square(speeds) + 2.0 * closing * room) - speeds) / closing
        return min(float(parts.min()), 1.0)

    def _stops(self, velocity: Velocity) -> float:
        """Return how long the robot takes to stand [s]."""
        turning, zone = abs(velocity.yaw_rate), self._config
        return max(velocity.speed / zone.deceleration, turning / zone.angular_deceleration)

    def _meetings(self, velocity: Velocity, sight: Sight, outline: Footprint) -> list[float]:
        """Return when each part of a velocity meets points that move [s], inf for never."""
        step = self._config.step(self._config.moving_time)
        times = step * np.arange(1, math.ceil(self._config.moving_time / step) + 1)
        paths = sight.points + sight.motions * times[:, None, None]
        found = []
        for part in _VELOCITY_PARTS:
            turn = velocity.yaw_rate * part * times
            share = part * times * np.sinc(turn / (2.0 * math.pi))
            c, s = share * np.cos(0.5 * turn), share * np.sin(0.5 * turn)
            x = paths[..., 0] - (c * velocity.x - s * velocity.y)[:, None]
            y = paths[..., 1] - (s * velocity.x + c * velocity.y)[:, None]
            c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
            seen = np.stack((c * x + s * y, c * y - s * x), axis=-1).reshape(-1, 2)
            within = outline.holds(seen).reshape(x.shape).any(axis=1)
            found.append(float(times[within.argmax()]) if within.any() else math.inf)
        return found

    def _free(self, points: Floats, footprint: Footprint) -> tuple[Floats, Footprint]:
        """Return the points that a motion may meet, and the robot's outline, free of them now.

        What is within the outline is the robot's own part, or touches it: that must not hold it for
        ever. So the outline is taken smaller, or where that does not help, the points away.
        """
        for scale in _OUTLINE_SCALES:
            outline = footprint.scaled(scale)
            if inside(outline, points) < self._least:
                return points, outline
        return points[~footprint.holds(points)], footprint


def inside(outline: Footprint | None, points: Floats) -> int:
    """Return how many points `(N, 2)` of the base frame [m] lie within an outline."""
    return 0 if outline is None else int(outline.holds(points).sum())
