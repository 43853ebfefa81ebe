"""The last stretch: into the goal, not to the edge of its tolerance."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from arjuna_core.config import param
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.arrival_curve import ArrivalCurve
from arjuna_nav.controllers.motion import rollout
from arjuna_nav.controllers.turning import braked_turn
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint

_AHEAD = 0.35  # bearing up to which the goal is driven to without a turn before [rad]
_STEERS = 0.05  # nearer than that the bearing says nothing [m]
_LAST = 0.08  # of a curve, where only its heading is brought to its end [m]
_CRAWL = 0.04  # what wheels still do evenly [m/s]
_GAIN = 2.0  # of steering towards the goal [1/s]
_PASSED = 0.005  # [m]
_DRIFTED = 1.5  # of the precision: farther off after the last turn it drives the rest


@dataclass(frozen=True)
class ArrivalConfig:
    """How a path's end is driven into."""

    enabled: bool = param(
        True, "Whether to drive into the goal where there is room, beyond what is tolerated."
    )
    distance: float = param(
        0.5, "Distance from the goal at which the last stretch begins.", unit="m", minimum=0.0
    )
    xy_precision: float = param(0.01, "Distance that is exact enough.", unit="m", minimum=0.0)
    yaw_precision: float = param(0.015, "Angle that is exact enough.", unit="rad", minimum=0.0)
    deceleration: float = param(0.5, "Of braking into the goal.", unit="m/s^2", minimum=0.01)
    max_angular_velocity: float = param(1.2, "Of the last turn.", unit="rad/s", minimum=0.05)
    min_angular_velocity: float = param(
        0.1, "Yaw rate below which the wheels stick.", unit="rad/s", minimum=0.0
    )
    angular_deceleration: float = param(
        1.5, "Of braking into the heading.", unit="rad/s^2", minimum=0.01
    )
    latency: float = param(
        0.12, "From a command to the motion that is measured.", unit="s", minimum=0.0
    )
    curve_time: float = param(
        4.5,
        "Time before the goal, at the speed driven, from when on it is driven to on a curve that "
        "ends at its heading; 0 for straight into it.",
        unit="s",
        minimum=0.0,
    )
    curve_angle: float = param(
        0.8,
        "Greatest turn on that curve; what is more is turned on the spot.",
        unit="rad",
        minimum=0.0,
        maximum=math.pi,
    )
    patience: float = param(2.0, "How long it may get no nearer.", unit="s", minimum=0.0)


class _Stage(enum.Enum):
    AWAY = enum.auto()
    CURVING = enum.auto()
    AIMING = enum.auto()
    DRIVING = enum.auto()
    TURNING = enum.auto()
    SETTLING = enum.auto()
    OVER = enum.auto()


