"""The protocol of global planners, their result, how they are stopped, and the list of them."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.config import length_param, param
from arjuna_core.errors import ArjunaError
from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap


class PlanStatus(enum.IntEnum):
    """End of planning; the values are nav2_msgs/action/ComputePathToPose's error codes."""

    SUCCEEDED = 0
    UNKNOWN = 200
    INVALID_PLANNER = 201
    TF_ERROR = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    START_OCCUPIED = 205
    GOAL_OCCUPIED = 206
    TIMEOUT = 207
    NO_VALID_PATH = 208

    def code(self, through: bool) -> int:
        """Return the error code of the action, ComputePathThroughPoses' where it is through poses.

        Source: nav2_msgs numbers the failures of ComputePathThroughPoses 100 above these.
        """
        return int(self) + (100 if through and self else 0)

    @staticmethod
    def of_code(code: int) -> PlanStatus | None:
        """Return the status of either action's error code; None where it is another's."""
        statuses = {each.code(through): each for each in PlanStatus for through in (False, True)}
        return statuses.get(code)


@dataclass(frozen=True, eq=False)
class PlanResult:
    """A path, or why there is none.

    Attributes:
        path: `(N, 3) float64` [m, m, rad] in the costmap's frame from start to goal; empty unless
            it succeeded.
        message: What went wrong, with numbers; empty on success.
        expansions: `(M, 3) float64` the poses that a search expanded, where it keeps them.
    """

    status: PlanStatus
    path: Floats
    message: str = ""
    expansions: Floats | None = None

    @staticmethod
    def failed(status: PlanStatus, message: str) -> PlanResult:
        """Return a result without path."""
        return PlanResult(status, np.empty((0, 3)), message)


@dataclass(frozen=True)
class GridPlannerConfig:
    """Parameters that planners on a grid have in common."""

    tolerance: float = length_param(0.5, "How far from a blocked goal the path may end.")
    allow_unknown: bool = param(True, "Whether paths may cross unknown space.")
    escape_radius: float = length_param(
        3.0, "How far a start too near to an obstacle is led out of it.", theirs=0.0
    )


class Planner(Protocol):
    """Finds a path on a costmap.

    A class of planners has `Config`, the dataclass of its parameters, and is made of
    `(config, footprint)`. One whose paths the outline can follow, driven ahead or back, has
    `checks_outline = True`: they are taken as they are. One for steered robots has
    `turning_radius`, of its tightest bend [m].
    """

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        """Plan between two poses in the costmap's frame; may raise PlanStoppedError."""
        ...


class PlanStoppedError(ArjunaError):
    """Nobody waits for the plan any more."""


_NEVER = np.zeros(1, np.bool_)
_stop: ContextVar[Bools] = ContextVar("stop", default=_NEVER)


@contextmanager
def stopped_by(flag: Bools) -> Iterator[None]:
    """Let plans that are made in this context end early once a flag, `(1,) bool`, is set.

    Another thread may set it: compiled searches look at it now and then, without the GIL. A plan
    whose flag is never set does not depend on it.
    """
    token = _stop.set(flag)
    try:
        yield
    finally:
        _stop.reset(token)


def stop_flag() -> Bools:
    """Return the flag that stops the plan being made, `(1,) bool`, for a compiled search."""
    return _stop.get()


def check_stopped() -> None:
    """End the plan being made if it is to stop; called after each search and in long loops.

    Raises:
        PlanStoppedError: Its flag is set.
    """
    if _stop.get()[0]:
        raise PlanStoppedError("the plan was stopped")


def too_tight(name: str, plugin: object, radius: float) -> str:
    """Return what is to be said of a plug-in that bends tighter than a steered robot; "" for none.

    Args:
        plugin: A planner or controller, with `turning_radius` unless it turns on the spot [m].
        radius: Of the robot's tightest bend; 0 where it turns on the spot [m].
    """
    own = float(getattr(plugin, "turning_radius", 0.0))
    if own >= radius - 1e-3:
        return ""
    bends = f"bends by {own:g} m" if own else "turns on the spot"
    return f"{name} {bends}, but the robot's tightest bend is {radius:g} m (min_turning_radius)"


_HERE = "arjuna_nav.planners"
_NAVFN = "nav2_navfn_planner::NavfnPlanner"

PLANNERS = PluginTypes(
    "planner",
    {
        _NAVFN: f"{_HERE}.navfn:NavFn",
        "nav2_theta_star_planner::ThetaStarPlanner": f"{_HERE}.theta_star:ThetaStar",
        "nav2_smac_planner::SmacPlanner2D": f"{_HERE}.smac_2d:Smac2D",
        "nav2_smac_planner::SmacPlannerHybrid": f"{_HERE}.hybrid.planner:Hybrid",
        "nav2_smac_planner::SmacPlannerLattice": f"{_HERE}.hybrid.lattice:SmacLattice",
    },
    _NAVFN,
    stands_in=True,
)
