"""All that commands a robot's joints from outside: topics, actions and controller_manager."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from control_msgs.action import GripperCommand, ParallelGripperCommand
from controller_manager_msgs import srv
from controller_manager_msgs.msg import ControllerState, HardwareComponentState, HardwareInterface
from lifecycle_msgs.msg import State
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.devices.driving.joints import ACTIVE, INACTIVE, UNCONFIGURED, UNLOADED
from arjuna_sim.driven_robot import DrivenRobot, Observation
from arjuna_sim.model.joints import ControllerKind, ControllerSettings
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


_MANAGER = "controller_manager"


class ControllerManager:
    """Serves controller_manager's services for a robot."""

    def __init__(self, node: ManagedNode, robot: DrivenRobot) -> None:
        self._node, self._robot = node, robot
        for service, name, answer in (
            (srv.ListControllers, "list_controllers", self._list),
            (srv.ListControllerTypes, "list_controller_types", self._types),
            (srv.ListHardwareComponents, "list_hardware_components", self._components),
            (srv.ListHardwareInterfaces, "list_hardware_interfaces", self._interfaces),
            (srv.LoadController, "load_controller", self._step(UNCONFIGURED, UNLOADED)),
            (srv.ConfigureController, "configure_controller", self._step(INACTIVE, UNCONFIGURED)),
            (srv.CleanupController, "cleanup_controller", self._step(UNCONFIGURED, INACTIVE)),
            (
                *(srv.UnloadController, "unload_controller"),
                self._step(UNLOADED, INACTIVE, UNCONFIGURED),
            ),
            (srv.SwitchController, "switch_controller", self._switch),
            (srv.ReloadControllerLibraries, "reload_controller_libraries", self._reload),
            (*(srv.SetHardwareComponentState, "set_hardware_component_state"), self._set_component),
        ):
            node.serve(service, f"{_MANAGER}/{name}", answer)

    def _managed(self) -> list[tuple[ControllerSettings, str]]:
        return [each for each in self._robot.controllers.states if each[0].is_managed]

    def _list(self, request: Any, response: Any) -> Any:
        response.controller = [
            ControllerState(
                name=settings.name,
                state=state,
                type=settings.type,
                claimed_interfaces=list(settings.claims) if state == ACTIVE else [],
                required_command_interfaces=list(settings.claims),
                required_state_interfaces=self._states_of(settings),
            )
            for settings, state in self._managed()
            if state != UNLOADED
        ]
        return response

    def _states_of(self, settings: ControllerSettings) -> list[str]:
        wanted = settings.joints
        if settings.kind is ControllerKind.FORWARD:
            return []
        return [
            f"{joint.name}/{state}"
            for joint in self._robot.model.settings.driven
            for state in joint.states
            if joint.name in wanted or "broadcaster" in settings.type
        ]

    def _types(self, request: Any, response: Any) -> Any:
        response.types = sorted({settings.type for settings, _ in self._managed()})
        response.base_classes = ["controller_interface::ControllerInterface"] * len(response.types)
        return response

    def _of_hardware(self) -> tuple[list[HardwareInterface], list[HardwareInterface]]:
        """Return all command and all state interfaces."""
        driven, claimed = self._robot.model.settings.driven, self._robot.controllers.claimed
        wheels = [c for s, _ in self._managed() if not s.joints for c in s.claims]
        commands = [f"{joint.name}/{c}" for joint in driven for c in joint.commands] + wheels
        states = [f"{joint.name}/{s}" for joint in driven for s in joint.states] + wheels
        return (
            [_interface(name, name in claimed) for name in dict.fromkeys(commands)],
            [_interface(name, False) for name in dict.fromkeys(states)],
        )

    def _interfaces(self, request: Any, response: Any) -> Any:
        response.command_interfaces, response.state_interfaces = self._of_hardware()
        return response

    def _components(self, request: Any, response: Any) -> Any:
        name, plugin = self._robot.model.settings.hardware
        commands, states = self._of_hardware()
        response.component = [
            HardwareComponentState(
                name=name or "system",
                type="system",
                plugin_name=plugin,
                class_type=plugin,
                state=State(id=State.PRIMARY_STATE_ACTIVE, label=ACTIVE),
                command_interfaces=commands,
                state_interfaces=states,
            )
        ]
        return response

    def _set_component(self, request: Any, response: Any) -> Any:
        """Answer that the hardware is active, as it always is."""
        response.state = State(id=State.PRIMARY_STATE_ACTIVE, label=ACTIVE)
        wanted = request.target_state
        response.ok = wanted.id == State.PRIMARY_STATE_ACTIVE or wanted.label == ACTIVE
        return response

    def _step(self, to: str, *allowed: str) -> Callable[[Any, Any], Any]:
        """Return a service that puts one controller into a state."""

        def answer(request: Any, response: Any) -> Any:
            response.ok = (
                self._attempt(lambda: self._robot.controllers.set_state(request.name, to, allowed))
                == ""
            )
            return response

        return answer

    def _attempt(self, change: Callable[[], None]) -> str:
        """Return why a change is refused, "" where it is done."""
        try:
            change()
        except ArjunaError as error:
            self._node.get_logger().error(f"{_MANAGER}: {error}")
            return str(error)
        return ""

    def _switch(self, request: Any, response: Any) -> Any:
        controllers, kind = self._robot.controllers, srv.SwitchController.Request
        forced = request.strictness == kind.FORCE_AUTO
        on, off = list(request.activate_controllers), list(request.deactivate_controllers)
        if request.strictness != kind.BEST_EFFORT:
            response.message = self._attempt(lambda: controllers.switch(on, off, forced))
            response.ok = not response.message
            return response
        switches = [partial(controllers.switch, (), (name,), False) for name in off]
        switches += [partial(controllers.switch, (name,), (), False) for name in on]
        problems = [self._attempt(switch) for switch in switches]
        response.message = "; ".join(filter(None, problems))
        response.ok = not all(problems) if problems else True
        return response

    def _reload(self, request: Any, response: Any) -> Any:
        """Answer whether it could be done: no controller is loaded, or all are ended."""
        loaded = [s.name for s, state in self._managed() if state != UNLOADED]
        if loaded and not request.force_kill:
            return response
        for name in loaded:
            every = (ACTIVE, INACTIVE, UNCONFIGURED)
            self._robot.controllers.set_state(name, UNLOADED, every)
        response.ok = True
        return response


def _interface(name: str, is_claimed: bool) -> HardwareInterface:
    return HardwareInterface(
        name=name, data_type="double", is_available=True, is_claimed=is_claimed
    )


class _Reporting(Protocol):
    def publish(self, joints: JointStates, now: float) -> None:
        """Report the joints after a tick."""


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


class JointControl:
    """The interface of a robot's driven joints; a robot without any has none."""

    def __init__(self, node: ManagedNode, robot: DrivenRobot) -> None:
        self._reporting: list[_Reporting] = []
        controllers = robot.model.settings.controllers
        for settings in controllers:
            if settings.kind is ControllerKind.FORWARD:
                _forward(node, robot, settings)
            elif settings.kind is ControllerKind.TRAJECTORY:
                self._reporting.append(TrajectoryTopics(node, robot, settings))
            elif settings.kind is ControllerKind.GRIPPER and settings.joints:
                self._reporting.append(GripperTopics(node, robot, settings))
        if any(settings.is_managed for settings in controllers):
            ControllerManager(node, robot)

    def publish(self, observation: Observation) -> None:
        """Report the joints after a tick."""
        for each in self._reporting:
            each.publish(observation.joints, observation.time)