class Arrival:
    """Takes over from any controller near the goal and drives into it, on a curve or straight.

    What is left of the heading is turned on the spot, and how far wheels that slip have then
    carried the robot along it is driven back.

    Where there is no room, or it gets no nearer, it lets go, and what was tolerated before counts.

    Args:
        config: Parameters.
        footprint: The robot.

    Source: the braking profile v^2 = 2 a d, from where the robot will be when it feels the command.
    """

    def __init__(self, config: ArrivalConfig, footprint: Footprint) -> None:
        self._config = config
        self._footprint = footprint
        self._curve = ArrivalCurve(
            footprint, config.max_angular_velocity, config.curve_angle, config.latency
        )
        self.reset()

    @property
    def _over(self) -> bool:
        return self._stage is _Stage.OVER

    def reset(self) -> None:
        """Begin anew: the goal is another, or the way there."""
        self._stage = _Stage.AWAY
        self._curve.reset()
        self._best, self._best_at = math.inf, -math.inf

    def compute(
        self,
        pose: SE2,
        goal: SE2,
        velocity: Velocity,
        costmap: Costmap,
        now: float,
        *,
        left: float,
        speed: float,
        within: bool,
        heading: bool,
    ) -> Velocity | None:
        """Return what to drive, or None where the controller is to go on or the robot has arrived.

        Args:
            pose: The robot's, in the frame of the costmap.
            goal: Where to arrive.
            velocity: As measured.
            costmap: What is in the way.
            now: Time [s].
            left: Of the path [m].
            speed: Greatest speed [m/s].
            within: Whether the goal's tolerance is met but for the heading.
            heading: Whether the heading matters.
        """
        if not within and self._is_displaced(pose, goal):
            self.reset()
        if not self._config.enabled or self._over:
            return None
        if heading and self._curves(pose, goal, left, speed, within):
            curved = self._curved(pose, goal, velocity, costmap, now, speed)
            if curved is not None or self._over:
                return curved
        if self._stage is _Stage.AWAY and not self._begins(pose, goal, velocity, left, within):
            return None
        error = self._advance(pose, goal, velocity, heading)
        if error is None or self._stalls(error, now):
            self._stage = _Stage.OVER
            return None
        command = self._begun(pose, goal, velocity, speed, costmap, heading)
        if self._collides(pose, goal, command, costmap):
            self._let_go(within)
            return None
        return command

    def _let_go(self, within: bool) -> None:
        """Leave the rest to the controller, until the way is free or because it is tolerated."""
        self.reset()
        if within:
            self._stage = _Stage.OVER

    def _is_displaced(self, pose: SE2, goal: SE2) -> bool:
        """Tell whether the robot was carried away from where its last stretch is all but over."""
        ahead = self._stage in (_Stage.AWAY, _Stage.CURVING, _Stage.DRIVING)
        return not ahead and pose.distance(goal) > self._config.distance

    def _curves(self, pose: SE2, goal: SE2, left: float, speed: float, within: bool) -> bool:
        """Tell whether to go on, or to begin, on a curve: the path's rest is straight and ahead."""
        seen = pose.inverse() @ goal
        distance = math.hypot(seen.x, seen.y)
        if self._stage is _Stage.CURVING:
            return distance > _LAST
        if within or self._stage is not _Stage.AWAY or distance > self._config.curve_time * speed:
            return False
        return _is_straight_ahead(seen, left)

    def _curved(
        self, pose: SE2, goal: SE2, velocity: Velocity, costmap: Costmap, now: float, speed: float
    ) -> Velocity | None:
        """Return what drives along the curve; None, and let go, where it has no room or stalls."""
        distance = pose.distance(goal)
        top = self._braked(distance, velocity, speed)
        command = self._curve.compute(pose, goal, velocity, costmap, top)
        if command is None:
            self.reset()
            return None
        stalls = self._stalls(distance, now)
        self._stage = _Stage.OVER if stalls else _Stage.CURVING
        return None if stalls else command

    def _begins(self, pose: SE2, goal: SE2, velocity: Velocity, left: float, within: bool) -> bool:
        """Tell whether to take over: the path's rest is short, straight and ahead, or done with."""
        seen, config = pose.inverse() @ goal, self._config
        distance = math.hypot(seen.x, seen.y)
        reach = max(config.distance, 1.2 * velocity.x**2 / (2.0 * config.deceleration))
        return within or (distance <= reach and _is_straight_ahead(seen, left))

    def _advance(self, pose: SE2, goal: SE2, velocity: Velocity, heading: bool) -> float | None:
        """Go on to the stage that is due; return what is left to do in it, None where nothing is.

        The rest of a turn is given in metres of a corner's way, so that one scale measures all.
        """
        seen = pose.inverse() @ goal
        distance, bearing = math.hypot(seen.x, seen.y), math.atan2(seen.y, seen.x)
        sideways = abs(math.sin(bearing)) * distance
        if self._stage is _Stage.AWAY:
            self._stage = _Stage.AIMING
        if self._stage is _Stage.CURVING:
            self._stage = _Stage.DRIVING
        if self._stage is _Stage.AIMING and (
            abs(bearing) < _AHEAD or sideways < self._config.xy_precision
        ):
            self._stage = _Stage.DRIVING
        if self._stage is _Stage.DRIVING and (
            distance <= self._config.xy_precision or abs(seen.x) <= _PASSED
        ):
            self._stage = _Stage.TURNING
            self._best = math.inf
        if self._stage is _Stage.TURNING:
            if heading and self._turns(wrap(seen.theta), velocity.yaw_rate):
                return abs(wrap(seen.theta)) * self._footprint.circumscribed_radius
            if not heading or abs(seen.x) <= _DRIFTED * self._config.xy_precision:
                return None
            self._stage, self._best = _Stage.SETTLING, math.inf
        if self._stage is _Stage.SETTLING:
            return abs(seen.x) if abs(seen.x) > _PASSED else None
        return distance + (abs(bearing) if self._stage is _Stage.AIMING else 0.0)

    def _turns(self, off: float, rate: float) -> bool:
        """Tell whether the heading is still to be turned to, or will be turned away from."""
        precision, at_rest = self._config.yaw_precision, off - rate * self._config.latency
        return abs(off) > precision or abs(at_rest) > 2.0 * precision

    def _stalls(self, error: float, now: float) -> bool:
        """Tell whether it has got no nearer for too long."""
        if error < self._best - 1e-3:
            self._best, self._best_at = error, now
        return now - self._best_at > self._config.patience

    def _command(self, pose: SE2, goal: SE2, velocity: Velocity, speed: float) -> Velocity:
        seen, config = pose.inverse() @ goal, self._config
        distance, bearing = math.hypot(seen.x, seen.y), math.atan2(seen.y, seen.x)
        if self._stage is _Stage.TURNING:
            return Velocity(yaw_rate=self._rate(seen.theta, velocity.yaw_rate))
        if self._stage is _Stage.AIMING:
            return Velocity(yaw_rate=self._rate(bearing, velocity.yaw_rate))
        v = self._braked(abs(seen.x), velocity, speed)
        if seen.x < 0.0:  # it has gone too far: straight back
            return Velocity(-min(v, _CRAWL))
        if self._stage is _Stage.SETTLING:
            w = 0.0
        elif self._curve.active:
            w = self._curve.last(pose, velocity, v)
        else:
            w = _GAIN * bearing * min(v / 0.2, 1.0) if distance > _STEERS else 0.0
        return Velocity(
            v, yaw_rate=min(max(w, -config.max_angular_velocity), config.max_angular_velocity)
        )

    def _begun(
        self, pose: SE2, goal: SE2, velocity: Velocity, speed: float, costmap: Costmap, turns: bool
    ) -> Velocity:
        """Return the stage's command, with the last turn begun, where it is free, before it rests.

        The nearer to the goal, the faster: over the way that is left, that leads little aside.
        """
        command = self._command(pose, goal, velocity, speed)
        share = 1.0 - pose.distance(goal) / _STEERS
        if not turns or share <= 0.0 or self._stage is not _Stage.DRIVING:
            return command
        w = share * self._rate(goal.theta - pose.theta, velocity.yaw_rate)
        blocked = self._collides(pose, goal, Velocity(yaw_rate=w), costmap)
        return command if blocked else Velocity(command.x, yaw_rate=w)

    def _braked(self, distance: float, velocity: Velocity, speed: float) -> float:
        """Return the speed from which the robot stops within a distance [m/s]."""
        way = max(distance - abs(velocity.x) * self._config.latency, 0.0)
        return min(speed, max(math.sqrt(2.0 * self._config.deceleration * way), _CRAWL))

    def _rate(self, angle: float, rate: float) -> float:
        """Return the yaw rate that turns by an angle and comes to rest there."""
        config = self._config
        rates = config.min_angular_velocity, config.max_angular_velocity
        return braked_turn(wrap(angle), rate, rates, config.angular_deceleration, config.latency)

    def _collides(self, pose: SE2, goal: SE2, command: Velocity, costmap: Costmap) -> bool:
        """Tell whether the stage's rest, driven at once, meets an obstacle."""
        seen = pose.inverse() @ goal
        if command.x != 0.0:
            rest, motion = abs(seen.x) / abs(command.x), Velocity(command.x)
        else:
            angle = math.atan2(seen.y, seen.x) if self._stage is _Stage.AIMING else seen.theta
            rest, motion = 1.0, Velocity(yaw_rate=angle)
        arc = rollout(pose, motion, rest, costmap.frame.resolution)
        return first_collision(costmap, self._footprint, arc) is not None


def _is_straight_ahead(seen: SE2, left: float) -> bool:
    """Tell whether the robot, which sees the goal so, looks along the straight rest of its path."""
    distance = math.hypot(seen.x, seen.y)
    return abs(math.atan2(seen.y, seen.x)) < _AHEAD and left < 1.05 * distance + 0.05
