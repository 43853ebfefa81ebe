"""The escape from tight spots: a searched trajectory where there is no valid control."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, duration_param, length_param, param, speed_param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.contact import leaves, line_off, turn_touches
from arjuna_nav.controllers.gap import Gap, find_gap, first_contact, seen_again, steered_onto
from arjuna_nav.controllers.tracker import Tracker, TrackerConfig, pieces_of
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides, first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.outline import Drive, find_path, first_blocked, path_cost


@dataclass(frozen=True)
class EscapeConfig:
    """Parameters of the escape."""

    enabled: bool = param(
        True,
        "Whether to search a trajectory by bends, turns and back, and through narrow gaps.",
        theirs=False,
    )
    max_speed: float = speed_param(
        0.3, "Greatest speed; half of that in a gap without room.", minimum=0.02
    )
    rejoin_distance: float = length_param(
        0.5, "How far ahead on the path it leads at the least.", minimum=0.1
    )
    reach: float = length_param(2.5, "How far ahead at the most.", minimum=0.1)
    targets: int = param(4, "Number of poses of the path that it is searched to.", minimum=1)
    gap_reach: float = length_param(
        1.5, "How far ahead on the path narrow gaps are looked for.", minimum=0.1
    )
    gap_room: float = length_param(
        0.15, "Room beside the robot below which a gap is narrow.", minimum=0.01
    )
    gap_margin: float = length_param(0.005, "Room beside the robot, without its padding, in a gap.")
    gap_distance: float = length_param(
        0.12, "Distance of the robot's front from a gap where it lines up."
    )
    gap_angle: float = angle_param(0.5, "Angle to a gap's line up to which it is steered onto it.")
    run_up: float = length_param(0.25, "Distance before a gap over which the robot lines up.")
    horizon: float = duration_param(0.5, "How far ahead collisions are looked for.", minimum=0.05)
    max_deviation: float = length_param(
        0.1, "Distance off its trajectory at which it searches another.", minimum=0.01
    )
    max_heading_deviation: float = angle_param(
        0.5, "Angle off its trajectory at which it does.", minimum=0.01
    )
    patience: float = duration_param(1.0, "Time for which it waits for an obstacle to move.")
    attempts: int = param(3, "Number of trajectories for one escape.", minimum=1)
    max_iterations: int = param(60000, "Greatest number of poses of a search.", minimum=1)


class Escape:
    """Takes over from any controller that fails, and brings the robot to the path farther on.

    It plans and drives in the costmap's own frame: poses on a map jump, odometry does not.

    Args:
        footprint: The robot, with padding.
        body: Without.
        radius: Of the robot's tightest bend; 0 where it turns on the spot [m].
    """

    def __init__(
        self,
        config: EscapeConfig,
        tracking: TrackerConfig,
        footprint: Footprint,
        body: Footprint,
        radius: float = 0.0,
    ) -> None:
        self._config, self._tracking = config, tracking
        self._footprint, self._body = footprint, body
        self._tracker, self._radius = Tracker(tracking, radius=radius), radius
        self._outline = body.widened(config.gap_margin).points
        (self._rear, right), (self._front, left) = (
            self._outline.min(axis=0),
            self._outline.max(axis=0),
        )
        self._reach = config.gap_reach + 2.0 * footprint.circumscribed_radius
        self._half, self._middle = 0.5 * (left - right), 0.5 * (left + right)
        turn = 2.0 * config.max_speed / tracking.max_angular_velocity  # by its time, with the stops
        self._drive = Drive(turn, 0.3 * turn, back=2.0, limit=config.max_iterations)
        self._sharpest = tracking.max_angular_velocity / config.max_speed
        if radius > 0.0:
            planned = radius * tracking.steering_reserve
            self._drive = self._drive._replace(direct=config.reach, radius=planned)
            self._sharpest = min(self._sharpest, 1.0 / planned)
        self.reset()

    @property
    def active(self) -> bool:
        """True while something is left to drive."""
        return bool(self._tracker.pieces)

    @property
    def in_gap(self) -> bool:
        """True while it drives through a narrow gap."""
        return self.active and self._gap is not None

    def reset(self) -> None:
        """Hand over to the controller."""
        self._tracker.reset()
        self._gap: Gap | None = None
        self._leaves = False
        self._attempts, self._blocked_since = 0, math.inf

    def begin(self, pose: SE2, path: Floats, costmap: Costmap) -> bool:
        """Search a trajectory to the path ahead, and return whether there is one."""
        self.reset()
        return self._config.enabled and self._plan(*_in_own_frame(pose, path, costmap))

    def turn_touches(self, yaw_rate: float, pose: SE2, costmap: Costmap) -> bool:
        """Return whether a turn on the spot at a rate [rad/s] touches a point soon."""
        return turn_touches(pose, yaw_rate * self._config.horizon, costmap, self._body)

    def leave_contact(self, pose: SE2, costmap: Costmap, yaw_rate: float = 0.0) -> bool:
        """Drive off what the robot touches, straight or in a bend; return whether it can.

        Args:
            yaw_rate: At which it is to be free to turn then [rad/s].
        """
        self.reset()
        T_own = costmap.T_frame_own.inverse()
        turn = math.copysign(self._config.gap_angle, yaw_rate) if yaw_rate else 0.0
        poses = self._line_off(T_own @ pose, costmap.seen_from(T_own), turn)
        if self._config.enabled and len(poses) > 1:
            self._tracker.follow(poses)
        self._leaves = self.active
        return self.active

    def compute(
        self,
        pose: SE2,
        velocity: Velocity,
        path: Floats,
        costmap: Costmap,
        now: float,
        speed: float = math.inf,
    ) -> Velocity | None:
        """Return what to drive, None where it has come to its end or is blocked.

        Args:
            pose: The robot's, in the costmap's frame.
            velocity: As measured.
            now: Time [s].
            speed: Greatest speed [m/s].
        """
        pose, path, costmap = _in_own_frame(pose, path, costmap)
        config = self._config
        if self._tracker.strays(pose, config.max_deviation, config.max_heading_deviation):
            self._tracker.reset()
            self._plan(pose, path, costmap)
        elif self._gap is not None:
            self._look_again(self._gap, pose, costmap)
        command = self._tracker.compute(pose, velocity, min(self._speed, speed))
        if command is None:
            self.reset()
            return None
        look = max(abs(command.x) * self._config.horizon, costmap.frame.resolution)
        if self._is_free(self._tracker.rest(pose, look), costmap):
            self._blocked_since = math.inf
            return command
        self._blocked_since = min(self._blocked_since, now)
        if now - self._blocked_since < self._config.patience:
            return STILL
        self._attempts += 1
        if self._attempts >= self._config.attempts or not self._plan(pose, path, costmap):
            self.reset()
            return None
        self._blocked_since = math.inf
        return STILL

    def leads_to(self, path: Floats, costmap: Costmap) -> bool:
        """Return whether its trajectory, if there is one, ends near a path or beyond a gap."""
        if not self.active or self._gap is not None:
            return True
        end = costmap.T_frame_own @ self._tracker.pieces[-1].end
        return float(paths.distances(path, end).min()) <= self._config.rejoin_distance

    def can_hand_over(self, pose: SE2, path: Floats, costmap: Costmap) -> bool:
        """Return whether a controller may take over here, if it can.

        It may where nothing but driving ahead is left, what stopped the controller is passed, and
        the outline fits along the path.
        """
        if not self._tracker.runs_out:
            return False
        own, config = costmap.T_frame_own.inverse() @ pose, self._config
        if self._gap is not None:
            passed = (self._gap.line.inverse() @ own).x >= 0.0
            if not passed or not self._can_turn(pose, costmap):
                return False
        started = own.distance(self._tracker.pieces[0].start)
        if self._gap is None and started < 0.6 * config.rejoin_distance:
            return False
        ahead = paths.ahead(path, pose)
        near = ahead[paths.along(ahead) <= 2.0 * config.rejoin_distance]
        if self._radius > 0.0:  # its path's headings are those that it drives with, back as well
            return first_collision(costmap, self._footprint, near) is None
        return first_blocked(near, costmap, self._footprint) is None

    def _can_turn(self, pose: SE2, costmap: Costmap) -> bool:
        """Return whether the robot has room to turn, by the points that scans have hit."""
        turned = pose.array() + np.outer((-1.0, 1.0), (0.0, 0.0, self._config.gap_angle))
        points = costmap.obstacles(pose.x, pose.y, self._reach)
        return bool(first_contact(turned, points, self._outline) == len(turned))

    @property
    def _speed(self) -> float:
        if self._gap is None:
            return float(self._config.max_speed)
        room = 0.5 * self._gap.width - self._half
        return float(
            self._config.max_speed * min(max(2.0 * room / self._config.gap_room, 0.5), 1.0)
        )

    def _is_free(self, poses: Floats, costmap: Costmap) -> bool:
        """Return whether the robot can drive poses, by the points that scans have hit in a gap.

        So it can where it leaves what it touches.
        """
        if self._gap is None:
            free = first_collision(costmap, self._footprint, poses) is None
            return free or (self._leaves and leaves(poses, costmap, self._body))
        around = costmap.obstacles(poses[0, 0], poses[0, 1], self._reach)
        return bool(first_contact(poses, around, self._outline) == len(poses))

    def _plan(self, pose: SE2, path: Floats, costmap: Costmap) -> bool:
        """Take the trajectory through a narrow gap on the path, or the cheapest one round."""
        config, self._leaves = self._config, False
        points = costmap.obstacles(pose.x, pose.y, self._reach)
        near = path[paths.along(path) <= config.gap_reach]
        self._gap = find_gap(near, points, self._half, config.gap_room)
        trajectory = None
        if self._gap is not None:
            trajectory = self._through(self._gap, pose, points, costmap)
        if trajectory is None:
            self._gap, trajectory = None, self._around(pose, path, costmap)
        if trajectory is None:
            return False
        self._tracker.follow(trajectory, through=True)
        return self.active

    def _through(self, gap: Gap, pose: SE2, points: Floats, costmap: Costmap) -> Floats | None:
        """Return the trajectory through a gap: onto its line from here, or from before it."""
        at = gap.line.inverse() @ pose
        if at.x >= gap.last:
            return None
        if abs(at.theta) < self._config.gap_angle:
            steered = self._steered(gap, pose)
            if self._fits(gap, steered, points):
                return steered
        for distance in (self._config.run_up, 0.0):
            before = gap.first - self._front - self._config.gap_distance - distance
            entry = gap.line @ SE2(before, -self._middle)
            searched = find_path(pose, entry, costmap, self._footprint, self._drive)
            if not len(searched):
                continue
            steered = self._steered(gap, entry)
            if self._fits(gap, steered, points):
                return np.vstack((searched, steered[1:]))
        return None

    def _fits(self, gap: Gap, poses: Floats, points: Floats) -> bool:
        """Return whether poses through a gap leave half of its room beside the robot."""
        room = max(0.5 * gap.width - self._half, 0.0)
        outline = self._outline * (1.0 + 0.5 * room / self._half)
        return bool(first_contact(poses, points, outline) == len(poses))

    def _look_again(self, gap: Gap, pose: SE2, costmap: Costmap) -> None:
        """Follow a gap as it is seen now, and steer onto its line from here where that is free."""
        points = costmap.obstacles(pose.x, pose.y, self._reach)
        at = gap.line.inverse() @ pose
        inside = self._tracker.runs_out
        window = (at.x + self._rear, at.x + self._front + 0.3) if inside else (-0.3, 0.3)
        newest = seen_again(gap, points, window)
        if newest.width > 2.0 * (self._half + self._config.gap_room):
            return
        self._gap = newest
        if inside and abs(at.theta) < self._config.gap_angle and at.x < gap.last - self._rear:
            steered = self._steered(newest, pose)
            if self._fits(newest, steered, points):
                self._tracker.follow(steered, through=True)

    def _steered(self, gap: Gap, pose: SE2) -> Floats:
        """Return the poses onto a gap's line and along it until the robot is through."""
        line = gap.line @ SE2(0.0, -self._middle)
        end = gap.last - self._rear
        seen = (line.inverse() @ pose).array()
        lookahead = self._tracking.lookahead(self._speed)
        poses = steered_onto(seen, lookahead, self._sharpest, end, 0.02)
        return np.column_stack((line.apply(poses[:, :2]), poses[:, 2] + line.theta))

    def _around(self, pose: SE2, path: Floats, costmap: Costmap) -> Floats | None:
        """Return the cheapest trajectory to the path ahead; else off what the robot touches."""
        lead, least = self._line_off(pose, costmap), math.inf
        best = lead if len(lead) > 1 else None
        for target, along in self._targets(path, costmap):
            found = find_path(pose, target, costmap, self._footprint, self._drive)
            cost = path_cost(found, self._drive) - along if len(found) > 1 else math.inf
            if cost < least:
                least, best = cost, _without_last_turn(found)
        self._leaves = best is lead
        return best

    def _line_off(self, pose: SE2, costmap: Costmap, turn: float = 0.0) -> Floats:
        """Return the poses off what the robot touches, its own first, and alone if none."""
        return line_off(pose, costmap, self._footprint, self._body, self._radius, turn)

    def _targets(self, path: Floats, costmap: Costmap) -> Iterator[tuple[SE2, float]]:
        """Give poses of the path where the outline is free, and how far along they are [m]."""
        config, along = self._config, paths.along(path)
        last = min(config.reach, along[-1])
        for distance in np.linspace(min(config.rejoin_distance, last), last, config.targets):
            i = int(np.searchsorted(along, distance - 1e-9))
            before = int(
                np.searchsorted(along, max(along[i] - self._footprint.circumscribed_radius, 0.0))
            )
            dx, dy = path[i, :2] - path[before, :2]
            along_path = i > before and self._radius == 0.0
            yaw = math.atan2(dy, dx) if along_path else float(path[i, 2])
            target = SE2(float(path[i, 0]), float(path[i, 1]), yaw)
            if not collides(costmap, self._footprint, target):
                yield target, float(along[i])


def _in_own_frame(pose: SE2, path: Floats, costmap: Costmap) -> tuple[SE2, Floats, Costmap]:
    """Return a pose, a path and a costmap in the frame in which the costmap is kept."""
    T_own = costmap.T_frame_own.inverse()
    path = np.column_stack((T_own.apply(path[:, :2]), path[:, 2] + T_own.theta))
    return T_own @ pose, path, costmap.seen_from(T_own)


def _without_last_turn(poses: Floats, short: float = 0.2) -> Floats:
    """Return poses up to where a controller takes over, without a stop for a turn at their end.

    Args:
        poses: `(N, 3)`.
        short: Length of a last stretch that is left out with the turn before it [m].
    """
    pieces = list(pieces_of(poses))
    if len(pieces) > 1 and pieces[-1].direction == 0:
        pieces.pop()
    if len(pieces) > 2 and pieces[-2].direction == 0 and paths.length(pieces[-1].poses) < short:
        del pieces[-2:]
    return np.vstack([pieces[0].poses[:1], *(piece.poses[1:] for piece in pieces)])
