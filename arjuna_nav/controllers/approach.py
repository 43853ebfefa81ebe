"""The final approach: a planned trajectory into the goal, not to the edge of its tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, duration_param, length_param, param
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.graceful.control_law import approach
from arjuna_nav.controllers.motion import braking_distance
from arjuna_nav.controllers.tracker import Tracker, TrackerConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.outline import Drive, find_path


@dataclass(frozen=True)
class ApproachConfig:
    """Parameters of the final approach."""

    enabled: bool = param(
        True,
        "Whether to drive into the goal where there is room, beyond what is tolerated.",
        theirs=False,
    )
    distance: float = length_param(
        0.5, "Distance from the goal at which a straight approach begins."
    )
    bearing: float = angle_param(
        0.35,
        "Bearing of the goal up to which it is driven to without a turn on the spot before.",
        maximum=math.pi,
    )
    straight_ratio: float = param(
        1.05,
        "Ratio of the path's rest to the goal's distance up to which it is straight.",
        minimum=1.0,
    )
    curve_time: float = duration_param(
        4.5,
        "Time before the goal, at the speed driven, at which an approach begins on a curve that "
        "ends with its heading; 0 for straight approaches only.",
    )
    curve_angle: float = angle_param(
        0.8, "Greatest turn on that curve; the rest is turned on the spot.", maximum=math.pi
    )
    curve_gain: float = param(
        1.5, "k_phi and k_delta of the graceful control law on that curve.", minimum=0.1
    )
    curve_room: float = length_param(0.05, "Room beside the robot all along that curve.")
    blend_distance: float = length_param(
        0.05, "Distance from the goal at which the turn to its heading begins."
    )
    patience: float = duration_param(2.0, "How long it may get no nearer.")
    attempts: int = param(
        3, "Number of curves into one goal of a steered robot, which cannot turn there.", minimum=1
    )
    max_iterations: int = param(
        5000, "Greatest number of poses of the search for such a curve round obstacles.", minimum=1
    )


class Arrival(NamedTuple):
    """A robot on the last stretch of its path, at a moment.

    Attributes:
        pose: The robot's, in the frame of the costmap.
        velocity: As measured.
        now: Time [s].
        remaining: Length of the path that is left [m].
        speed: Greatest speed [m/s].
        within: Whether the goal's tolerance is met but for the heading.
        heading: Whether the heading matters.
    """

    pose: SE2
    goal: SE2
    velocity: Velocity
    costmap: Costmap
    now: float
    remaining: float
    speed: float
    within: bool
    heading: bool


class FinalApproach:
    """Takes over from any controller on the last, straight stretch of a path.

    It plans a trajectory that ends exactly at the goal and drives it, as long as it is free. Where
    it gets no nearer, or has no room, it ends, and the goal's tolerance counts. A steered robot
    drives a curve of Reeds and Shepp's, searched round obstacles where need be, and another one
    where it has not arrived by it.

    Args:
        radius: Of its tightest bend; 0 where it turns on the spot [m].

    Source: the curve is Park and Kuipers, A smooth control law for graceful motion of differential
        wheeled mobile robots in 2D environment, ICRA 2011.
    """

    def __init__(
        self,
        config: ApproachConfig,
        tracking: TrackerConfig,
        footprint: Footprint,
        radius: float = 0.0,
    ) -> None:
        self._config, self._tracking, self._footprint = config, tracking, footprint
        self._tracker = Tracker(tracking, config.blend_distance, radius)
        planned = radius * tracking.steering_reserve
        self._drive = Drive(back=1.0, direct=math.inf, limit=config.max_iterations, radius=planned)
        self.begin()

    def begin(self) -> None:
        """Begin with a goal."""
        self._attempts, self._failed_at = 0, -math.inf
        self.reset()

    def retry(self) -> bool:
        """Return whether a steered robot that has not arrived is to drive another curve."""
        again = self._over and self._drive.radius > 0.0
        again = again and self._attempts < self._config.attempts
        if again:
            self.reset()
        return again

    def steers(self, remaining: float, speed: float) -> bool:
        """Return whether a steered robot's curve is due with so much of its path left [m]."""
        due = bool(self._tracker.pieces) or remaining <= self._config.curve_time * speed
        return self._config.enabled and self._drive.radius > 0.0 and due

    def reset(self) -> None:
        """Begin again: the robot was carried away."""
        self._tracker.reset()
        self._over = self._corrected = False
        self._best, self._best_at = (math.inf, math.inf), -math.inf

    def compute(self, at: Arrival) -> Velocity | None:
        """Return what to drive, None where the controller is to drive or the robot has arrived."""
        pose, goal, within, heading = at.pose, at.goal, at.within, at.heading
        if not within and self._is_displaced(pose, goal):
            self.reset()
        if not self._config.enabled or self._over:
            return None
        planned = self._steered if self._drive.radius > 0.0 else self._planned
        if not self._tracker.pieces:
            if (trajectory := planned(at)) is None:
                self._over = within
                return None
            self._tracker.follow(trajectory)
        before = len(self._tracker.pieces)
        command = self._tracker.compute(pose, at.velocity, at.speed)
        again = len(self._tracker.pieces) < before and self._turned_off(pose)
        if again and (trajectory := planned(at)) is not None:
            self._tracker.follow(trajectory)
            command = self._tracker.compute(pose, at.velocity, at.speed)
        if command is None and heading and (self._turns(at) or self._corrects(pose, goal)):
            command = self._tracker.compute(pose, at.velocity, at.speed)
        ends = command is None or self._stalls(pose, at.now)
        if ends or self._is_blocked(pose, at.costmap):
            self.reset()
            self._over = ends or within
            return None
        return command

    def _is_blocked(self, pose: SE2, costmap: Costmap) -> bool:
        rest = self._tracker.rest(pose, math.inf)
        return first_collision(costmap, self._footprint, rest) is not None

    def _turned_off(self, pose: SE2) -> bool:
        """Return whether a steered robot begins a stretch with another heading than planned."""
        if not self._tracker.pieces or not self._drive.radius > 0.0:
            return False
        off = abs(wrap(self._tracker.pieces[0].start.theta - pose.theta))
        return self._attempts < self._config.attempts and off > self._tracking.yaw_tolerance

    def _is_displaced(self, pose: SE2, goal: SE2) -> bool:
        """Return whether the robot was carried away from its trajectory or from the goal."""
        if self._over:
            return pose.distance(goal) > self._config.distance
        return self._tracker.strays(pose, 0.5 * self._config.distance)

    def _planned(self, at: Arrival) -> Floats | None:
        """Return the first of the trajectories into the goal that is free, if one is due."""
        config, costmap, seen = self._config, at.costmap, at.pose.inverse() @ at.goal
        distance, bearing = math.hypot(seen.x, seen.y), math.atan2(seen.y, seen.x)
        straight_ahead = (
            abs(bearing) < config.bearing
            and at.remaining < config.straight_ratio * distance + costmap.frame.resolution
        )
        if not at.within and not straight_ahead:
            return None
        found = None
        if at.heading and not at.within and distance <= config.curve_time * at.speed:
            found = self._curve(at)
        braking = 1.2 * braking_distance(at.velocity.x, self._tracking.deceleration)
        if found is None and (at.within or distance <= max(config.distance, braking)):
            found = self._straight(at.pose, at.goal)
            if first_collision(costmap, self._footprint, found) is not None:
                return None
        if found is None or not at.heading:
            return found
        turn = _turn(SE2.from_array(found[-1]), at.goal.theta)
        free = first_collision(costmap, self._footprint, turn) is None
        return np.vstack((found, turn[1:])) if free or len(found) == 1 else found

    def _steered(self, at: Arrival) -> Floats | None:
        """Return a steered robot's curve into the goal, if one is due and free."""
        frame = at.costmap.frame
        inside = frame.inside(frame.to_cells(self._footprint.at(at.goal))).all()
        due = self.steers(at.remaining, at.speed) and inside
        if not due or at.now - self._failed_at < self._config.patience:
            return None
        felt = self._tracking.felt(at.pose, at.velocity)
        found = find_path(felt, at.goal, at.costmap, self._footprint, self._drive)
        if len(found) < 2:
            self._failed_at = at.now
            return None
        self._attempts += 1
        return found

    def _straight(self, pose: SE2, goal: SE2) -> Floats:
        """Return the line to the goal, behind a turn on the spot where the goal lies aside."""
        distance, sight = pose.distance(goal), math.atan2(goal.y - pose.y, goal.x - pose.x)
        if distance <= self._tracking.xy_precision:
            return pose.array()[None, :]
        ratio = np.linspace(0.0, 1.0, 2 + int(distance / 0.02))
        xy = pose.array()[:2] + ratio[:, None] * (goal.array()[:2] - pose.array()[:2])
        line = np.column_stack((xy, np.full(len(xy), sight)))
        if abs(wrap(sight - pose.theta)) < self._config.bearing:
            return line
        return np.vstack((_turn(pose, sight), line[1:]))

    def _curve(self, at: Arrival) -> Floats | None:
        """Return the curve to the goal, None where there is no room all along it.

        It ends with the goal's heading, or with a part of the turn to it.
        """
        config, frame, spacing = self._config, at.costmap.frame, at.costmap.frame.resolution
        felt, goal = self._tracking.felt(at.pose, at.velocity), at.goal
        sight = math.atan2(goal.y - felt.y, goal.x - felt.x)
        turn = min(max(wrap(goal.theta - sight), -config.curve_angle), config.curve_angle)
        end = SE2(goal.x, goal.y, sight + turn)
        law = np.array([config.curve_gain, config.curve_gain, 0.0, 1.0])
        limits = np.array([0.0, at.speed, spacing, self._tracking.max_angular_velocity])
        seen, _, _ = approach((felt.inverse() @ end).array(), law, limits, spacing)
        poses = np.column_stack((felt.apply(seen[:, :2]), felt.theta + seen[:, 2]))
        if SE2.from_array(poses[-1]).distance(end) > 2.0 * spacing:
            return None
        poses = np.vstack((poses, end.array()))
        cells = frame.to_cells(poses[:, :2])
        if not frame.inside(cells).all():
            return None
        room = at.costmap.clearances[at.costmap.data[cells[:, 0], cells[:, 1]]].min()
        free = first_collision(at.costmap, self._footprint, poses) is None
        return poses if free and room >= config.curve_room else None

    def _turns(self, at: Arrival) -> bool:
        """Turn at the goal where the costmap did not reach so far when the approach was planned."""
        turn, off = _turn(at.pose, at.goal.theta), abs(wrap(at.goal.theta - at.pose.theta))
        due = at.within and self._drive.radius == 0.0 and off > self._tracking.yaw_tolerance
        if not due or first_collision(at.costmap, self._footprint, turn) is not None:
            return False
        self._tracker.follow(turn)
        return True

    def _corrects(self, pose: SE2, goal: SE2) -> bool:
        """Drive straight, once, what the last turn moved the robot along its heading."""
        ahead = (pose.inverse() @ goal).x
        if self._corrected or abs(ahead) <= self._tracking.xy_precision:
            return False
        self._corrected = True
        self._tracker.follow(np.array([pose.array(), (pose @ SE2(ahead)).array()]))
        return True

    def _stalls(self, pose: SE2, now: float) -> bool:
        """Return whether it has got no nearer for too long."""
        piece = self._tracker.pieces[0]
        off = abs(wrap(piece.end.theta - pose.theta)) * self._footprint.circumscribed_radius
        if self._drive.radius > 0.0:  # on a bend of more than half a turn the end comes nearer late
            rest = paths.length(self._tracker.rest(pose, math.inf))
        else:
            rest = pose.distance(piece.end) if piece.direction else off
        remaining = len(self._tracker.pieces), rest
        if remaining[0] < self._best[0] or remaining[1] < self._best[1] - 1e-3:
            self._best, self._best_at = remaining, now
        return now - self._best_at > self._config.patience


def _turn(pose: SE2, heading: float) -> Floats:
    angle = wrap(heading - pose.theta)
    steps = np.linspace(0.0, angle, 2 + int(abs(angle) / 0.1))
    return np.column_stack((np.tile((pose.x, pose.y), (len(steps), 1)), pose.theta + steps))
