"""What the navigator is told, what it says is to be done, and how it says that it goes."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.base import PlanResult
from arjuna_nav.trees.exchange import Ask, TreeState, Withdraw

GLOBAL_COSTMAP = "global_costmap"
LOCAL_COSTMAP = "local_costmap"


@dataclass(frozen=True)
class Outcome:
    """How something asked for ended.

    Attributes:
        code: nav2_msgs' error code, 0 for success.
        message: What went wrong; empty on success.
    """

    code: int = 0
    message: str = ""


@dataclass(frozen=True)
class NavigatorState:
    """What the navigator is told at each tick. Outcomes are told once.

    Attributes:
        now: Time [s].
        T_map_base: Pose of the robot, None where it is not known.
        speed: Forward speed [m/s].
        plan: Outcome of the path asked for last.
        path_valid: Whether the path asked about last is free.
        follow: Outcome of following the path given last.
        behavior: Outcome of the recovery asked for last.
        cleared: Costmaps that have been cleared.
        goals: New goals, to be gone to from now on.
        cancel: Whether to stop for good.
        tree: What a behavior tree is told.
    """

    now: float
    T_map_base: SE2 | None = None
    speed: float = 0.0
    plan: PlanResult | None = None
    path_valid: bool | None = None
    follow: Outcome | None = None
    behavior: Outcome | None = None
    cleared: frozenset[str] = frozenset()
    goals: tuple[SE2, ...] | None = None
    cancel: bool = False
    tree: TreeState = field(default_factory=lambda: TreeState(0.0))


@dataclass(frozen=True)
class Stop:
    """Stop following and any recovery."""


@dataclass(frozen=True)
class Clear:
    """Clear a costmap."""

    costmap: str


@dataclass(frozen=True, eq=False)
class CheckPath:
    """Say whether a path `(N, 3) float64` is free of obstacles, at once."""

    path: NDArray[np.float64]


@dataclass(frozen=True)
class ComputePath:
    """Plan from where the robot is through the goals to the last."""

    goals: tuple[SE2, ...]


@dataclass(frozen=True, eq=False)
class Follow:
    """Follow a path `(N, 3) float64` from now on."""

    path: NDArray[np.float64]


class Recovery(enum.Enum):
    """What is done in turn to get on again."""

    CLEAR = enum.auto()
    SPIN = enum.auto()
    WAIT = enum.auto()
    BACK_UP = enum.auto()


@dataclass(frozen=True)
class Recover:
    """Run a recovery behaviour; never CLEAR, which `Clear` says."""

    recovery: Recovery


class Ending(enum.Enum):
    """How navigation ended."""

    SUCCEEDED = enum.auto()
    ABORTED = enum.auto()
    CANCELED = enum.auto()


@dataclass(frozen=True)
class Finish:
    """Stop all: navigation has ended, with the error that ended it. Nothing comes after it."""

    ending: Ending
    error_code: int = 0
    error_msg: str = ""


Command = Stop | Clear | CheckPath | ComputePath | Follow | Recover | Finish | Ask | Withdraw


@dataclass(frozen=True)
class Feedback:
    """How navigation goes, as NavigateToPose's feedback has it.

    Attributes:
        navigation_time: Since the goal came [s].
        estimated_time_remaining: At the present speed [s]; 0 where that says nothing.
        number_of_recoveries: So far.
        distance_remaining: Along the path [m].
        number_of_poses_remaining: Goals not yet passed.
    """

    navigation_time: float
    estimated_time_remaining: float
    number_of_recoveries: int
    distance_remaining: float
    number_of_poses_remaining: int


def progress(
    state: NavigatorState,
    start: float,
    path: NDArray[np.float64] | None,
    recoveries: int,
    poses: int,
) -> Feedback:
    """Return how navigation goes.

    Args:
        state: What is known.
        start: Time at which the goal came [s].
        path: What is followed `(N, 3) float64`, None where there is no path yet.
        recoveries: So far.
        poses: Goals not yet passed.

    Source: nav2_bt_navigator: the time left is distance by speed where the speed is above 0.01 m/s
        and the distance above 0.1 m.
    """
    distance = 0.0
    if path is not None and len(path) and state.T_map_base is not None:
        distance = paths.remaining(path, state.T_map_base)
    speed = abs(state.speed)
    left = distance / speed if speed > 0.01 and distance > 0.1 else 0.0
    return Feedback(state.now - start, left, recoveries, distance, poses)
