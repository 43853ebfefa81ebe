"""Node motion_control: the small motions and the dock of an iRobot Create 3, by odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from irobot_create_msgs import action
from irobot_create_msgs.msg import DockStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from arjuna_core.config import duration_param, fixed, length_param, param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose_stamped, velocity_from_twist
from arjuna_core.ros.goal_server import GoalError, GoalNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from arjuna_nav.behaviors.base import InvalidGoalError
from arjuna_nav.behaviors.legs import Leg, Legs, Step, arc, to_position
from arjuna_nav.controllers.tracker import TrackerConfig
from arjuna_nav.nodes.frames import pose_in, robot_pose


@dataclass(frozen=True)
class MotionControlConfig(TrackerConfig):
    """Parameters of motion_control."""

    odom_topic: str = fixed("odom", "Topic of the odometry.")
    odom_frame: str = fixed("odom", "Frame to move in.")
    base_frame: str = fixed("base_link", "Frame of the robot.")
    transform_tolerance: float = duration_param(0.5, "How old the robot's pose may be.")
    control_frequency: float = fixed(40.0, "Commands a second.", unit="Hz", minimum=1.0)
    starts_docked: bool = fixed(
        True, "Whether the robot stands on its dock at first; else it has none."
    )
    dock_visible_distance: float = length_param(1.5, "How far away the dock is seen.")
    safety_override: str = param(
        "none", "Has no effect: nothing is looked out for.", choices=("none", "backup_only", "full")
    )
    undock_distance: float = length_param(0.4, "How far it drives off the dock.", minimum=0.05)


class _Motion(NamedTuple):
    """An action: its legs by a goal, and its feedback."""

    type: Any
    steps: Callable[[Any], Sequence[Step]]
    feedback: Callable[[Legs], dict[str, Any]] = lambda legs: {}


def _one(leg: Leg) -> list[Step]:
    return [lambda pose: leg]


def _angle_left(legs: Legs) -> dict[str, float]:
    return {"remaining_angle_travel": legs.remaining}


def _state(legs: Legs) -> dict[str, Any]:
    what = "remaining_travel_distance" if legs.index == 1 else "remaining_angle_travel"
    return {"navigate_state": legs.index + 1, what: legs.remaining}


class MotionControlNode(GoalNode):
    """Runs one motion at a time; a goal that comes meanwhile is rejected, as a Create 3's is."""

    Config = MotionControlConfig
    DEFAULT_NAME = "motion_control"

    def configure(self) -> None:
        self._running: tuple[str, Legs] | None = None
        self._dock: SE2 | None = None
        self._docked, self._velocity = self.config.starts_docked, STILL
        self._output = VelocityOutput(self, None, self.config.base_frame)
        self._status = self.publisher(DockStatus, "dock_status", qos.SENSOR_PUBLISHER)
        self._motions = self._known()
        self._servers = {
            name: self.offer(motion.type, name, partial(self._start, name), admit=self._why_not_now)
            for name, motion in self._motions.items()
        }
        topic = self.config.odom_topic
        self.subscribe(Odometry, topic, self._on_odometry, qos.SENSOR_SUBSCRIPTION)
        self.every(1.0 / self.config.control_frequency, self._tick)
        self.every(0.1, self._publish_status)
        self._battery = self.publisher(BatteryState, "battery_state", qos.SENSOR_PUBLISHER)
        self.every(1.0, self._publish_battery)

    def _known(self) -> dict[str, _Motion]:
        return {
            "dock": _Motion(
                action.Dock, self._onto_dock, lambda legs: {"sees_dock": self._sees_dock()}
            ),
            "undock": _Motion(action.Undock, self._off_dock),
            "drive_distance": _Motion(
                action.DriveDistance,
                lambda goal: _one(Leg(goal.distance, speed=goal.max_translation_speed)),
                lambda legs: {"remaining_travel_distance": legs.remaining},
            ),
            "rotate_angle": _Motion(
                action.RotateAngle,
                lambda goal: _one(Leg(angle=goal.angle, rate=goal.max_rotation_speed)),
                _angle_left,
            ),
            "drive_arc": _Motion(
                action.DriveArc,
                lambda goal: _one(
                    arc(
                        goal.angle,
                        goal.radius,
                        goal.translate_direction,
                        goal.max_translation_speed,
                    )
                ),
                _angle_left,
            ),
            "navigate_to_position": _Motion(
                action.NavigateToPosition,
                lambda goal: to_position(
                    pose_in(self, self.config.odom_frame, goal.goal_pose),
                    goal.achieve_goal_heading,
                    goal.max_translation_speed,
                    goal.max_rotation_speed,
                ),
                _state,
            ),
        }

    def _on_odometry(self, message: Any) -> None:
        self._velocity = velocity_from_twist(message.twist.twist)

    def _pose(self) -> SE2:
        config = self.config
        return robot_pose(self, config.odom_frame, config.base_frame, config.transform_tolerance)

    def _sees_dock(self) -> bool:
        """Return whether the dock that the robot drove off is near and ahead."""
        if self._docked or self._dock is None:
            return bool(self._docked)
        try:
            ahead = self._pose().inverse() @ self._dock
        except TransformError:
            return False
        return ahead.x > 0.0 and math.hypot(ahead.x, ahead.y) < self.config.dock_visible_distance

    def _onto_dock(self, goal: Any) -> Sequence[Step]:
        """Return the way onto the dock: to where it lies straight ahead, then forward.

        Raises:
            InvalidGoalError: The robot is docked, or has no dock near it.
        """
        if self._docked or self._dock is None:
            known = "it is docked already" if self._docked else "it knows of no dock"
            raise InvalidGoalError(f"the robot cannot dock: {known}")
        distance = self._pose().distance(self._dock)
        if distance > self.config.dock_visible_distance:
            raise InvalidGoalError(f"the dock is {distance:.2f} m away, too far to be seen")
        before = self._dock @ SE2(-self.config.undock_distance, 0.0, 0.0)
        return [*to_position(before, heading=False), *to_position(self._dock, heading=True)]

    def _off_dock(self, goal: Any) -> Sequence[Step]:
        """Return the way off the dock: backwards, then about.

        Raises:
            InvalidGoalError: The robot is not docked.
        """
        if not self._docked:
            raise InvalidGoalError("the robot is not docked")
        about = Leg(angle=math.pi)
        return [lambda pose: Leg(-self.config.undock_distance), lambda pose: about]

    def _why_not_now(self, goal: Any) -> str | None:
        running = self._running
        return None if running is None else f"{running[0]} is running"

    def _start(self, name: str) -> None:
        try:
            steps = self._motions[name].steps(self._servers[name].goal)
        except (InvalidGoalError, TransformError) as error:
            raise GoalError(0, str(error)) from error
        self._running = name, Legs(steps, self.config)

    def halt(self) -> None:
        if self._running is not None:
            self._output.stop()
        self._running = None

    def _tick(self) -> None:
        if self._running is None:
            return
        name, legs = self._running
        server = self._servers[name]
        if server.cancel_requested:
            self.halt()
            server.cancel(self._result(name))
            return
        try:
            velocity = legs.tick(self._pose(), self._velocity)
        except (InvalidGoalError, TransformError) as error:
            self.halt()
            server.fail(GoalError(0, str(error)))
            return
        if velocity is not None:
            self._output.publish(velocity)
            motion = self._motions[name]
            server.feedback(motion.type.Feedback(**motion.feedback(legs)))
            return
        self.halt()
        if name in ("dock", "undock"):
            self._docked = name == "dock"
        server.succeed(self._result(name))

    def _result(self, name: str) -> Any:
        result = self._motions[name].type.Result()
        if hasattr(result, "is_docked"):
            result.is_docked = self._docked
        else:
            result.pose = pose_stamped(self._pose(), self.config.odom_frame, self.now)
        return result

    def _watch_dock(self, contact: float = 0.1) -> None:
        """Take the first pose as the dock's if the robot starts on one, and see it leave it [m]."""
        if not self._docked or self._running is not None:
            return
        try:
            pose = self._pose()
        except TransformError:
            return
        self._dock = self._dock or pose
        self._docked = pose.distance(self._dock) < contact

    def _publish_status(self) -> None:
        self._watch_dock()
        status = DockStatus(header=header(self.config.base_frame, self.now))
        status.is_docked, status.dock_visible = self._docked, self._sees_dock()
        self._status.publish(status)

    def _publish_battery(self) -> None:
        """Publish a full battery, which programs of a Create 3 wait for, unless there is one."""
        if self.count_publishers("battery_state") > 1:
            return
        state = BatteryState(header=header(self.config.base_frame, self.now), present=True)
        state.percentage = state.capacity = state.charge = 1.0
        self._battery.publish(state)
