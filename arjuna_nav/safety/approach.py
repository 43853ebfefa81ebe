"""The footprint's own zone: keeps a time before any collision, with what moves as well."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.safety.base import Action

_SCALES = (1.0, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5)
"""Of the outline, until what touches the robot lies outside."""
_PARTS = (1.0, 0.7, 0.4, 0.2, 0.0)
"""Of a velocity, tried one after the other before what moves."""
_ROOM = 0.1  # kept to what moves, all round [m]
_ESCAPES = 0.3  # later that it is met if the robot drives on, which is then better [s]


@dataclass(frozen=True)
class ApproachConfig:
    """How far ahead it looks."""

    enabled: bool = param(True, "Whether the zone counts.")
    min_points: int = param(6, "Points within that make it count.", minimum=1)
    time_before_collision: float = param(0.5, "Time kept.", unit="s", minimum=0.01)
    simulation_time_step: float = param(0.1, "Step of looking ahead.", unit="s", minimum=0.01)
    moving_time: float = param(
        1.5,
        "How far ahead the ways of what moves are looked at; 0 takes all for standing.",
        unit="s",
        minimum=0.0,
    )


class ApproachZone:
    """Slows the robot down so that a collision stays a time away."""

    Config: ClassVar[type[Any]] = ApproachConfig
    action = Action.APPROACH

    def __init__(self, config: ApproachConfig) -> None:
        self._config = config

    def allowed(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        footprint: Footprint,
        motions: NDArray[np.float64] | None = None,
    ) -> float:
        """Return how long nothing is met, as a part of the time to be kept.

        The time is that of the last free step, where Nav2 takes the first that collides: so the
        robot stands before an obstacle rather than creep into it. It may always move away.
        """
        zone = self._config
        if velocity == Velocity():
            return 1.0
        allowed = self._before_what_stands(velocity, points, footprint)
        if motions is not None and zone.moving_time > 0.0:
            moves = motions.any(axis=1)
            ahead = self._before_what_moves(velocity, points[moves], motions[moves], footprint)
            allowed = min(allowed, ahead)
        return allowed

    def _before_what_stands(
        self, velocity: Velocity, points: NDArray[np.float64], footprint: Footprint
    ) -> float:
        zone = self._config
        duration, step = zone.time_before_collision, zone.simulation_time_step
        reach = footprint.circumscribed_radius + abs(velocity.v) * duration
        near = points[np.hypot(*points.T) <= reach]
        if len(near) < zone.min_points:
            return 1.0
        near, outline = self._free(near, footprint)
        twist = np.array([velocity.v, 0.0, velocity.w])
        for k in range(1, math.ceil(duration / step)):
            seen = SE2.exp(twist * (k * step)).inverse().apply(near)
            if _count(seen, outline) >= zone.min_points:
                return (k - 1) * step / duration
        return 1.0

    def _before_what_moves(
        self,
        velocity: Velocity,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        footprint: Footprint,
    ) -> float:
        """Return the greatest part of a velocity that keeps clear of what moves on as it does.

        Where all of them meet it the robot stands, unless it gets away by driving on.
        """
        speeds = np.hypot(*motions.T) + abs(velocity.v)
        reach = footprint.circumscribed_radius + self._config.moving_time * speeds
        near = np.hypot(*points.T) <= reach + _ROOM
        points, motions = points[near], motions[near]
        grown = footprint.scaled(1.0 + _ROOM / footprint.inscribed_radius)
        outline = grown if not _count(points, grown) else footprint
        if not len(points) or _count(points, outline):
            return 1.0
        free = [self._meeting(velocity, part, points, motions, outline) for part in _PARTS]
        for part, time in zip(_PARTS, free, strict=True):
            if time == math.inf:
                return part
        return 1.0 if free[0] > free[-1] + _ESCAPES else 0.0

    def _meeting(
        self,
        velocity: Velocity,
        part: float,
        points: NDArray[np.float64],
        motions: NDArray[np.float64],
        outline: Footprint,
    ) -> float:
        """Return when a part of a velocity meets points that move, inf for never [s]."""
        step = self._config.simulation_time_step
        twist = np.array([velocity.v, 0.0, velocity.w]) * part
        for k in range(1, math.ceil(self._config.moving_time / step) + 1):
            time = k * step
            seen = SE2.exp(twist * time).inverse().apply(points + motions * time)
            if _count(seen, outline):
                return time
        return math.inf

    def _free(
        self, points: NDArray[np.float64], footprint: Footprint
    ) -> tuple[NDArray[np.float64], Footprint]:
        """Return the points that a motion may meet, and the robot's outline, free of them now.

        What is within the outline is the robot's own part, or touches it: that must not hold it for
        ever. So the outline is taken smaller, or where that does not help, the points away.
        """
        for scale in _SCALES:
            outline = footprint.scaled(scale)
            if _count(points, outline) < self._config.min_points:
                return points, outline
        return points[~footprint.holds(points)], footprint


def _count(points: NDArray[np.float64], outline: Footprint) -> int:
    """Return how many points lie within an outline."""
    return int(outline.holds(points).sum())
