"""Tracks a planned trajectory: stretches driven ahead or back, and turns on the spot."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import (
    angle_param,
    duration_param,
    length_param,
    param,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.motion import MotionLimits, braking_speed, crossing, curvature_into
from arjuna_nav.planners import path as paths


@dataclass(frozen=True)
class TrackerConfig:
    """Parameters of driving planned trajectories, into goals and out of tight spots."""

    lookahead_time: float = duration_param(0.6, "Time to the pose that is steered to.")
    min_lookahead: float = length_param(0.05, "Least distance of that pose.", minimum=0.02)
    deceleration: float = param(0.5, "Braking before a stop.", unit="m/s^2", minimum=0.01)
    min_speed: float = speed_param(0.04, "Speed that the wheels still hold.", minimum=0.001)
    max_angular_velocity: float = yaw_rate_param(1.2, "Greatest yaw rate.", minimum=0.05)
    lateral_acceleration: float = param(
        0.25,
        "Greatest acceleration in bends: by more, wheels that turn and drive drift.",
        unit="m/s^2",
        minimum=0.01,
    )
    min_angular_velocity: float = yaw_rate_param(0.1, "Yaw rate below which the wheels stick.")
    angular_deceleration: float = param(
        1.5, "Braking at the end of a turn.", unit="rad/s^2", minimum=0.01
    )
    latency: float = duration_param(0.12, "From a command to the motion that is measured.")
    xy_precision: float = length_param(0.01, "Distance that is exact enough.")
    yaw_precision: float = angle_param(0.015, "Angle that is exact enough.")
    yaw_tolerance: float = angle_param(
        0.05, "The same before a stretch, on which steering does the rest."
    )

    steering_reserve: float = param(
        1.1,
        "Ratio of planned radii to the tightest bend of a steered robot: the rest corrects.",
        minimum=1.0,
    )

    def within(self, limits: MotionLimits) -> TrackerConfig:
        """Return these parameters, no faster than a controller's limits."""
        fast = min(self.max_angular_velocity, max(limits.yaw_rate, 0.05))
        return replace(
            self,
            deceleration=min(self.deceleration, limits.deceleration or math.inf),
            max_angular_velocity=fast,
            min_angular_velocity=min(self.min_angular_velocity, fast),
            angular_deceleration=min(
                self.angular_deceleration, limits.angular_deceleration or math.inf
            ),
        )

    def felt(self, pose: SE2, velocity: Velocity) -> SE2:
        """Return where a robot at a pose is when it feels a command."""
        return pose @ SE2.exp(np.array([velocity.x, 0.0, velocity.yaw_rate]) * self.latency)

    def lookahead(self, speed: float) -> float:
        """Return the distance of the pose that is steered to at a speed [m]."""
        return max(self.lookahead_time * speed, self.min_lookahead)


class Piece(NamedTuple):
    """A part of a trajectory: poses `(N, 3)` driven ahead (1) or back (-1), or a turn (0)."""

    poses: Floats
    direction: int

    @property
    def start(self) -> SE2:
        """The first pose."""
        return SE2.from_array(self.poses[0])

    @property
    def end(self) -> SE2:
        """The last pose."""
        return SE2.from_array(self.poses[-1])


