"""The rotation shim: turns on the spot towards a new path, then lets another controller follow."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import (
    angle_param,
    duration_param,
    fixed,
    length_param,
    param,
    yaw_rate_param,
)
from arjuna_core.errors import ConfigError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import (
    NO_PATH,
    Controller,
    ControlResult,
    ControlStatus,
    PathController,
    TrackedPath,
    slow_down,
)
from arjuna_nav.controllers.display import shown_by, topics_of, want
from arjuna_nav.controllers.motion import MotionLimits, Turning, gentle_turns, rollout
from arjuna_nav.controllers.plugins import CONTROLLERS
from arjuna_nav.costmap.collision import footprint_cost
from arjuna_nav.costmap.costmap import LETHAL, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


@dataclass(frozen=True)
class RotationShimConfig:
    """Parameters of the rotation shim, by Nav2's names; its primary's stand beside them."""

    primary_controller: str = fixed("", "Class of the controller that follows.")
    angular_dist_threshold: float = angle_param(0.785, "Heading error that starts a turn.")
    angular_disengage_threshold: float = angle_param(0.3925, "Heading error that ends it.")
    forward_sampling_distance: float = length_param(
        0.5, "How far ahead the path's direction is taken."
    )
    rotate_to_heading_angular_vel: float = yaw_rate_param(1.8, "Yaw rate.")
    max_angular_accel: float = param(3.2, "Change of the yaw rate.", unit="rad/s^2", minimum=0.01)
    simulate_ahead_time: float = duration_param(1.0, "How far ahead collisions are looked for.")
    max_cost_threshold: float = param(
        LETHAL,
        "Cost below the outline from which a turn counts as a collision.",
        minimum=1.0,
        maximum=LETHAL,
    )
    rotate_to_goal_heading: bool = param(False, "Whether to turn at the goal as well.")
    closed_loop: bool = param(
        True,
        "Whether a turn continues from the measured yaw rate, else from the one commanded last.",
    )
    use_path_orientations: bool = param(
        False, "Whether it turns as the path's pose looks, else towards that pose."
    )
    rotate_to_heading_once: bool = param(False, "Whether to turn for a new goal only.")
    gentle_turns: bool = gentle_turns()


class RotationShim(PathController):
    """Turns on the spot where a path begins aside, else lets its primary controller follow.

    Args:
        config: Parameters, the primary's among them.
        xy_goal_tolerance: Where only the heading is left, if it turns at the goal [m].
        period: Time between two calls [s].

    Source: nav2_rotation_shim_controller.
    """

    Config: ClassVar[type[Any]] = RotationShimConfig

    @staticmethod
    def shows(config: Any) -> Mapping[str, type[Any]]:
        """Return the topics of its primary."""
        return topics_of(config.primary_controller, config)

    @staticmethod
    def config_for(values: Mapping[str, Any]) -> type[Any]:
        """Return the shim's parameters with those of the primary that the values name.

        Raises:
            ConfigError: They name none, or one that does not exist.
        """
        name = str(values.get("primary_controller", ""))
        if not name or CONTROLLERS.resolve(name) is RotationShim:
            raise ConfigError("primary_controller must name the class of another controller")
        primary: Any = CONTROLLERS.config_of(name, values)
        return _joined(primary)

    def __init__(
        self, config: Any, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        super().__init__(config, footprint, xy_goal_tolerance, period, TrackedPath(2.5))
        limits = config.rotate_to_heading_angular_vel, config.max_angular_accel, period
        self._turn = Turning(*limits, gentle=config.gentle_turns)
        make = CONTROLLERS.resolve(config.primary_controller)
        self._primary: Controller = make(config, footprint, xy_goal_tolerance, period)
        self.limits: MotionLimits = getattr(self._primary, "limits", MotionLimits())
        rate = min(self.limits.yaw_rate, config.rotate_to_heading_angular_vel)
        self.limits = self.limits._replace(yaw_rate=rate)
        self._due = self._turning = False
        self._last_w = 0.0

    @property
    def desired_speed(self) -> float:
        return self._primary.desired_speed

    def set_path(self, path: Floats) -> None:
        other = self._path.replace(path)
        self._due = self._due or other or not self._config.rotate_to_heading_once
        self._primary.set_path(path)

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        if not len(self._path.ahead):
            return NO_PATH
        self._path.advance(pose)
        angle = self._angle(pose)
        turn = None if angle is None else self._turned_by(angle, pose, velocity, costmap)
        if turn is not None:
            self.carrot, self._last_w = None, turn.velocity.yaw_rate
            return turn
        self._turning = False
        slow_down(self._primary, self.speed_limit, self.asked_limit)
        want(self._primary, self.wanted)
        result = self._primary.compute(pose, velocity, costmap, now)
        self.shown = shown_by(self._primary)
        self.carrot = self._primary.carrot
        self._last_w = result.velocity.yaw_rate
        return result

    def _turned_by(
        self, angle: float, pose: SE2, velocity: Velocity, costmap: Costmap
    ) -> ControlResult | None:
        """Return a turn on the spot; None where it would collide, and the primary is to drive."""
        rate = velocity.yaw_rate if self._config.closed_loop else self._last_w
        command = Velocity(yaw_rate=self._turn.towards(angle, rate))
        duration = min(self._config.simulate_ahead_time, 1.0 / max(abs(command.yaw_rate), 1e-3))
        turn = self._turned(
            command, rollout(pose, command, duration, costmap.frame.resolution), costmap
        )
        if turn.status is ControlStatus.SUCCEEDED:
            return turn
        self._due = False
        return None

    def _angle(self, pose: SE2) -> float | None:
        """Return by how much to turn on the spot [rad]; None where the primary is to drive."""
        config, goal = self._config, self._path.goal
        if config.rotate_to_goal_heading and pose.distance(goal) <= self._xy_goal_tolerance:
            return wrap(goal.theta - pose.theta)
        far = paths.distances(self._path.ahead, pose) >= config.forward_sampling_distance
        if not self._due or not far.any():
            return None
        ahead = pose.inverse() @ SE2.from_array(self._path.ahead[int(np.argmax(far))])
        aside = math.atan2(ahead.y, ahead.x)
        angle = wrap(ahead.theta) if config.use_path_orientations else aside
        limit = (
            config.angular_disengage_threshold if self._turning else config.angular_dist_threshold
        )
        self._turning = self._due = abs(angle) > limit
        return angle if self._due else None

    def _is_free(self, poses: Floats, costmap: Costmap) -> bool:
        """Return whether the costs below the outline stay below what counts as a collision."""
        if not super()._is_free(poses, costmap):
            return False
        most, outline = self._config.max_cost_threshold, self._footprint
        at = map(SE2.from_array, poses)
        return most >= LETHAL or all(footprint_cost(costmap, outline, pose) < most for pose in at)


@functools.cache
def _joined(primary: Any) -> type[Any]:
    """Return a dataclass of the shim's and its primary's parameters; what both have is one."""
    bases = (RotationShimConfig, primary)
    return dataclasses.make_dataclass("RotationShimConfig", [], bases=bases, frozen=True)
