"""MPPI: follows a path by the controls whose rollouts the critics like best."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.base import (
    NO_PATH,
    ControlResult,
    ControlStatus,
    PathController,
    TrackedPath,
)
from arjuna_nav.controllers.display import Plan, Shape, Shapes
from arjuna_nav.controllers.motion import MotionLimits, rollout, steered
from arjuna_nav.controllers.mppi import critics, path_critics
from arjuna_nav.controllers.mppi.config import CRITICS, MppiConfig
from arjuna_nav.controllers.mppi.optimizer import Optimizer
from arjuna_nav.controllers.mppi.rollouts import Array, Limits, Rollouts
from arjuna_nav.controllers.mppi.scene import (
    Scene,
    free_poses,
    furthest_reached,
    grid_seen,
    path_seen,
)
from arjuna_nav.costmap.collision import collision_ahead, collision_place
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint


class MppiCritic(Protocol):
    """A critic of one's own; made of `(config)`, whose class derives from `CriticConfig`."""

    def cost(self, rollouts: Rollouts, scene: Scene) -> Array | tuple[Array, bool] | None:
        """Return each rollout's cost `(batch,) float32`, with whether all collide, or None."""
        ...


class Mppi(PathController):
    """Follows a path by model predictive path integral control.

    Args:
        xy_goal_tolerance: Where the twirling critic counts no more [m].
        period: Time between two calls [s].

    Source: nav2_mppi_controller.
    """

    Config: ClassVar[type[Any]] = MppiConfig
    _config: MppiConfig

    @staticmethod
    def shows(config: MppiConfig) -> dict[str, type[Any]]:
        """Return the topics that show its rollouts."""
        return {"trajectories": Shapes, "optimal_trajectory": Plan, "transformed_global_plan": Plan}

    def __init__(
        self, config: MppiConfig, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        path = TrackedPath(
            config.max_robot_pose_search_dist,
            inverts=config.enforce_path_inversion,
            inversion_tolerance=(config.inversion_xy_tolerance, config.inversion_yaw_tolerance),
        )
        super().__init__(config, footprint, xy_goal_tolerance, period, path)
        self._own_critics: dict[str, MppiCritic] = {
            name: CRITICS.make(getattr(config, name))
            for name in config.critics
            if name not in _CRITICS
        }
        self._optimizer = Optimizer(config)
        self._last, self._last_at = STILL, math.inf
        steered = config.motion_model == "Ackermann"
        self.turning_radius = config.AckermannConstraints.min_turning_r if steered else 0.0
        ahead, turns = (abs(config.ax_max), abs(config.ax_min)), config.az_max
        self.limits = MotionLimits(config.wz_max, *ahead, turns, turns)

    @property
    def desired_speed(self) -> float:
        return float(self._config.vx_max)

    def set_path(self, path: Floats) -> None:
        self._path.replace(path)

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        if not len(self._path.ahead):
            return NO_PATH
        self._path.advance(pose)
        if now - self._last_at > self._config.reset_period:
            self._optimizer.reset()
        self._last_at = now
        seen = pose.inverse() @ self._path.goal
        near = self._path.within(self._prune_distance())
        path = path_seen(near, pose)
        grid = grid_seen(costmap, self._footprint, pose)
        limits, velocity = self._limits(), self._last if self._config.open_loop else velocity
        scene = Scene(
            path,
            free_poses(path, grid),
            seen,
            math.hypot(seen.x, seen.y),
            len(path) - 1,
            grid,
            costmap.clearances,
            self._footprint.inscribed_radius,
            limits,
            self._config.model_dt,
            self._xy_goal_tolerance,
            costmap.inflations,
        )
        self._last = STILL
        for _ in range(1 + self._config.retry_attempt_limit):
            if self._optimizer.improve(velocity, limits, lambda r: self._judge(r, scene)):
                if self._config.visualize:
                    self.shown = self._visualized(pose, velocity, limits, near)
                command = steered(self._optimizer.advance(self._period), limits.radius)
                return self._checked(command, pose, costmap)
            self._optimizer.reset()
        where = collision_place(costmap, self._footprint, pose)
        message = f"collision ahead on all {self._config.batch_size} rollouts from {where}"
        return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)

    def _prune_distance(self) -> float:
        """Return how much of the path counts [m]: less than the rollouts reach would hold it up."""
        config = self._config
        reach = config.vx_max * config.time_steps * config.model_dt if config.reach_counts else 0.0
        return max(config.prune_distance, reach)

    def _limits(self) -> Limits:
        config = self._config
        share = self._asked_share(config.vx_max)
        return Limits(
            max(config.vx_min * share, -self.speed_limit),
            min(config.vx_max, self.speed_limit),
            config.wz_max * share,
            abs(config.ax_max),
            abs(config.ax_min),
            config.az_max,
            min(config.vy_max * share, self.speed_limit),
            abs(config.ay_max),
            abs(config.ay_min),
            self.turning_radius,
        )

    def _judge(self, rollouts: Rollouts, scene: Scene) -> tuple[Array, bool]:
        """Return each rollout's cost by all critics, and whether all collide."""
        reached = furthest_reached(rollouts.x[-1], rollouts.y[-1], scene.path)
        scene = scene._replace(furthest=reached)
        costs, blocked = np.zeros(rollouts.x.shape[1], np.float32), False
        for name in self._config.critics:
            own = getattr(self._config, name)
            if not own.enabled:
                continue
            layer = getattr(own, "inflation_layer_name", None)
            seen = scene if layer is None else scene.inflated_by(layer)
            if name in self._own_critics:
                cost = self._own_critics[name].cost(rollouts, seen)
            else:
                cost = _CRITICS[name](own, rollouts, seen)
            if isinstance(cost, tuple):
                cost, all_collide = cost
                blocked = blocked or all_collide
            if cost is not None:
                costs += cost if own.cost_power == 1 else cost**own.cost_power
        return costs, blocked

    def _visualized(
        self, pose: SE2, velocity: Velocity, limits: Limits, near: Floats
    ) -> dict[str, Any]:
        """Return what is wanted of its rollouts: points blue near the robot and green far away.

        Source: nav2_mppi_controller, TrajectoryVisualizer, with a marker for all its points.
        """
        shown: dict[str, Any] = {}
        wanted, step = self.wanted, self._config.TrajectoryVisualizer
        rollouts = self._optimizer.rollouts
        best = np.array([each[:, 0] for each in self._optimizer.found(velocity, limits)[2:5]]).T
        best = np.column_stack((pose.apply(best[:, :2].astype(float)), best[:, 2] + pose.theta))
        if "trajectories" in wanted:
            x, y = (
                each[:: step.time_step, :: step.trajectory_step]
                for each in (rollouts.x, rollouts.y)
            )
            points = pose.apply(np.column_stack((x.ravel(), y.ravel())).astype(float))
            late = np.repeat(np.arange(len(x)) / len(x), x.shape[1])
            colours = np.column_stack((0.0 * late, late, 1.0 - late))
            late = np.arange(len(best)) / len(best)
            optimal = np.column_stack((0.0 * late, late, late))
            candidates = Shape("Candidate Trajectories", points, colours, 0.03)
            marked = Shape("Optimal Trajectory", best[:, :2], optimal, 0.03)
            shown["trajectories"] = Shapes([candidates, marked])
        if "optimal_trajectory" in wanted:
            shown["optimal_trajectory"] = Plan(best)
        if "transformed_global_plan" in wanted:
            shown["transformed_global_plan"] = Plan(near)
        return shown

    def _checked(
        self, command: Velocity, pose: SE2, costmap: Costmap, lookahead: float = 0.3
    ) -> ControlResult:
        """Return the command, or NO_VALID_CONTROL where its own arc, so long [s], collides."""
        arc = rollout(pose, command, lookahead, costmap.frame.resolution)
        if problem := collision_ahead(costmap, self._footprint, arc):
            self._optimizer.reset()
            return ControlResult(ControlStatus.NO_VALID_CONTROL, message=problem)
        self._last = command
        return ControlResult(ControlStatus.SUCCEEDED, command)


_CRITICS: dict[str, Callable[..., Any]] = {
    "ConstraintCritic": critics.constraint,
    "CostCritic": critics.cost_critic,
    "ObstaclesCritic": critics.obstacles_critic,
    "GoalCritic": critics.goal,
    "GoalAngleCritic": critics.goal_angle,
    "PreferForwardCritic": critics.prefer_forward,
    "TwirlingCritic": critics.twirling,
    "VelocityDeadbandCritic": critics.deadband,
    "PathAlignCritic": path_critics.path_align,
    "PathFollowCritic": path_critics.path_follow,
    "PathAngleCritic": path_critics.path_angle,
}
"""Each returns the rollouts' costs or None; those of obstacles also whether all collide."""
