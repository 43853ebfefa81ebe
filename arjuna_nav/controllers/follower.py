"""Following a path to its end: controller, progress and goal checker together."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from arjuna_core.arrays import Floats
from arjuna_core.config import length_param, param, plugin_names, speed_param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers.approach import ApproachConfig, Arrival, FinalApproach
from arjuna_nav.controllers.base import Controller, ControlResult, ControlStatus, slow_down
from arjuna_nav.controllers.checkers import GoalChecker, ProgressChecker
from arjuna_nav.controllers.display import want
from arjuna_nav.controllers.escape import Escape, EscapeConfig
from arjuna_nav.controllers.motion import MotionLimits, min_turning_radius, rollout, steered
from arjuna_nav.controllers.plugins import CONTROLLERS, GOAL_CHECKERS, PROGRESS_CHECKERS
from arjuna_nav.controllers.speed_limits import ForesightConfig, allowed_speed
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.collision import collides, collision_place, first_collision
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.base import too_tight


@dataclass(frozen=True)
class FollowerConfig:
    """Parameters of following, by Nav2's names; below the plug-ins' names stand their own."""

    controller_plugins: tuple[str, ...] = plugin_names(
        ("FollowPath",), "The controllers.", CONTROLLERS
    )
    progress_checker_plugins: tuple[str, ...] = plugin_names(
        ("progress_checker",), "The progress checkers.", PROGRESS_CHECKERS
    )
    goal_checker_plugins: tuple[str, ...] = plugin_names(
        ("general_goal_checker",), "The goal checkers.", GOAL_CHECKERS
    )
    controller_frequency: float = param(
        20.0, "Commands a second.", unit="Hz", minimum=0.1, read_only=True
    )
    failure_tolerance: float = param(
        0.0, "How long a controller may find no valid command; -1 for ever.", unit="s"
    )
    stopped_velocity: float = speed_param(
        0.1, "Speed below which the robot does not brake any more."
    )
    moving_obstacle_distance: float = length_param(
        0.5, "Distance from the robot within which a moving obstacle is waited for.", theirs=0.0
    )
    min_turning_radius: float = min_turning_radius()
    gap_progress: float = length_param(
        0.05, "What a robot that squeezes through a gap moves to make progress.", maximum=1.0
    )
    foresight: ForesightConfig = field(default_factory=ForesightConfig)
    arrival: ApproachConfig = field(default_factory=ApproachConfig)
    escape: EscapeConfig = field(default_factory=EscapeConfig)
    tracker: TrackerConfig = field(default_factory=TrackerConfig)


class FollowState(enum.Enum):
    """States of following."""

    RUNNING = enum.auto()
    SUCCEEDED = enum.auto()
    FAILED = enum.auto()


@dataclass(frozen=True)
class FollowResult:
    """A velocity to drive now, and the state of following.

    Attributes:
        message: What went wrong, with numbers; empty while it goes well.
        distance: Left along the path [m].
    """

    state: FollowState
    velocity: Velocity = STILL
    error: ControlStatus = ControlStatus.SUCCEEDED
    message: str = ""
    distance: float = 0.0

    @staticmethod
    def failed(error: ControlStatus, message: str) -> FollowResult:
        """Return the end of a path that is not followed any more."""
        return FollowResult(FollowState.FAILED, error=error, message=message)


class Chosen(NamedTuple):
    """Names of the plug-ins that a path is followed with."""

    controller: str
    goal_checker: str
    progress_checker: str


def turning_radius(robot: float, controller: Controller) -> float:
    """Return the tightest bend's radius that holds [m]; 0 for none, inf where it is not known.

    Args:
        robot: The robot's [m], 0 where it is not known or it turns on the spot.
        controller: One that never turns on the spot has a radius, or inf where it knows none.
    """
    own = float(getattr(controller, "turning_radius", 0.0))
    return max(robot, own) if math.isfinite(own) else robot or own


class PathFollower:
    """Runs a controller until the goal checker says that the robot has arrived.

    What it gives the controller is the way of the robot's axle, not of its base.

    Args:
        config: Parameters, as `load` made them.
        chosen: The plug-ins; the first of each kind if None.
        body: The robot without its padding; the footprint if None. Where it stands out of the
            footprint, what is no controller's keeps it free.

    Attributes:
        controller: Another one with each path that is a new task.
        speed_limit: Greatest forward speed from now on [m/s]; inf for none.
        warning: Why the robot cannot drive as the controller wants; "" where it can.
        wanted: Topics of the controller that somebody listens to.

    Source: nav2_controller, ControllerServer::computeControl.
    """

    def __init__(
        self,
        config: FollowerConfig,
        footprint: Footprint,
        chosen: Chosen | None = None,
        body: Footprint | None = None,
    ) -> None:
        self._config, self._axle = config, footprint.axle
        footprint, body = footprint.of_axle, (body or footprint).of_axle
        self._controlled = footprint
        self._footprint = body if footprint.outreach(body) else footprint
        self.chosen = chosen or Chosen(
            config.controller_plugins[0],
            config.goal_checker_plugins[0],
            config.progress_checker_plugins[0],
        )
        self._goal: GoalChecker = GOAL_CHECKERS.make(getattr(config, self.chosen.goal_checker))
        self._heading_matters = not self._goal.reached(SE2(0.0, 0.0, 0.5 * math.pi), SE2())
        self._goal.reset()
        self._progress: ProgressChecker = PROGRESS_CHECKERS.make(
            getattr(config, self.chosen.progress_checker)
        )
        self.controller = self._make_controller()
        name, robot = self.chosen.controller, config.min_turning_radius
        self.warning = too_tight(f"controller {name}", self.controller, robot)
        radius = turning_radius(robot, self.controller)
        known = math.isfinite(radius)  # else no trajectory could be planned
        arrival = replace(config.arrival, enabled=config.arrival.enabled and known)
        escape = replace(config.escape, enabled=config.escape.enabled and known)
        self._radius = radius if known else 0.0
        self._limits: MotionLimits = getattr(self.controller, "limits", MotionLimits())
        tracking = config.tracker.within(self._limits)
        self._approach = FinalApproach(arrival, tracking, self._footprint, self._radius)
        self._escape = Escape(escape, tracking, footprint, body, self._radius)
        self._end: SE2 | None = None
        self._gap_pose = SE2(math.inf)
        self._failing_since: float | None = None
        self._escape_tried = self._path_changed = self._cancelled = self._has_driven = False
        self._stopping = False
        self.speed_limit, self._last = math.inf, STILL
        self.wanted: frozenset[str] = frozenset()

    def _make_controller(self) -> Controller:
        config, period = self._config, 1.0 / self._config.controller_frequency
        values, tolerance = getattr(config, self.chosen.controller), self._goal.xy_tolerance
        made: Controller = CONTROLLERS.make(values, self._controlled, tolerance, period)
        return made

    def start(self, path: Floats, now: float) -> None:
        """Follow a path from now [s] on, as a new task."""
        self._progress.reset()
        self._goal.reset()
        self._approach.begin()
        self._escape.reset()
        self._failing_since, self._escape_tried, self._has_driven = None, False, False
        self.controller = self._make_controller()  # the last goal's arrival is not this one's
        self.change(path)

    def change(self, path: Floats) -> None:
        """Follow another path to the same or a new end; progress is still counted.

        Raises:
            PathError: The path is empty or of the wrong shape.
        """
        path = paths.shifted(path, self._axle)
        self.controller.set_path(path)
        self._path_changed, self._cancelled = True, False
        end = SE2.from_array(path[-1])
        if self._end is not None and self._end.distance(end) > 1e-3:
            self._goal.reset()
            self._approach.begin()
        self._end = end

    def cancel(self) -> bool:
        """Return whether the robot may be stopped at once, else the controller begins to brake."""
        brakes: Callable[[], bool] | None = getattr(self.controller, "cancel", None)
        self._cancelled = brakes is not None and not self._escape.active and not brakes()
        return not self._cancelled

    def tick(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> FollowResult:
        """Return what to drive; pose and costmap are of the path's frame."""
        result = self._tick(pose, velocity, costmap, now)
        self._last = result.velocity
        return result

    def _tick(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> FollowResult:
        assert self._end is not None
        if self._axle:  # which does not move sideways
            pose, velocity = pose @ SE2(self._axle), replace(velocity, y=0.0)
        if self._path_changed and not self._escape.leads_to(self.controller.path, costmap):
            self._escape.reset()
            self._escape_tried = self._stopping = False
        self._path_changed = False
        if self._escape.in_gap and pose.distance(self._gap_pose) > self._config.gap_progress:
            self._progress.reset()  # it is slow
            self._gap_pose = pose
        if not self._progress.check(pose, now):
            message = self._progress.failure_message() + self._blocked_end(pose, costmap)
            return FollowResult.failed(ControlStatus.FAILED_TO_MAKE_PROGRESS, message)
        want(self.controller, self.wanted)
        distance = paths.length(self.controller.path)
        speed = min(self.controller.desired_speed, self.speed_limit)
        detour: float = getattr(self._goal, "detour", 1.0)  # a checker of one's own has none
        ends = paths.ends_here(self.controller.path, pose, distance, detour)
        arrives = ends or self._approach.steers(distance, speed)
        arrives = arrives and not self._escape.active and not self._cancelled
        if arrives and not self._has_driven:  # one that fails from the start has to say so
            control = self.controller.compute(pose, velocity, costmap, now)
            self._has_driven = control.status is ControlStatus.SUCCEEDED
        if arrives and self._has_driven:
            final = self._final(pose, velocity, costmap, now, distance)
            if final is not None:
                return final
        path = self.controller.path
        slower = allowed_speed(self._config.foresight, path, pose, costmap, speed)
        slow_down(self.controller, min(slower, self.speed_limit), self.speed_limit)
        control = self._control(pose, velocity, costmap, now)
        distance = paths.length(self.controller.path)
        if control.status is ControlStatus.SUCCEEDED:
            self._failing_since = None
            return FollowResult(
                FollowState.RUNNING, control.velocity, message=control.message, distance=distance
            )
        if self._brakes(velocity):
            self._failing_since = None
        message = control.message + self._blocked_end(pose, costmap)
        return self._tolerate(control.status, message, now, distance)

    def _final(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float, distance: float
    ) -> FollowResult | None:
        """Return the final approach's tick, None where the controller has to drive."""
        assert self._end is not None
        arriving = self._arrive(pose, velocity, costmap, now, distance)
        if arriving is not None and self._scrapes(arriving, pose, costmap):
            return None
        if arriving is not None:
            self._failing_since = None
            distance = pose.distance(self._end)
            return FollowResult(FollowState.RUNNING, arriving, distance=distance)
        if self._goal.reached(self._base(pose), self._base(self._end), velocity):
            return FollowResult(FollowState.SUCCEEDED)
        if self._approach.retry():
            return FollowResult(FollowState.RUNNING, STILL, distance=distance)
        return None

    def _blocked_end(self, pose: SE2, costmap: Costmap) -> str:
        """Return that the outline touches something at the path's end, where that is near."""
        end, near = self._end, 2.0 * self._footprint.circumscribed_radius
        assert end is not None
        seen = pose.distance(end) < near and costmap.frame.contains(
            *costmap.frame.to_cell(end.x, end.y)
        )
        if not seen or not collides(costmap, self._footprint, end):
            return ""
        at = self._base(end)
        where = f"({at.x:.2f}, {at.y:.2f})"
        return f"; with the heading of the path's end at {where} the outline touches something"

    def _base(self, axle: SE2) -> SE2:
        return axle @ SE2(-self._axle) if self._axle else axle

    def _brakes(self, velocity: Velocity) -> bool:
        """Return whether a robot that was commanded to stop still moves."""
        fastest = max(velocity.speed, abs(velocity.yaw_rate) * self._footprint.circumscribed_radius)
        return fastest > self._config.stopped_velocity

    def _scrapes(self, command: Velocity, pose: SE2, costmap: Costmap) -> bool:
        """Return whether a command turns a robot along something that it touches, or into it."""
        turns = abs(command.yaw_rate) * self._footprint.circumscribed_radius > abs(command.x)
        return turns and (
            collides(costmap, self._footprint, pose)
            or self._escape.turn_touches(command.yaw_rate, pose, costmap)
        )

    def _control(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float
    ) -> ControlResult:
        """Ask the controller; where it finds no valid control, escape.

        It waits for a moving obstacle ahead, as long as progress allows.
        """
        escape, path = self._escape, self.controller.path
        if escape.active:
            command = self._escaping(pose, velocity, costmap, now)
            if command is not None and escape.can_hand_over(pose, path, costmap):
                command = self._hand_over_if_faster(command, pose, velocity, costmap, now)
            if command is not None:
                return ControlResult(ControlStatus.SUCCEEDED, command)
        control = self._driven(pose, velocity, costmap, now)
        scrapes = self._scrapes(control.velocity, pose, costmap)
        if scrapes and escape.leave_contact(pose, costmap, control.velocity.yaw_rate):
            command = self._escaping(pose, velocity, costmap, now)
            return control if command is None else ControlResult(ControlStatus.SUCCEEDED, command)
        self._has_driven |= control.status is ControlStatus.SUCCEEDED
        valid = control.status is not ControlStatus.NO_VALID_CONTROL
        if valid and control.velocity.x != 0.0:  # a turn alone leads nowhere
            self._escape_tried = self._stopping = False
        if valid and not self._stopping:
            return control
        reach = self._footprint.circumscribed_radius + self._config.moving_obstacle_distance
        if costmap.moves_within(pose.x, pose.y, reach):
            return ControlResult(ControlStatus.SUCCEEDED, STILL, control.message)
        if self._escape_tried or not self._config.escape.enabled:
            return control
        self._stopping = self._brakes(velocity)
        if self._stopping:  # the escape begins at rest
            return ControlResult(ControlStatus.SUCCEEDED, STILL, control.message)
        self._escape_tried = True  # once: the next tick's search would find no more
        if escape.begin(pose, path, costmap):
            command = self._escaping(pose, velocity, costmap, now)
            if command is not None:
                return ControlResult(ControlStatus.SUCCEEDED, command)
        return control

    def _escaping(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float
    ) -> Velocity | None:
        """Return what leads on out of a tight spot, no faster than the controller drives."""
        speed, path = min(self.controller.desired_speed, self.speed_limit), self.controller.path
        command = self._escape.compute(pose, velocity, path, costmap, now, speed)
        return None if command is None else self._eased(command, velocity)

    def _eased(self, command: Velocity, velocity: Velocity) -> Velocity:
        """Return what of a command that is no controller's its limits let the robot drive now."""
        period = 1.0 / self._config.controller_frequency
        return self._limits.eased(command, self._last, velocity, period=period)

    def _driven(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        """Return what the controller wants, on an arc that a steered robot can drive and is free.

        There is none where it turns on the spot: an escape turns the robot then.

        It is looked at for collisions as far ahead as an escape is.
        """
        control = self.controller.compute(pose, velocity, costmap, now)
        command = steered(control.velocity, self._radius)
        if command is control.velocity:
            return control
        if command == STILL:
            bend = f"the robot's tightest bend is {self._radius:g} m"
            message = f"a turn on the spot is commanded, but {bend} (min_turning_radius)"
            return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)
        arc = rollout(pose, command, self._config.escape.horizon, costmap.frame.resolution)
        hit = first_collision(costmap, self._footprint, arc)
        if hit is None:
            return replace(control, velocity=command)
        where = collision_place(costmap, self._footprint, SE2.from_array(arc[hit]))
        message = f"collision ahead on the tightest bend at {where}"
        return ControlResult(ControlStatus.NO_VALID_CONTROL, message=message)

    def _hand_over_if_faster(
        self, command: Velocity, pose: SE2, velocity: Velocity, costmap: Costmap, now: float
    ) -> Velocity:
        """Hand the rest over to the controller if that drives faster; return what to drive."""
        control = self._driven(pose, velocity, costmap, now)
        if control.status is not ControlStatus.SUCCEEDED or control.velocity.x <= command.x:
            return command
        self._escape.reset()
        self._escape_tried = False
        return control.velocity

    def _arrive(
        self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float, remaining: float
    ) -> Velocity | None:
        """Return what drives into the goal, None while the controller drives or at the end."""
        end = self._end
        assert end is not None
        aligned = self._goal.reached(SE2(pose.x, pose.y, end.theta), end, velocity)
        speed, heading = min(self.controller.desired_speed, self.speed_limit), self._heading_matters
        at = Arrival(pose, end, velocity, costmap, now, remaining, speed, aligned, heading)
        command = self._approach.compute(at)
        return None if command is None else self._eased(command, velocity)

    def _tolerate(
        self, status: ControlStatus, message: str, now: float, distance: float
    ) -> FollowResult:
        """Stand still while a controller finds no valid command for less than the tolerance.

        Source: nav2_controller, ControllerServer::computeAndPublishVelocity: other failures end
            it at once, and of the negative tolerances only -1 is one.
        """
        tolerance = self._config.failure_tolerance
        if status is not ControlStatus.NO_VALID_CONTROL or -1.0 != tolerance <= 0.0:
            return FollowResult.failed(status, message)
        if self._failing_since is None:
            self._failing_since = now
        if tolerance == -1.0 or now - self._failing_since < tolerance:
            return FollowResult(FollowState.RUNNING, message=message, distance=distance)
        reason = f"{message}; for over {tolerance:g} s"
        return FollowResult.failed(ControlStatus.PATIENCE_EXCEEDED, reason)
