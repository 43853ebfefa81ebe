"""A controller and a planner as a user would write them: named `module:Class` in a file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import param
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers import ControlResult, ControlStatus
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import PlanResult, PlanStatus

CRAWLER = f"{__name__}:Crawler"
STRAIGHT = f"{__name__}:Straight"


@dataclass(frozen=True)
class CrawlerConfig:
    speed: float = param(0.1, "Speed.", unit="m/s", minimum=0.0)


class Crawler:
    """Drives straight ahead."""

    Config: ClassVar[type[Any]] = CrawlerConfig

    def __init__(
        self, config: CrawlerConfig, footprint: Footprint, xy_goal_tolerance: float, period: float
    ) -> None:
        self.desired_speed = config.speed
        self.path = np.empty((0, 3))
        self.speed_limit = math.inf
        self.carrot: SE2 | None = None

    def set_path(self, path: NDArray[np.float64]) -> None:
        self.path = path

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        return ControlResult(ControlStatus.SUCCEEDED, Velocity(self.desired_speed))


@dataclass(frozen=True)
class StraightConfig:
    points: int = param(2, "Poses of a path.", minimum=2)


class Straight:
    """Plans a straight line, whatever stands there."""

    Config: ClassVar[type[Any]] = StraightConfig

    def __init__(self, config: StraightConfig, footprint: Footprint) -> None:
        self._config = config

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        ratio = np.linspace(0.0, 1.0, self._config.points)[:, None]
        path = start.array() + ratio * (goal.array() - start.array())
        return PlanResult(PlanStatus.SUCCEEDED, path)
