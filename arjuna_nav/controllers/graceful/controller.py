"""The graceful controller: a smooth control law that ends at a pose, not at a point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, length_param, param, speed_param, yaw_rate_param
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import (
    NO_PATH,
    ControlResult,
    ControlStatus,
    PathController,
    PluginConfig,
    TrackedPath,
)
from arjuna_nav.controllers.checkers import is_there
from arjuna_nav.controllers.display import Plan, Target
from arjuna_nav.controllers.graceful.control_law import approach
from arjuna_nav.controllers.motion import MotionLimits, Turning, rollout
from arjuna_nav.costmap.collision import collision_place, first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


@dataclass(frozen=True)
class GracefulConfig(PluginConfig):
    """Parameters of the graceful controller, by Nav2's names."""

    min_lookahead: float = length_param(0.25, "Least distance of the pose aimed at.")
    max_lookahead: float = length_param(1.0, "Greatest distance of it.")
    max_robot_pose_search_dist: float = param(
        2.5, "How far along the path the robot is looked for; below 0 all along.", unit="m"
    )
    k_phi: float = param(2.0, "Ratio of the rates of turning and of coming near.", minimum=0.0)
    k_delta: float = param(1.0, "Gain on the heading.", minimum=0.0)
    beta: float = param(0.4, "How much bends slow down.", minimum=0.0)
    lambda_: float = param(2.0, "How sharply bends slow down.", minimum=0.0)
    v_linear_min: float = speed_param(0.1, "Least forward speed.")
    v_linear_max: float = speed_param(0.5, "Greatest forward speed.", minimum=0.01)
    v_angular_max: float = yaw_rate_param(1.0, "Greatest yaw rate.")
    v_angular_min_in_place: float = yaw_rate_param(0.25, "Least yaw rate on the spot.")
    rotation_scaling_factor: float = param(
        0.5,
        "Yaw rate on the spot by the angle left, in parts of v_angular_max.",
        unit="1/rad",
        minimum=0.0,
    )
    in_place_collision_resolution: float = angle_param(
        0.1, "Angle between two poses of a turn that are tested.", minimum=0.001
    )
    max_angular_accel: float = param(3.2, "Change of the yaw rate.", unit="rad/s^2", minimum=0.01)
    slowdown_radius: float = length_param(
        1.5,
        "Distance of the pose aimed at below which to slow down: the greatest speed needs a "
        "max_lookahead of as much.",
        minimum=0.01,
    )
    initial_rotation: bool = param(True, "Whether to turn on the spot towards the path.")
    initial_rotation_tolerance: float = angle_param(
        0.75, "Heading error tolerated before that turn."
    )
    allow_backward: bool = param(
        False, "Whether poses behind are driven to in reverse; initial_rotation must be false."
    )
    prefer_final_rotation: bool = param(
        True, "Whether to come straight to the goal and turn there, not in a bow."
    )

    def __post_init__(self) -> None:
        if self.allow_backward and self.initial_rotation:
            raise ConfigError(
                "'allow_backward' and 'initial_rotation' are true; valid: one of them at most"
            )


