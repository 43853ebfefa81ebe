"""All that commands a robot's joints from outside: topics, actions and controller_manager."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from control_msgs.action import GripperCommand, ParallelGripperCommand
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.joints import ControllerKind, ControllerSettings
from arjuna_sim.nodes.control.manager import ControllerManager
from arjuna_sim.nodes.control.trajectories import TrajectoryTopics
from arjuna_sim.physics.robot_motion import JointStates


class GripperTopics(GoalServer):
    """Takes a gripper's positions, and reports when it is there or stalls."""

    def __init__(self, node: ManagedNode, robot: DrivenRobot, settings: ControllerSettings) -> None:
        self._robot, self._settings, self._owner = robot, settings, node
        self._is_parallel = settings.type.startswith("parallel")
        self._action = ParallelGripperCommand if self._is_parallel else GripperCommand
        self._wanted, self._moved = 0.0, 0.0
        name, on_cancel = f"{settings.name}/gripper_cmd", self._on_cancel_goal
        super().__init__(
            node, self._action, name, self._on_goal, admit=self._admit, on_cancel=on_cancel
        )
        node.keep(self)

    def explained(self, reason: str, code: int | None = None, **fields: Any) -> Any:
        """Return a result; the action has no field for a reason."""
        return self._outcome(self._action.Result, 0.0)

    def _outcome(self, kind: Any, position: float, **flags: bool) -> Any:
        if self._is_parallel:
            state = JointState(name=list(self._settings.joints), position=[position])
            return kind(state=state, **flags)
        return kind(position=position, **flags)

    def _position(self, goal: Any) -> float:
        wanted = goal.command.position
        return float(wanted[0] if self._is_parallel else wanted)

    def _admit(self, goal: Any) -> str | None:
        if self._is_parallel and not goal.command.position:
            return "it has no position"
        try:
            self._robot.controllers.check_joints(self._settings.name, self._settings.joints)
        except ArjunaError as error:
            return str(error)
        return None

    def _on_goal(self) -> None:
        goal = self.take_newest()
        assert goal is not None
        self._wanted, self._moved = self._position(goal), self._robot.elapsed
        try:
            self._robot.controllers.command(self._settings.name, [self._wanted])
        except ArjunaError as error:
            self._owner.get_logger().warning(str(error))
            self.abort(self.explained(str(error)))

    def _on_cancel_goal(self) -> None:
        if self.cancel_requested:
            self._robot.controllers.hold(self._settings.name)
            self.cancel(self.explained("it was cancelled"))

    def publish(self, joints: JointStates, now: float) -> None:
        """Report the finger after a tick, and end a goal that is reached or stalls."""
        if self.goal is None:
            return
        positions, rates = joints.of(self._settings.joints)
        at, rate = float(positions[0]), abs(float(rates[0]))
        settings, elapsed = self._settings, self._robot.elapsed
        # [rad/s or m/s] stall_velocity_threshold's default.
        if rate > 0.001:
            self._moved = elapsed
        reached = abs(self._wanted - at) <= settings.goal_tolerance[0]
        stalled = elapsed - self._moved > settings.stall_timeout
        self.feedback(
            self._outcome(self._action.Feedback, at, reached_goal=reached, stalled=stalled)
            if not self._is_parallel
            else self._action.Feedback(state=self._outcome(self._action.Result, at).state)
        )
        if not reached and not stalled:
            return
        result = self._outcome(self._action.Result, at, reached_goal=reached, stalled=stalled)
        (self.succeed if reached or settings.allow_stalling else self.abort)(result)


def _forward(node: ManagedNode, robot: DrivenRobot, settings: ControllerSettings) -> None:
    """Take the values of a controller: all in one message, or one of Gazebo's plug-ins for all."""

    def command(values: list[float]) -> None:
        try:
            robot.controllers.command(settings.name, values)
        except ArjunaError as error:
            node.get_logger().warning(f"command ignored: {error}")

    if settings.is_managed:
        topic = f"{settings.name}/commands"
        node.subscribe(
            Float64MultiArray, topic, lambda message: command(list(message.data)), qos.LATEST
        )
    else:
        topic = settings.topic
        node.subscribe(Float64, topic, lambda message: command([message.data]), qos.LATEST)


def joint_topics(
    node: ManagedNode, robot: DrivenRobot, rename: Callable[[str, str], bool]
) -> list[TrajectoryTopics | GripperTopics]:
    """Let clients command a robot's driven joints; return what reports them after each tick."""
    reporting: list[TrajectoryTopics | GripperTopics] = []
    controllers = robot.model.settings.controllers
    for settings in controllers:
        if settings.kind is ControllerKind.FORWARD:
            _forward(node, robot, settings)
        elif settings.kind is ControllerKind.TRAJECTORY:
            reporting.append(TrajectoryTopics(node, robot, settings))
        elif settings.kind is ControllerKind.GRIPPER and settings.joints:
            reporting.append(GripperTopics(node, robot, settings))
    if any(settings.is_managed for settings in controllers):
        ControllerManager(node, robot, rename)
    return reporting
