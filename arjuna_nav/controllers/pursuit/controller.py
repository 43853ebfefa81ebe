"""Regulated pure pursuit: aim at a point ahead, slower in bends, near obstacles and at the goal."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import (
    NO_PATH,
    ControlResult,
    ControlStatus,
    PathController,
    TrackedPath,
)
from arjuna_nav.controllers.checkers import is_there
from arjuna_nav.controllers.display import Flag, Plan, Spot
from arjuna_nav.controllers.motion import MotionLimits, Turning, crossing, curvature_to, rollout
from arjuna_nav.controllers.pursuit.config import RegulatedPurePursuitConfig
from arjuna_nav.costmap.collision import collision_ahead
from arjuna_nav.costmap.costmap import FREE, INSCRIBED, MAX_NON_OBSTACLE, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


class RegulatedPurePursuit(PathController):
    """Follows a path by pure pursuit with regulated speed.

    Args:
        xy_goal_tolerance: Where the position counts as reached and only the heading is left [m].
        period: Time between two calls [s].

    Attributes:
        carrot: What it aims at, seen from the robot; None where only the heading is left.

    Source: Macenski et al., Regulated pure pursuit for robot path tracking, 2023;
        nav2_regulated_pure_pursuit_controller.
    """

    Config: ClassVar[type[Any]] = RegulatedPurePursuitConfig
    _config: RegulatedPurePursuitConfig

    @staticmethod
    def shows(config: RegulatedPurePursuitConfig) -> dict[str, type[Any]]:
        """Return the topics that show how it turns, and the arc tested for collisions."""
        bends = {"curvature_lookahead_point": Spot} if config.use_fixed_curvature_lookahead else {}
        return {"is_rotating_to_heading": Flag, "lookahead_collision_arc": Plan, **bends}

    def __init__(
        self,
        config: RegulatedPurePursuitConfig,
        footprint: Footprint,
        xy_goal_tolerance: float = 0.25,
        period: float = 0.05,
    ) -> None:
        path = TrackedPath(
            config.max_robot_pose_search_dist,
            config.same_goal_tolerance,
            inverts=config.allow_reversing,
        )
        super().__init__(config, footprint, xy_goal_tolerance, period, path)
        self._arrived = self._turning = False
        self._cancelled, self._braking = False, math.inf
        self._last_w = 0.0
        self.turning_radius = 0.0 if config.use_rotate_to_heading else math.inf
        fast, turns = config.rotate_to_heading_angular_vel, config.max_angular_accel
        self.limits = MotionLimits(fast, angular_acceleration=turns, angular_deceleration=turns)

    @property
    def desired_speed(self) -> float:
        return float(self._config.desired_linear_vel)

    def set_path(self, path: Floats) -> None:
        """Take a path `(N, 3) float64`; a path to the same goal keeps what was reached.

        Raises:
            PathError: The path is empty or not `(N, 3)`.
        """
        self._cancelled, self._braking = False, math.inf
        if self._path.replace(path):
            self._arrived = self._turning = False

    def cancel(self) -> bool:
        """Begin to brake; return whether the robot may be stopped at once, or stands."""
        self._cancelled = True
        return self._braking == 0.0 or not self._config.use_cancel_deceleration

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        if not len(self.path):
            return NO_PATH
        self._path.advance(pose)
        if self._cancelled:
            least = self._config.cancel_deceleration * self._period
            self._braking = max(min(self._braking, abs(velocity.x)) - least, 0.0)
        goal = self._path.goal
        stays = self._arrived and self._config.stateful
        pushed = 0.15 if self._config.gentle_turns else math.inf
        near = is_there(pose, goal, self._xy_goal_tolerance, stays, pushed)
        self._arrived = near and (stays or paths.ends_here(self.path, pose))
        gentle = self._config.gentle_turns
        self._last_w = self._last_w if gentle else velocity.yaw_rate
        lookahead = self._lookahead(velocity)
        carrot = pose.inverse() @ self._carrot(pose, lookahead)
        ahead = self._regulating(pose, carrot)
        angle = math.atan2(ahead.y, ahead.x)
        if self._side_of(ahead) < 0.0:
            angle = wrap(angle + math.pi)
        only_heading = self._arrived and self._config.use_rotate_to_heading
        turns = only_heading or self._must_turn(angle)
        self._show(pose @ ahead, turns)
        if only_heading:
            self.carrot = None
            command = Velocity(yaw_rate=self._turn(wrap(goal.theta - pose.theta)))
            return self._checked(command, pose, costmap, math.inf)
        if turns:
            self.carrot = ahead
            return self._turn_on(angle, self._side_of(ahead), pose, costmap)
        failed = result = self._along(carrot, pose, velocity, costmap)
        for share in self._config.shorter_lookaheads:
            if result.status is ControlStatus.SUCCEEDED:
                return result
            carrot = pose.inverse() @ self._carrot(pose, lookahead * share)
            result = self._along(carrot, pose, velocity, costmap)
        if result.status is ControlStatus.SUCCEEDED:
            return result
        return self._turn_instead(carrot, pose, costmap) or failed

    def _show(self, regulating: SE2, turns: bool) -> None:
        """Put on display the point that regulates, of the path's frame, and whether it turns."""
        if "is_rotating_to_heading" in self.wanted:
            self.shown["is_rotating_to_heading"] = Flag(turns)
        if "curvature_lookahead_point" in self.wanted:
            self.shown["curvature_lookahead_point"] = Spot(regulating.x, regulating.y)

    def _side_of(self, carrot: SE2) -> float:
        """Return -1 for a point that is driven to in reverse, else 1."""
        return -1.0 if self._config.allow_reversing and carrot.x < 0.0 else 1.0

    def _turn_on(self, angle: float, side: float, pose: SE2, costmap: Costmap) -> ControlResult:
        """Return a turn, on the spot or, as soon as that gets on, on a bend that has room."""
        w, cost = self._turn(angle), costmap.cost_at(pose.x, pose.y)
        if not self._config.gentle_turns:
            return self._checked(Velocity(yaw_rate=w), pose, costmap, math.inf)
        room = 0.0 if cost is None else float(costmap.clearances[cost])
        most = min(self.desired_speed, self.speed_limit, self._braking)
        v = side * most * max(math.cos(angle), 0.0)
        if math.isfinite(room):  # a bend leads aside by its diameter
            v = side * min(abs(v), abs(w) * room / 2.0)
        result = self._checked(Velocity(v, yaw_rate=w), pose, costmap, math.inf)
        if v == 0.0 or result.status is ControlStatus.SUCCEEDED:
            return result
        return self._checked(Velocity(yaw_rate=w), pose, costmap, math.inf)

    def _turn_instead(self, carrot: SE2, pose: SE2, costmap: Costmap) -> ControlResult | None:
        """Return a turn on the spot where no arc is free and the path leads aside."""
        angle = math.atan2(carrot.y, carrot.x)
        aside = abs(angle) >= self._config.rotate_instead_min_angle
        if self._side_of(carrot) < 0.0 or not (self._config.use_rotate_to_heading and aside):
            return None
        result = self._checked(Velocity(yaw_rate=self._turn(angle)), pose, costmap, math.inf)
        return result if result.status is ControlStatus.SUCCEEDED else None

    def _along(self, carrot: SE2, pose: SE2, velocity: Velocity, costmap: Costmap) -> ControlResult:
        """Return what drives the arc through a point seen from the robot, if that is free."""
        self.carrot = carrot
        command = self._pursue(carrot, pose, velocity, costmap)
        return self._checked(command, pose, costmap, math.hypot(carrot.x, carrot.y))

    def _lookahead(self, velocity: Velocity) -> float:
        """Return the distance of the point aimed at [m]."""
        config = self._config
        if not config.use_velocity_scaled_lookahead_dist:
            return float(config.lookahead_dist)
        scaled = abs(velocity.x) * config.lookahead_time
        return min(max(scaled, config.min_lookahead_dist), config.max_lookahead_dist)

    def _carrot(self, pose: SE2, distance: float, extends: bool = False) -> SE2:
        """Return the point of the path a distance away, between two poses where need be.

        Of a path that is shorter that is its end, or if it extends, a point straight on.
        """
        path = self._path.part
        gaps = paths.distances(path, pose)
        beyond = np.flatnonzero(gaps >= distance)
        if not len(beyond):
            end = SE2.from_array(path[-1])
            if not extends or len(path) < 2:
                return end
            dx, dy = path[-1, :2] - path[-2, :2]
            course = SE2(end.x, end.y, math.atan2(dy, dx))
            after = course @ SE2(distance + gaps[-1])
            return course.interpolate(after, crossing(pose, course, after, distance))
        i = int(beyond[0])
        if i == 0:
            return SE2.from_array(path[0])
        before, after = (SE2.from_array(entry) for entry in path[i - 1 : i + 1])
        return before.interpolate(after, crossing(pose, before, after, distance))

    def _regulating(self, pose: SE2, carrot: SE2) -> SE2:
        """Return the point, seen from the robot, by which bends slow down and turns begin."""
        if not self._config.use_fixed_curvature_lookahead:
            return carrot
        config = self._config
        return pose.inverse() @ self._carrot(
            pose, config.curvature_lookahead_dist, config.interpolate_curvature_after_goal
        )

    def _must_turn(self, angle: float) -> bool:
        """Return whether to turn on the spot, once started gently down to half of that angle."""
        gently = self._turning and self._config.gentle_turns
        limit = self._config.rotate_to_heading_min_angle * (0.5 if gently else 1.0)
        self._turning = self._config.use_rotate_to_heading and abs(angle) > limit
        return self._turning

    def _turn(self, angle: float) -> float:
        """Return the yaw rate that turns by an angle and comes to rest there."""
        config = self._config
        turning = Turning(
            config.rotate_to_heading_angular_vel,
            config.max_angular_accel,
            self._period,
            config.rotate_to_heading_gain,
            config.min_rotate_to_heading_angular_vel,
            config.rotate_to_heading_settled_angle,
            config.gentle_turns,
        )
        return turning.towards(angle, self._last_w)

    def _pursue(self, carrot: SE2, pose: SE2, velocity: Velocity, costmap: Costmap) -> Velocity:
        config = self._config
        regulated_by = self._regulating(pose, carrot)
        curvature = curvature_to(regulated_by.x, regulated_by.y)
        desired = config.desired_linear_vel
        speed = min(desired, self.speed_limit)
        slower = self._in_bend(desired, curvature), self._near_obstacles(desired, pose, costmap)
        regulated = min(speed, *slower)  # not one after the other: each says what it allows
        floor = min(config.regulated_linear_scaling_min_speed, speed)
        v = self._towards_goal(max(regulated, floor), pose)
        w_max = config.rotate_to_heading_angular_vel
        if config.gentle_turns and abs(v * curvature) > w_max:
            v = w_max / abs(curvature)
        v = min(v, self._braking)
        v *= self._side_of(carrot)
        return Velocity(v, yaw_rate=v * curvature)

    def _in_bend(self, speed: float, curvature: float) -> float:
        radius_min = self._config.regulated_linear_scaling_min_radius
        straight = curvature == 0.0 or radius_min == 0.0
        if not self._config.use_regulated_linear_velocity_scaling or straight:
            return speed
        return speed * min(1.0 / abs(curvature) / radius_min, 1.0)

    def _near_obstacles(self, speed: float, pose: SE2, costmap: Costmap) -> float:
        config, cost = self._config, costmap.cost_at(pose.x, pose.y)
        used = config.cost_scaling_dist > 0.0 and config.inflation_cost_scaling_factor > 0.0
        if not (config.use_cost_regulated_linear_velocity_scaling and used) or cost is None:
            return speed
        if not FREE < cost <= INSCRIBED:
            return speed
        room = float(costmap.clearances[cost])
        if math.isinf(room) or not config.costmaps_own_distances:
            room = -math.log(cost / MAX_NON_OBSTACLE) / config.inflation_cost_scaling_factor
        distance = self._footprint.inscribed_radius + room
        return speed * min(config.cost_scaling_gain * distance / config.cost_scaling_dist, 1.0)

    def _towards_goal(self, speed: float, pose: SE2) -> float:
        config = self._config
        remaining = max(self._path.length, pose.distance(self._path.goal))
        if remaining >= config.approach_velocity_scaling_dist:
            return speed
        slow = speed * remaining / config.approach_velocity_scaling_dist
        return min(max(slow, config.min_approach_linear_velocity), speed)

    def _checked(
        self, command: Velocity, pose: SE2, costmap: Costmap, reach: float
    ) -> ControlResult:
        """Return the command, or NO_VALID_CONTROL where its arc collides before the carrot."""
        config = self._config
        duration = config.max_allowed_time_to_collision_up_to_carrot
        if command.x != 0.0:
            duration = min(duration, reach / abs(command.x))
        if config.use_collision_detection:
            arc = rollout(pose, command, duration, costmap.frame.resolution)
            if "lookahead_collision_arc" in self.wanted:
                self.shown["lookahead_collision_arc"] = Plan(arc)
            if problem := collision_ahead(costmap, self._footprint, arc):
                self._last_w = 0.0
                return ControlResult(ControlStatus.NO_VALID_CONTROL, message=problem)
        self._last_w = command.yaw_rate
        return ControlResult(ControlStatus.SUCCEEDED, command)
