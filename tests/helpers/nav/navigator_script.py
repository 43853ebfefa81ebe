"""A navigator that is ticked by a script: outcomes instead of servers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_nav.commands import (
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    Clear,
    Command,
    ComputePath,
    Follow,
    NavigatorState,
    Outcome,
    Stop,
)
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.navigator import Navigator, NavigatorConfig
from arjuna_nav.planners.base import PlanResult, PlanStatus
from tests.nav.worlds import polyline

GOAL = SE2(4.0, 0.0, 0.0)
BOTH = frozenset({GLOBAL_COSTMAP, LOCAL_COSTMAP})
CLEAR_BOTH = [Stop(), Clear(LOCAL_COSTMAP), Clear(GLOBAL_COSTMAP)]
STRAIGHT = polyline([(0.0, 0.0), (4.0, 0.0)], 0.0)
DETOUR = polyline([(0.0, 0.0), (2.0, 1.5), (4.0, 0.0)], 0.0)


def planned(path: NDArray[np.float64] = STRAIGHT) -> PlanResult:
    return PlanResult(PlanStatus.SUCCEEDED, path)


def no_plan(status: PlanStatus = PlanStatus.NO_VALID_PATH) -> PlanResult:
    return PlanResult.failed(status, status.name)


def failed(status: ControlStatus) -> Outcome:
    return Outcome(int(status), status.name)


def followed(commands: list[Command]) -> NDArray[np.float64] | None:
    """Return the path that is to be followed from now on."""
    return next((command.path for command in commands if isinstance(command, Follow)), None)


@dataclass
class Script:
    """Ticks a navigator; each tick may be told of events."""

    navigator: Navigator = field(
        default_factory=lambda: Navigator(NavigatorConfig(), (GOAL,), start=0.0)
    )
    now: float = 0.0

    def tick(self, dt: float = 0.1, pose: SE2 = IDENTITY, **events: Any) -> list[Command]:
        self.now += dt
        return self.navigator.tick(NavigatorState(now=self.now, T_map_base=pose, **events))

    def follow(self) -> Script:
        """Come to the point where a path is followed."""
        assert self.tick() == [ComputePath((GOAL,))]
        assert followed(self.tick(plan=planned())) is STRAIGHT
        return self

    def fail_to_plan(self) -> list[Command]:
        """Let planning and its second try fail; return what the navigator does then."""
        assert self.tick(plan=no_plan()) == [Clear(GLOBAL_COSTMAP)]
        assert self.tick(cleared=frozenset({GLOBAL_COSTMAP})) == [ComputePath((GOAL,))]
        return self.tick(plan=no_plan())
