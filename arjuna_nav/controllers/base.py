"""What every controller is and returns."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

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
        message: What went wrong, with numbers; empty on success.
    """

    status: ControlStatus
    velocity: Velocity = STILL
    message: str = ""


class Controller(Protocol):
    """Follows a path. Pose, path and costmap are of one frame; see `Costmap.seen_from`.

    Attributes:
        speed_limit: Greatest forward speed from now on [m/s]; inf for none.
    """

    speed_limit: float

    def set_path(self, path: NDArray[np.float64]) -> None:
        """Take a path `(N, 3) float64`; a path to the same goal keeps what was reached."""
        ...

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        """Return the velocity to drive until the next call."""
        ...
