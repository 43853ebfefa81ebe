"""DWB: of sampled velocities within reach, the one whose trajectory the critics like best."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import (
    NO_PATH,
    ControlResult,
    ControlStatus,
    PathController,
    TrackedPath,
)
from arjuna_nav.controllers.checkers import is_there
from arjuna_nav.controllers.display import Cloud, Evaluation, Plan, Shapes
from arjuna_nav.controllers.dwb.config import (
    AGGREGATIONS,
    CRITICS,
    NAV2_CRITICS,
    DwbConfig,
    ListedDwbConfig,
)
from arjuna_nav.controllers.dwb.distances import path_cells, spread_distances
from arjuna_nav.controllers.dwb.evaluation import DwbCritic, Evaluated, Trials, simulated
from arjuna_nav.controllers.dwb.oscillation import Oscillation
from arjuna_nav.controllers.dwb.trajectories import Dynamics, Robot, Scoring, Weights, score_all
from arjuna_nav.controllers.motion import MotionLimits
from arjuna_nav.costmap.collision import collision_place
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


class Dwb(PathController):
    """Follows a path by the dynamic window approach with critics.

    Args:
        xy_goal_tolerance: Where the position counts as reached and only the heading is left [m].
        period: Time between two calls [s].

    Source: Fox, Burgard and Thrun, The dynamic window approach to collision avoidance, 1997;
        nav2_dwb_controller.
    """

    Config: ClassVar[type[Any]] = DwbConfig
    _config: DwbConfig

    @staticmethod
    def config_for(values: Mapping[str, Any]) -> type[DwbConfig]:
        """Return the parameters; those of critics have Nav2's defaults where a file lists them."""
        return ListedDwbConfig if "critics" in values else DwbConfig

    @staticmethod
    def shows(config: DwbConfig) -> dict[str, type[Any]]:
        """Return the topics that show how it chooses."""
        plans = {"transformed_global_plan": Plan, "local_plan": Plan}
        return {"evaluation": Evaluation, "marker": Shapes, "cost_cloud": Cloud, **plans}

    def __init__(
        self, config: DwbConfig, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        given = config.xy_goal_tolerance
        # A greater one than the goal checker's would leave it turning short of the goal for ever.
        tolerance = xy_goal_tolerance if given is None else min(given, xy_goal_tolerance)
        super().__init__(config, footprint, tolerance, period, TrackedPath(config.prune_distance))
        self._sim_period: float | None = None
        if config.trajectory_generator_name.endswith("LimitedAccelGenerator"):
            self._sim_period = period if config.sim_period is None else config.sim_period
        self._oscillation = Oscillation(config.Oscillation)
        self._own_critics: dict[str, DwbCritic] = {
            name: CRITICS.make(getattr(config, name))
            for name in config.critics
            if name not in NAV2_CRITICS
        }
        self._arrived = False
        ahead, turns = (config.acc_lim_x, -config.decel_lim_x), config.acc_lim_theta
        self.limits = MotionLimits(config.max_vel_theta, *ahead, turns, -config.decel_lim_theta)

    @property
    def desired_speed(self) -> float:
        return float(min(self._config.max_vel_x, self._fastest))

    @property
    def _fastest(self) -> float:
        """Greatest speed in any direction [m/s]."""
        most: float = self._config.max_speed_xy
        return most if most >= 0.0 else math.inf

    def set_path(self, path: Floats) -> None:
        if self._path.replace(path):
            self._arrived = False
        self._oscillation.reset()  # as Nav2, whatever the goal: else it may stand for long

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        config = self._config
        if not len(self._path.ahead):
            return NO_PATH
        self._path.advance(pose)
        self._arrived = is_there(pose, self._path.goal, self._xy_goal_tolerance, self._arrived)
        samples = self._samples(velocity)
        near, scores = self._near_path(pose, costmap), self._velocity_scores(samples, velocity)
        base = self._base_scores(scores, len(samples))
        scoring = self._scoring(samples, base, pose, velocity, costmap, near[:, :2])
        if self._own_critics:
            trials = Trials(samples, simulated(scoring, costmap.frame), pose, near, costmap)
            scores |= {name: own.scores(trials) for name, own in self._own_critics.items()}
            scoring = scoring._replace(base=self._base_scores(scores, len(samples)))
        best = int(score_all(scoring, config.short_circuit_trajectory_evaluation))
        evaluated = Evaluated(config, scoring, scores, best)
        if self.wanted:
            self.shown = evaluated.shown(self.wanted, near, costmap.frame)
        if best < 0:
            where = collision_place(costmap, self._footprint, pose)
            message = f"collision ahead at every one of {len(samples)} velocities from {where}"
            message += evaluated.details() if config.debug_trajectory_details else ""
            return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)
        chosen = evaluated.first_velocity() if config.limit_vel_cmd_in_traj else samples[best]
        v, side, w = (float(value) for value in chosen)
        command = Velocity(v, y=side, yaw_rate=w)
        self._oscillation.take(command, pose, now)
        return ControlResult(ControlStatus.SUCCEEDED, command)

    def _samples(self, velocity: Velocity) -> Floats:
        """Return the velocities within reach, `(N, 3) float64` of `(v, side, w)`."""
        config = self._config
        fastest = min(self._fastest, self.speed_limit)
        reach = config.sim_time if self._sim_period is None else self._sim_period
        v_max, side_max = min(config.max_vel_x, fastest), min(config.max_vel_y, fastest)
        v = _spaced(
            max(min(config.min_vel_x, v_max), velocity.x + config.decel_lim_x * reach),
            min(v_max, velocity.x + config.acc_lim_x * reach),
            config.vx_samples,
        )
        drift = min(max(velocity.y, config.min_vel_y), config.max_vel_y)  # as Nav2: not what slips
        side = _spaced(
            max(config.min_vel_y, -fastest, drift - config.acc_lim_y * reach),
            min(side_max, drift + config.acc_lim_y * reach),
            config.vy_samples,
        )
        w_max = config.max_vel_theta * self._asked_share(self.desired_speed)
        w = _spaced(
            max(-w_max, velocity.yaw_rate - config.acc_lim_theta * reach),
            min(w_max, velocity.yaw_rate + config.acc_lim_theta * reach),
            config.vtheta_samples,
        )
        grid = np.stack(np.meshgrid(v, side, w, indexing="ij"), axis=-1).reshape(-1, 3)
        speed = np.hypot(grid[:, 0], grid[:, 1])
        slow = (speed < config.min_speed_xy) & (np.abs(grid[:, 2]) < config.min_speed_theta)
        # 1e-9: of the rounding of speeds. A robot that is too fast as yet brakes as hard as it can.
        fast = speed > max(fastest, speed.min()) + 1e-9
        moves = grid.any(axis=1) | self._arrived
        return np.ascontiguousarray(grid[~slow & ~fast & moves])

    def _scoring(
        self,
        samples: Floats,
        base: Floats,
        pose: SE2,
        velocity: Velocity,
        costmap: Costmap,
        near: Floats,
    ) -> Scoring:
        config, frame = self._config, costmap.frame
        in_grid = frame.origin.inverse() @ pose
        start = np.array(
            [in_grid.x / frame.resolution, in_grid.y / frame.resolution, in_grid.theta]
        )
        points = frame.origin.inverse().apply(near) / frame.resolution
        cells = path_cells(points, *frame.shape)
        at_once = self._sim_period is not None

        def limit(acceleration: float) -> float:
            return math.inf if at_once else abs(acceleration)

        dynamics = Dynamics(
            velocity.x,
            velocity.y,
            velocity.yaw_rate,
            limit(config.acc_lim_x),
            limit(config.decel_lim_x),
            limit(config.acc_lim_y),
            limit(config.decel_lim_y),
            limit(config.acc_lim_theta),
            limit(config.decel_lim_theta),
            config.sim_time,
            config.time_granularity if config.discretize_by_time else math.inf,
            config.linear_granularity,
            config.angular_granularity,
            config.include_last_point,
        )
        outline = Robot(
            self._footprint.points / frame.resolution,
            self._footprint.circular,
            costmap.circumscribed_cost,
        )
        return Scoring(
            start,
            samples,
            base,
            dynamics,
            outline,
            self._weights(costmap, pose),
            frame.resolution,
            costmap.data,
            spread_distances(costmap.data, cells),
            spread_distances(costmap.data, cells[-1:]),
        )

    def _near_path(self, pose: SE2, costmap: Costmap) -> Floats:
        """Return the poses of the path that count, `(N, 3) float64`."""
        config = self._config
        shortened = config.shorten_transformed_plan
        near = self._path.within(config.forward_prune_distance if shortened else math.inf)
        if config.prune_plan:
            return near
        passed, half = self._path.passed, 0.5 * max(costmap.frame.shape) * costmap.frame.resolution
        beyond = np.flatnonzero(paths.distances(passed, pose) > half)
        return np.vstack((passed[beyond[-1] + 1 if len(beyond) else 0 :], near))

    def _uses(self, critic: str) -> bool:
        return critic in self._config.critics

    def _base_scores(self, by_critic: dict[str, Floats], count: int) -> Floats:
        """Return the sums of scores of a number of samples; inf where one forbids it."""
        total = np.zeros(count)
        for name, raw in by_critic.items():
            scale = getattr(self._config, name).scale
            total += scale * raw if scale > 0.0 else np.where(np.isinf(raw), raw, 0.0)
        return total

    def _velocity_scores(self, samples: Floats, velocity: Velocity) -> dict[str, Floats]:
        """Return the critics' scores that depend on the velocity alone; inf forbids it."""
        config, (v, side, w) = self._config, samples.T
        scores: dict[str, Floats] = {}
        if self._uses("Oscillation"):
            scores["Oscillation"] = np.zeros(len(samples))
            for part, (back, forth) in zip(samples.T, self._oscillation.allowed, strict=True):
                scores["Oscillation"][((part < 0) & (not back)) | ((part > 0) & (not forth))] = (
                    np.inf
                )
        if self._uses("RotateToGoal") and self._arrived:
            squares, slowing = v * v + side * side, config.RotateToGoal.slowing_factor
            if velocity.speed > config.trans_stopped_velocity:
                slower = squares < velocity.speed**2
                scores["RotateToGoal"] = np.where(slower, slowing * squares, np.inf)
            else:
                scores["RotateToGoal"] = np.where(squares == 0.0, 0.0, np.inf)
        if self._uses("PreferForward"):
            forward = config.PreferForward
            hardly = (v < forward.strafe_x) & (np.abs(w) < forward.strafe_theta)
            turning = forward.theta_scale * np.abs(w)
            scores["PreferForward"] = np.where((v < 0) | hardly, forward.penalty, turning)
        if self._uses("Twirling"):
            scores["Twirling"] = np.abs(w)
        return scores

    def _weights(self, costmap: Costmap, pose: SE2) -> Weights:
        """Return what the critics weigh now; a cell counts half its size, as in Nav2."""
        config, resolution = self._config, costmap.frame.resolution
        goal, half = self._path.goal, 0.5 * resolution
        centre, outline = config.BaseObstacle, config.ObstacleFootprint
        grids = config.PathDist, config.GoalDist, config.PathAlign, config.GoalAlign
        far = pose.distance(goal) > config.PathAlign.forward_point_distance
        aims = not self._arrived
        return Weights(
            centre.scale * self._uses("BaseObstacle"),
            centre.sum_scores,
            outline.scale * self._uses("ObstacleFootprint"),
            outline.sum_scores,
            half * config.PathDist.scale * (self._uses("PathDist") and aims),
            half * config.GoalDist.scale * (self._uses("GoalDist") and aims),
            half * config.PathAlign.scale * (self._uses("PathAlign") and far and aims),
            half * config.GoalAlign.scale * (self._uses("GoalAlign") and far and aims),
            config.PathAlign.forward_point_distance / resolution,
            config.GoalAlign.forward_point_distance / resolution,
            config.RotateToGoal.scale * (self._uses("RotateToGoal") and self._arrived),
            goal.theta - costmap.frame.origin.theta,
            config.RotateToGoal.lookahead_time,
            np.array([AGGREGATIONS.index(grid.aggregation_type) for grid in grids]),
        )


def _spaced(low: float, high: float, count: int) -> Floats:
    """Return values from low to high, two at least, and zero where it lies between them."""
    values = np.linspace(low, high, max(count, 2)) if low < high else np.array([low])
    if low < 0.0 < high and 0.0 not in values:
        values = np.sort(np.append(values, 0.0))
    return values
