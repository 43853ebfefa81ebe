"""A controller that drives by a trained policy: `plugin: "learned_controller:Learned"`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from learned_policy import Floats, Policy

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import NO_PATH, ControlResult, ControlStatus, TrackedPath
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_sim.learning.task import goals_seen, observed


@dataclass(frozen=True)
class LearnedConfig:
    """Parameters of the controller."""

    policy: str = param("policy.npz", "The policy's file, beside this module.", path=True)
    lookahead: float = param(
        1.5, "Distance along the path of the point that is the goal.", unit="m", minimum=0.1
    )


class Learned:
    """Drives to a point ahead on the path, by the obstacles of the costmap.

    What the policy learned of scans it sees of the costmap: the nearest obstacle of each sector.
    The goal's point and the velocity come from path, localization and odometry.
    """

    Config = LearnedConfig

    def __init__(
        self, config: LearnedConfig, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        self._policy = Policy.load(Path(__file__).parent / config.policy)
        self._track, self._lookahead = TrackedPath(search=2.0), config.lookahead
        self._bounds = 2.0 * np.maximum(-self._policy.low, self._policy.high).astype(np.float64)
        self.desired_speed = float(self._policy.high[0])
        self.speed_limit, self.carrot = math.inf, None

    @property
    def path(self) -> Floats:
        """The part of the path that is still ahead, `(N, 3)`."""
        return self._track.ahead

    def set_path(self, path: Floats) -> None:
        """Take a path `(N, 3)`."""
        self._track.replace(path)

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        """Return what the policy does."""
        if not len(self.path):
            return NO_PATH
        self._track.advance(pose)
        policy, ahead = self._policy, self._track.within(self._lookahead)[-1]
        near = costmap.obstacles(pose.x, pose.y, policy.config.scan_reach)
        goal = goals_seen(pose.array()[None], ahead[None, :2], policy.config.goal_reach)
        aside = [velocity.y] if len(policy.low) == 3 else []
        speeds = np.array([[velocity.x, *aside, velocity.yaw_rate]])
        points = pose.inverse().apply(near)[None]
        seen = observed(policy.config, points, goal, speeds, self._bounds)
        x, *aside, yaw_rate = policy.act(seen)[0].tolist()
        slower = min(1.0, self.speed_limit / max(math.hypot(x, *aside), 1e-9))
        command = Velocity(slower * x, y=slower * sum(aside), yaw_rate=yaw_rate)
        self.carrot = SE2(goal[0, 0], goal[0, 1], 0.0)
        return ControlResult(ControlStatus.SUCCEEDED, command)
