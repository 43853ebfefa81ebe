"""What every controller is and returns."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.costmap import Costmap


class ControlStatus(enum.IntEnum):
    """How following went; the values are nav2_msgs/action/FollowPath's error codes."""

    SUCCEEDED = 0
    UNKNOWN = 100
    INVALID_CONTROLLER = 101
    TF_ERROR = 102
    INVALID_PATH = 103
    PATIENCE_EXCEEDED = 104
    FAILED_TO_MAKE_PROGRESS = 105
    NO_VALID_CONTROL = 106
    CONTROLLER_TIMED_OUT = 107


@dataclass(frozen=True)
class ControlResult:
    """A velocity, or why there is none.

    Attributes:
        status: SUCCEEDED where the velocity is to be driven.
        velocity: What to drive.
        message: What went wrong, with numbers; empty where nothing did.
    """

    status: ControlStatus
    velocity: Velocity = STILL
    message: str = ""


NO_PATH = ControlResult(ControlStatus.INVALID_PATH, message="no path was set")


class PathError(ArjunaError, ValueError):
    """A path has no pose or the wrong shape."""


class Controller(Protocol):
    """Follows a path. Pose, path and costmap are of one frame; see `Costmap.seen_from`.

    A class of controllers has `Config`, the dataclass of its parameters, and is made of
    `(config, footprint, xy_goal_tolerance [m], period [s])`.

    Attributes:
        speed_limit: Greatest forward speed from now on [m/s]; inf for none.
        carrot: What it aims at, seen from the robot; None where it aims at no point.
    """

    speed_limit: float
    carrot: SE2 | None

    @property
    def desired_speed(self) -> float:
        """Greatest forward speed where nothing limits it [m/s]."""
        ...

    @property
    def path(self) -> NDArray[np.float64]:
        """The part of the path that is still ahead, `(N, 3) float64`."""
        ...

    def set_path(self, path: NDArray[np.float64]) -> None:
        """Take a path `(N, 3) float64`; a path to the same goal keeps what was reached."""
        ...

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        """Return the velocity to drive until the next call."""
        ...


def checked_path(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a path that can be followed.

    Raises:
        PathError: It is empty or not `(N, 3)`.
    """
    if path.ndim != 2 or path.shape[1] != 3 or not len(path):
        raise PathError(f"a path must be (N, 3) with N > 0, got {path.shape}")
    return path
