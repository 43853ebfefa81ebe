"""The track: the pose from one update of the particles to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Estimate, Hypothesis, Status, conclude

_ELSEWHERE = 0.5  # from where odometry leads, beyond which no scan has corrected a pose [m], [rad]


@dataclass
class Track:
    """What was concluded last, and from which odometry.

    Attributes:
        updated_at: Odometry at the last update of the particles; None after a new start.
        best: The hypothesis that was believed last; None after a new start.
        estimate: What it amounted to.
    """

    updated_at: SE2 | None = None
    best: Hypothesis | None = None
    estimate: Estimate | None = None

    def due(self, T_odom_base: SE2, config: AmclConfig) -> bool:
        """Tell whether the robot moved enough, each coordinate by itself as in nav2_amcl."""
        if self.updated_at is None:
            return True
        last = self.updated_at
        far = max(abs(T_odom_base.x - last.x), abs(T_odom_base.y - last.y)) > config.update_min_d
        return far or abs(wrap(T_odom_base.theta - last.theta)) > config.update_min_a

    def step(self, T_odom_base: SE2) -> SE2 | None:
        """Return the motion since the last update of the particles, and begin the next step."""
        last, self.updated_at = self.updated_at, T_odom_base
        return None if last is None else last.inverse() @ T_odom_base

    def conclude(self, best: Hypothesis, T_odom_base: SE2, config: AmclConfig) -> Estimate:
        """Believe a hypothesis; return what it amounts to."""
        last, estimate = self.estimate, conclude(best, T_odom_base, config)
        if last is not None and estimate.status is Status.LOST:
            step = (last.T_map_odom @ T_odom_base).inverse() @ best.T_map_base
            elsewhere = math.hypot(step.x, step.y) > _ELSEWHERE or abs(step.theta) > _ELSEWHERE
            estimate = replace(estimate, strayed=last.strayed or elsewhere)
        self.best, self.estimate = best, estimate
        return estimate