class Graceful(PathController):
    """Steers to a pose ahead on the path by Park and Kuipers' law.

    Of the poses between the lookaheads it takes the farthest that the law reaches unhindered.

    Args:
        xy_goal_tolerance: Where the position counts as reached and only the heading is left [m].
        period: Time between two calls [s].

    Source: Park and Kuipers, A smooth control law for graceful motion of differential wheeled
        mobile robots in 2D environment, ICRA 2011; nav2_graceful_controller.
    """

    Config: ClassVar[type[Any]] = GracefulConfig
    _config: GracefulConfig

    @staticmethod
    def shows(config: GracefulConfig) -> dict[str, type[Any]]:
        """Return the topics that show what it follows."""
        return {"transformed_global_plan": Plan, "local_plan": Plan, "motion_target": Target}

    def __init__(
        self, config: GracefulConfig, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        path = TrackedPath(config.max_robot_pose_search_dist, inverts=config.allow_backward)
        super().__init__(config, footprint, xy_goal_tolerance, period, path)
        self._turning = Turning(
            config.v_angular_max,
            config.max_angular_accel,
            period,
            config.rotation_scaling_factor * config.v_angular_max,
            config.v_angular_min_in_place,
        )
        fast, turns = config.v_angular_max, config.max_angular_accel
        self.limits = MotionLimits(fast, angular_acceleration=turns, angular_deceleration=turns)
        self._arrived = self._rotating = False
        self._last_w = 0.0

    @property
    def desired_speed(self) -> float:
        return float(self._config.v_linear_max * self._slowed)

    @property
    def _slowed(self) -> float:
        """Share of the greatest speed that is driven, however far the goal is."""
        return float(min(self._config.max_lookahead / self._config.slowdown_radius, 1.0))

    def set_path(self, path: Floats) -> None:
        leads_elsewhere = self._path.replace(path)
        self._arrived = self._arrived and not leads_elsewhere
        self._rotating = self._config.initial_rotation

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        if not len(self._path.ahead):
            return NO_PATH
        self._path.advance(pose)
        goal = self._path.goal
        self._arrived = is_there(pose, goal, self._xy_goal_tolerance, self._arrived)
        self.carrot = None
        if self._arrived:
            return self._turn(wrap(goal.theta - pose.theta), pose, costmap)
        for target in self._targets(pose):
            seen, facing = self._seen(target, pose)
            angle = math.atan2(seen.y, seen.x)
            tolerance = self._config.initial_rotation_tolerance
            self._rotating = self._rotating and abs(angle) > tolerance
            if self._rotating:
                self.carrot = pose.inverse() @ target
                return self._turn(angle, pose, costmap)
            command = self._approach(seen, pose, facing, costmap)
            if command is not None:
                self.carrot, self._last_w = pose.inverse() @ target, command.yaw_rate
                if self.wanted:
                    self.shown["motion_target"] = Target(target)
                return ControlResult(ControlStatus.SUCCEEDED, command)
        self._last_w = 0.0
        where = collision_place(costmap, self._footprint, pose)
        message = f"collision ahead on every approach to the path from {where}"
        return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)

    def _targets(self, pose: SE2) -> list[SE2]:
        """Return the poses to steer to, the farthest first."""
        config, ahead = self._config, self._path.part
        gaps = paths.distances(ahead, pose)
        near = (gaps >= config.min_lookahead) & (gaps <= config.max_lookahead)
        leaves = np.flatnonzero(gaps > config.max_lookahead)
        near[leaves[0] if len(leaves) else len(near) :] = False
        indices = np.flatnonzero(near)[::-1]
        if not len(indices):
            indices = np.array([len(ahead) - 1 if not len(leaves) else leaves[0]])
        return [SE2.from_array(ahead[i]) for i in indices[:: max(len(indices) // 8, 1)]]

    def _seen(self, target: SE2, pose: SE2) -> tuple[SE2, SE2]:
        """Return a pose of the path seen from the end of the robot that goes first, and that end.

        Near the goal the heading is that of the way there, if the turn to its own comes last.
        """
        seen, facing = pose.inverse() @ target, SE2()
        if self._config.allow_backward and seen.x < 0.0:
            facing = SE2(theta=math.pi)
        seen = facing.inverse() @ seen @ facing
        if self._config.prefer_final_rotation and self._path.length < self._config.max_lookahead:
            seen = SE2(seen.x, seen.y, math.atan2(seen.y, seen.x))
        return seen, facing

    def _approach(self, seen: SE2, pose: SE2, facing: SE2, costmap: Costmap) -> Velocity | None:
        """Return the velocity towards a pose seen from an end of the robot, None if it collides."""
        config = self._config
        v_max = min(config.v_linear_max, self.speed_limit / self._slowed)
        law = np.array([config.k_phi, config.k_delta, config.beta, config.lambda_])
        limits = np.array(
            [min(config.v_linear_min, v_max), v_max, config.slowdown_radius, config.v_angular_max]
        )
        poses, v, w = approach(seen.array(), law, limits, costmap.frame.resolution)
        within = min(self.speed_limit / max(v, 1e-9), 1.0)  # the least speed may be above it
        poses[:, :2] = (pose @ facing).apply(poses[:, :2])
        poses[:, 2] += pose.theta
        hit = first_collision(costmap, self._footprint, poses)
        if hit is None and self.wanted:
            near = self._path.within(config.max_lookahead)
            self.shown |= {"transformed_global_plan": Plan(near), "local_plan": Plan(poses)}
        command = Velocity(v * math.cos(facing.theta), yaw_rate=w)
        return command.scaled(within) if hit is None else None

    def _turn(self, angle: float, pose: SE2, costmap: Costmap) -> ControlResult:
        """Return a turn on the spot, or NO_VALID_CONTROL where it would collide."""
        command = Velocity(yaw_rate=self._turning.towards(angle, self._last_w))
        duration = min(abs(angle), 1.0) / max(abs(command.yaw_rate), 1e-3)  # a radian ahead
        step = self._config.in_place_collision_resolution
        arc = rollout(pose, command, duration, costmap.frame.resolution, step)
        turn = self._turned(command, arc, costmap)
        self._last_w = turn.velocity.yaw_rate
        return turn