class Tracker:
    """Drives the pieces of a trajectory one after the other, each to its end.

    Args:
        blend: Distance before the end of a stretch at which the turn behind it begins [m].
        radius: Of the robot's tightest bend; 0 where it turns on the spot [m].

    Attributes:
        pieces: What is left to drive, the present piece first.
        through: Whether it does not brake at the end of a last piece that is driven ahead.

    It steers to a pose a lookahead away, as pure pursuit to a point, and into its heading: where
    the trajectory unbends, an arc to the point alone leads wide of it.

    Source: the braking profile v^2 = 2 a d, from where the robot will be when it feels the command.
    """

    def __init__(self, config: TrackerConfig, blend: float = 0.0, radius: float = 0.0) -> None:
        self._config, self._blend, self._radius = config, blend, radius
        self.reset()

    def reset(self) -> None:
        """Forget the trajectory."""
        self.pieces: list[Piece] = []
        self.through = False

    def follow(self, trajectory: Floats, through: bool = False) -> None:
        """Take a trajectory `(N, 3)`; a step that leads nowhere is part of a turn."""
        self.pieces, self.through = list(pieces_of(trajectory)), through

    @property
    def runs_out(self) -> bool:
        """True where all that is left is driven ahead and ends without a stop."""
        return self.through and len(self.pieces) == 1 and self.pieces[0].direction > 0

    def compute(self, pose: SE2, velocity: Velocity, speed: float) -> Velocity | None:
        """Return what to drive, at a measured velocity and up to a speed [m/s]; None at the end."""
        while self.pieces and self._is_done(self.pieces[0], pose, velocity):
            self.pieces.pop(0)
        if not self.pieces:
            return None
        piece = self.pieces[0]
        if piece.direction == 0:
            seen = pose.inverse() @ piece.end
            drift = self._held(seen.x, speed)
            return Velocity(drift, yaw_rate=self._rate(seen.theta, velocity.yaw_rate))
        return self._along(piece, pose, velocity, speed)

    def strays(self, pose: SE2, distance: float, angle: float = math.pi) -> bool:
        """Return whether a pose is off the present piece by a distance [m], or turned off [rad]."""
        if not self.pieces:
            return False
        piece, there = self.pieces[0], paths.nearest(self.pieces[0].poses, pose)
        x, y, theta = piece.poses[there]
        turned = piece.direction != 0 and abs(wrap(theta - pose.theta)) > angle
        return turned or math.hypot(x - pose.x, y - pose.y) > distance

    def rest(self, pose: SE2, distance: float) -> Floats:
        """Return the poses ahead within a distance [m] of the present piece, the robot's first."""
        poses = self.pieces[0].poses
        if self.pieces[0].direction:
            poses = poses[paths.nearest(poses, pose) :]
            near = poses if distance == math.inf else poses[paths.along(poses) <= distance]
            return np.vstack((pose.array(), near[1:]))
        turn = wrap(self.pieces[0].end.theta - pose.theta)
        steps = np.linspace(0.0, turn, 2 + int(abs(turn) / 0.03))  # a corner moves by a fifth cell
        return np.column_stack((np.tile((pose.x, pose.y), (len(steps), 1)), pose.theta + steps))

    def _is_done(self, piece: Piece, pose: SE2, velocity: Velocity) -> bool:
        config, seen = self._config, pose.inverse() @ piece.end
        if piece.direction == 0:
            off = abs(wrap(seen.theta))
            at_rest = abs(wrap(seen.theta) - velocity.yaw_rate * config.latency)
            exact = config.yaw_precision if len(self.pieces) == 1 else config.yaw_tolerance
            return off <= exact and at_rest <= 2.0 * exact
        near = math.hypot(seen.x, seen.y) <= config.xy_precision
        past = piece.direction * seen.x <= 0.5 * config.xy_precision
        return near or (past and paths.nearest(piece.poses, pose) == len(piece.poses) - 1)

    def _along(self, piece: Piece, pose: SE2, velocity: Velocity, speed: float) -> Velocity:
        """Return what drives along a stretch, slower where it bends by more than it may turn."""
        config, side = self._config, float(piece.direction)
        felt = config.felt(pose, velocity)
        here = paths.nearest(piece.poses, felt)
        if not self.runs_out:
            # In a bend the end lies aside or behind: there the length along it counts.
            along = paths.length(piece.poses[here + 1 :])
            remaining = max(side * (felt.inverse() @ piece.end).x, along)
            speed = min(
                speed, max(braking_speed(remaining, config.deceleration, 0.0), config.min_speed)
            )
        seen = felt.inverse() @ _ahead(piece, here, felt, config.lookahead(speed))
        curvature = side * curvature_into(SE2(side * seen.x, side * seen.y, seen.theta))
        if self._radius > 0.0:
            curvature = min(max(curvature, -1.0 / self._radius), 1.0 / self._radius)
        bend = max(abs(curvature), 1e-9)
        fastest = min(
            config.max_angular_velocity / bend, math.sqrt(config.lateral_acceleration / bend)
        )
        v = side * min(speed, fastest)
        w = v * curvature
        share = 1.0 - pose.distance(piece.end) / max(self._blend, 1e-9)
        if len(self.pieces) > 1 and self.pieces[1].direction == 0 and share > 0.0:
            turn = wrap(self.pieces[1].end.theta - pose.theta)
            w = share * self._rate(turn, velocity.yaw_rate) + (1.0 - share) * w
        return Velocity(v, yaw_rate=w)

    def _held(self, ahead: float, speed: float) -> float:
        """Return the speed that brings back what a turn moves the robot along its heading."""
        config = self._config
        if abs(ahead) <= 2.0 * config.xy_precision:
            return 0.0
        fast = min(speed, braking_speed(abs(ahead), config.deceleration, 0.0))
        return math.copysign(fast, ahead)

    def _rate(self, angle: float, rate: float) -> float:
        """Return the yaw rate that turns by an angle and comes to rest there.

        A measured rate that leads away by less than the slowest counts as noise.
        """
        config = self._config
        rest = angle - rate * config.latency
        away = rest * rate < 0.0 and abs(rate) > config.min_angular_velocity
        if rest * angle <= 0.0 or away:  # the motion under way suffices, or is too much
            return 0.0
        fast = braking_speed(abs(rest), config.angular_deceleration, 0.0)
        fast = min(fast, abs(rest) / max(config.latency, 0.01), config.max_angular_velocity)
        return math.copysign(max(config.min_angular_velocity, fast), angle)


def _ahead(piece: Piece, here: int, pose: SE2, lookahead: float) -> SE2:
    """Return the pose of a stretch, or of its straight continuation, a lookahead away."""
    beyond = np.flatnonzero(paths.distances(piece.poses[here:], pose) >= lookahead)
    if not len(beyond):
        remaining = max(piece.direction * (pose.inverse() @ piece.end).x, 0.0)
        return piece.end @ SE2(piece.direction * max(lookahead - remaining, 0.0), 0.0)
    after = here + int(beyond[0])
    a, b = (SE2.from_array(piece.poses[i]) for i in (max(after - 1, here), after))
    ratio = crossing(pose, a, b, lookahead)
    turned = a.theta + ratio * wrap(b.theta - a.theta)
    return SE2(a.x + ratio * (b.x - a.x), a.y + ratio * (b.y - a.y), turned)


def pieces_of(trajectory: Floats) -> Iterator[Piece]:
    """Give the pieces of a trajectory `(N, 3)`, each as long as it can be."""
    kinds = [_kind(a, b) for a, b in itertools.pairwise(trajectory)]
    first = 0
    for k, kind in enumerate(kinds):
        if k + 1 == len(kinds) or kinds[k + 1] != kind:
            yield Piece(trajectory[first : k + 2], kind[0])
            first = k + 1


def _kind(a: Floats, b: Floats) -> tuple[int, int]:
    """Return 1 for ahead, -1 for back, 0 for a turn, and that turn's sign."""
    dx, dy = b[:2] - a[:2]
    middle = a[2] + 0.5 * wrap(b[2] - a[2])
    ahead = math.cos(middle) * dx + math.sin(middle) * dy
    if abs(ahead) < 1e-6:
        return 0, int(np.sign(wrap(b[2] - a[2])))
    return int(np.sign(ahead)), 0
