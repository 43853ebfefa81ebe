"""The interface of controllers, and the path that each of them follows."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param
from arjuna_core.errors import ArjunaError
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.costmap.collision import first_collision
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths


class ControlStatus(enum.IntEnum):
    """Outcomes of following; the values are nav2_msgs/action/FollowPath's error codes."""

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
        message: What went wrong, with numbers; empty where nothing did.
    """

    status: ControlStatus
    velocity: Velocity = STILL
    message: str = ""


@dataclass(frozen=True)
class PluginConfig:
    """Parameters that the controllers of Nav2 share."""

    transform_tolerance: float = duration_param(
        0.1, "How old the robot's pose on the path may be, where that is more than the costmap's."
    )


def with_defaults(config: Callable[..., Any], **values: Any) -> Any:
    """Declare a field of a critic's parameters of which some have other defaults."""
    return field(default_factory=partial(config, **values))


NO_PATH = ControlResult(ControlStatus.INVALID_PATH, message="no path was set")


class PathError(ArjunaError, ValueError):
    """A path has no pose or the wrong shape."""


class Controller(Protocol):
    """Follows a path. Pose, path and costmap are of one frame; see `Costmap.seen_from`.

    A class of controllers has `Config`, the dataclass of its parameters, and is made of
    `(config, footprint, xy_goal_tolerance [m], period [s])`. One that never turns on the spot has
    `turning_radius`, of the tightest bend [m], or inf where it knows none: by that final approach
    and escape plan; where nothing says a radius, they do not take over from it. One whose
    parameters bound more than the speed has `limits`, of motion.py, to which both keep.

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
    def path(self) -> Floats:
        """The part of the path that is still ahead, `(N, 3) float64`."""
        ...

    def set_path(self, path: Floats) -> None:
        """Take a path `(N, 3) float64`; a path to the same goal keeps what was reached."""
        ...

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        """Return the velocity to drive until the next call."""
        ...


def checked_path(path: Floats) -> Floats:
    """Return a path that can be followed.

    Raises:
        PathError: It is empty or not `(N, 3)`.
    """
    if path.ndim != 2 or path.shape[1] != 3 or not len(path):
        raise PathError(f"a path must be (N, 3) with N > 0, got {path.shape}")
    return path


class TrackedPath:
    """A path that is followed, and how far along it the robot is.

    Args:
        search: How far along the path the robot is looked for; below 0 all along [m].
        same_goal: Distance between the ends of two paths to the same goal [m].
        inverts: Whether the path is followed part by part where it changes its direction.
        inversion_tolerance: Distance [m] and angle [rad] from the end of a part within which the
            next one begins; None where that end is the nearest pose.
    """

    def __init__(
        self,
        search: float,
        same_goal: float = 0.1,
        *,
        inverts: bool = False,
        inversion_tolerance: tuple[float, float] | None = None,
    ) -> None:
        self._search = math.inf if search < 0.0 else search
        self._same_goal = same_goal
        self._path = np.empty((0, 3))
        self._index = self._end = 0
        self._inverts, self._inversion_tolerance = inverts, inversion_tolerance

    @property
    def part(self) -> Floats:
        """The poses ahead up to the next inversion, `(N, 3) float64`."""
        return self._path[self._index : self._end]

    @property
    def ahead(self) -> Floats:
        """The poses from the one nearest to the robot on, `(N, 3) float64`."""
        return self._path[self._index :]

    @property
    def passed(self) -> Floats:
        """The poses before the one nearest to the robot, `(N, 3) float64`."""
        return self._path[: self._index]

    @property
    def goal(self) -> SE2:
        """The last pose."""
        return SE2.from_array(self._path[-1])

    @property
    def length(self) -> float:
        """Length of what is ahead [m]."""
        return paths.length(self.ahead)

    def replace(self, path: Floats) -> bool:
        """Take another path; return whether it leads to another goal.

        Raises:
            PathError: The path is empty or not `(N, 3)`.
        """
        checked_path(path)
        gap = np.hypot(*(path[-1, :2] - self._path[-1, :2])) if len(self._path) else math.inf
        self._path, self._index = path, 0
        self._end = self._part_end()
        return bool(gap > self._same_goal)

    def advance(self, pose: SE2) -> None:
        """Find the robot on the path; it never goes back."""
        self._index = paths.nearest(self._path[: self._end], pose, self._index, self._search)
        if self._end < len(self._path) and self._inverted(pose):
            self._index = self._end - 1
            self._end = self._part_end()

    def _part_end(self) -> int:
        return paths.part_end(self._path, self._index) if self._inverts else len(self._path)

    def _inverted(self, pose: SE2) -> bool:
        """Return whether the robot is at the end of a part."""
        if self._inversion_tolerance is None:
            return self._index == self._end - 1
        end, (near, turned) = SE2.from_array(self._path[self._end - 1]), self._inversion_tolerance
        return pose.distance(end) <= near and abs(wrap(end.theta - pose.theta)) <= turned

    def within(self, distance: float) -> Floats:
        """Return the beginning of the part ahead, two poses at least where there are two [m]."""
        ahead = self.part
        return ahead[: max(int(paths.along(ahead).searchsorted(distance, side="right")), 2)]


class PathController:
    """The robot, the path and the values on display that the controllers here have.

    Attributes:
        asked_limit: The speed limit that others ask for, a zone's [m/s]; inf for none. Nav2's DWB
            and MPPI turn slower by it too, so that bends stay the same.
        wanted: The topics of values that somebody listens to.
        shown: Values by topic, of the last command.
    """

    def __init__(
        self,
        config: Any,
        footprint: Footprint,
        xy_goal_tolerance: float,
        period: float,
        path: TrackedPath,
    ) -> None:
        self._config, self._footprint, self._path = config, footprint, path
        self._xy_goal_tolerance, self._period = xy_goal_tolerance, period
        self.speed_limit = self.asked_limit = math.inf
        self.carrot: SE2 | None = None
        self.wanted: frozenset[str] = frozenset()
        self.shown: dict[str, Any] = {}

    @property
    def path(self) -> Floats:
        """The part of the path that is still ahead, `(N, 3) float64`."""
        return self._path.ahead

    def _asked_share(self, fastest: float) -> float:
        """Return the share of a greatest speed [m/s] that others ask for, 0..1."""
        return min(1.0, self.asked_limit / fastest) if fastest > 0.0 else 1.0

    def _turned(self, command: Velocity, arc: Floats, costmap: Costmap) -> ControlResult:
        """Return a turn on the spot, or NO_VALID_CONTROL where its poses `(N, 3)` collide."""
        if self._is_free(arc, costmap):
            return ControlResult(ControlStatus.SUCCEEDED, command)
        message = f"turning at ({arc[0, 0]:.2f}, {arc[0, 1]:.2f}) would collide"
        return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)

    def _is_free(self, poses: Floats, costmap: Costmap) -> bool:
        """Return whether the robot may be at all of the poses `(N, 3)`."""
        return first_collision(costmap, self._footprint, poses) is None


def slow_down(controller: Controller, limit: float, asked: float) -> None:
    """Limit a controller's forward speed [m/s], of which others ask for a limit alone."""
    controller.speed_limit = limit
    if isinstance(controller, PathController):
        controller.asked_limit = asked
