"""controller_manager's services of a simulated robot."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import Any

from controller_manager_msgs import srv
from controller_manager_msgs.msg import ControllerState, HardwareComponentState, HardwareInterface
from lifecycle_msgs.msg import State
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.devices.driving.joints import ACTIVE, INACTIVE, UNCONFIGURED, UNLOADED
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.joints import ControllerKind, ControllerSettings

_MANAGER = "controller_manager"


class ControllerManager:
    """Serves controller_manager's services for a robot.

    Args:
        rename: Gives a topic of its drive another name; returns whether it is one.
    """

    def __init__(
        self, node: ManagedNode, robot: DrivenRobot, rename: Callable[[str, str], bool]
    ) -> None:
        self._node, self._robot, self._rename = node, robot, rename
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
            (SetParameters, "set_parameters", self._set_parameters),
        ):
            node.serve(service, f"{_MANAGER}/{name}", answer)

    def _set_parameters(self, request: Any, response: Any) -> Any:
        """Rename topics as `CONTROLLER.node_options_args` says: `-r FROM:=TO`, as spawners give."""
        for one in request.parameters:
            name, _, key = one.name.rpartition(".")
            words = list(one.value.string_array_value)
            rules = [b for a, b in itertools.pairwise(words) if a in ("-r", "--remap")]
            unused = [rule for rule in rules if not self._renames(name, rule)]
            reason = f"no topic of the drive: {' '.join(unused)}" if unused else ""
            reason = reason if key == "node_options_args" else f"'{one.name}' has no effect"
            response.results.append(SetParametersResult(successful=not reason, reason=reason))
        return response

    def _renames(self, controller: str, rule: str) -> bool:
        topic, _, other = rule.partition(":=")
        topic = topic.replace("~", f"/{controller}", 1) if topic.startswith("~") else topic
        return bool(other) and self._rename(topic, other)

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
