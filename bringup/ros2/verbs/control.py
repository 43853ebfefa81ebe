"""`ros2 control`: what controller_manager lists, and the states of controllers."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from typing import Any

from controller_manager_msgs import srv

from arjuna_core.ros.convert import duration_msg
from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import LAUNCHED

_PATIENCE, _STARTING = 10.0, 60.0  # [s] for a manager, and for one that a launch file starts


class Manager:
    """The services of a controller_manager, waited for up to a time-out [s]."""

    def __init__(
        self, client: Client, arguments: argparse.Namespace, timeout: float = _PATIENCE
    ) -> None:
        self._client, self._timeout = client, timeout
        self._name = arguments.controller_manager

    def ask(self, kind: Any, service: str, /, **fields: Any) -> Any:
        """Call a service by its name below the manager's."""
        request, path = kind.Request(**fields), f"{self._name}/{service}"
        return self._client.call(kind, path, request, timeout=self._timeout)

    def states(self) -> dict[str, str]:
        """Return the states of all controllers that are loaded."""
        found = self.ask(srv.ListControllers, "list_controllers").controller
        return {one.name: one.state for one in found}

    def step(self, verb: str, name: str, done: str) -> None:
        """Load, configure, clean up or unload a controller.

        Raises:
            Ros2Error: It is refused.
        """
        kind = getattr(srv, f"{verb.title()}Controller")
        if not self.ask(kind, f"{verb}_controller", name=name).ok:
            raise Ros2Error(
                f"Error {done[:-2]}ing controller {name}, check controller_manager logs"
            )
        print(f"Successfully {done} {name}")

    def switch(self, on: Sequence[str], off: Sequence[str], **fields: Any) -> None:
        """Activate and deactivate controllers.

        Raises:
            Ros2Error: It is refused.
        """
        fields = {"strictness": srv.SwitchController.Request.STRICT, **fields}
        lists = {"activate_controllers": list(on), "deactivate_controllers": list(off)}
        answer = self.ask(srv.SwitchController, "switch_controller", **lists, **fields)
        if not answer.ok:
            raise Ros2Error(f"Error switching controllers: {answer.message}")

    def bring_to(self, name: str, wanted: str) -> None:
        """Bring a controller to a state, step by step; it is loaded where it is not.

        Raises:
            Ros2Error: A step is refused.
        """
        if name not in self.states():
            self.step("load", name, "loaded")
        state = self.states()[name]
        if state == wanted:
            print(f"Controller {name} is {wanted} already")
        if state == "active" and wanted != "active":
            self.switch([], [name])
            print(f"Successfully deactivated {name}")
        if wanted == "unconfigured" != state:
            self.step("cleanup", name, "cleaned up")
        if state == "unconfigured" != wanted:
            self.step("configure", name, "configured")
        if wanted == "active" != state:
            self.switch([name], [])
            print(f"Successfully activated {name}")


def _managed(verb: Callable[[Manager, argparse.Namespace], None]) -> Callable[..., None]:
    def run(arguments: argparse.Namespace) -> None:
        patience = _STARTING if LAUNCHED in os.environ else _PATIENCE
        with Client(arguments) as client:
            verb(Manager(client, arguments, patience), arguments)

    run.__doc__ = verb.__doc__
    return run


@_managed
def list_controllers(manager: Manager, arguments: argparse.Namespace) -> None:
    """List the controllers that are loaded, with types and states."""
    found = manager.ask(srv.ListControllers, "list_controllers").controller
    if not found:
        print("No controllers are currently loaded!")
    widths = [max(len(getattr(one, key)) for one in found) for key in ("name", "type") if found]
    for one in found:
        print(f"{one.name:<{widths[0]}} {one.type:<{widths[1]}}  {one.state}")
        for key in ("claimed", "required_command", "required_state"):
            if arguments.verbose or getattr(arguments, f"{key}_interfaces"):
                print(f"\t{key.replace('_', ' ')} interfaces:")
                values = getattr(one, f"{key}_interfaces")
                print("".join(f"\t\t{value}\n" for value in values), end="")


@_managed
def list_controller_types(manager: Manager, arguments: argparse.Namespace) -> None:
    """List the types of controllers and their base classes."""
    found = manager.ask(srv.ListControllerTypes, "list_controller_types")
    for kind, base in zip(found.types, found.base_classes, strict=True):
        print(f"{kind:<60} {base}")


@_managed
def list_hardware_interfaces(manager: Manager, arguments: argparse.Namespace) -> None:
    """List all interfaces, and which of those for commands are claimed."""
    _print_interfaces(manager.ask(srv.ListHardwareInterfaces, "list_hardware_interfaces"), "")


@_managed
def list_hardware_components(manager: Manager, arguments: argparse.Namespace) -> None:
    """List the parts of the hardware."""
    found = manager.ask(srv.ListHardwareComponents, "list_hardware_components").component
    for number, one in enumerate(found, start=1):
        print(f"Hardware Component {number}\n\tname: {one.name}\n\ttype: {one.type}")
        print(f"\tplugin name: {one.plugin_name}")
        print(f"\tstate: id={one.state.id} label={one.state.label}")
        if arguments.verbose:
            print(f"\tread/write rate: {one.rw_rate} Hz\n\tis_async: {one.is_async}")
        _print_interfaces(one, "\t", arguments.verbose)


def _print_interfaces(holder: Any, indent: str, states: bool = True) -> None:
    print(f"{indent}command interfaces")
    for one in holder.command_interfaces:
        available = "available" if one.is_available else "unavailable"
        claimed = "claimed" if one.is_claimed else "unclaimed"
        print(f"{indent}\t{one.name} [{available}] [{claimed}]")
    if states:
        print(f"{indent}state interfaces")
        print("".join(f"{indent}\t{one.name}\n" for one in holder.state_interfaces), end="")


@_managed
def load_controller(manager: Manager, arguments: argparse.Namespace) -> None:
    """Load a controller; bring it to a state where one is named, which the robot's start may do."""
    if arguments.set_state:
        manager.bring_to(arguments.controller_name, arguments.set_state)
    else:
        manager.step("load", arguments.controller_name, "loaded")


@_managed
def unload_controller(manager: Manager, arguments: argparse.Namespace) -> None:
    """Unload a controller."""
    manager.step("unload", arguments.controller_name, "unloaded")


@_managed
def set_controller_state(manager: Manager, arguments: argparse.Namespace) -> None:
    """Bring a controller to a state."""
    manager.bring_to(arguments.controller_name, arguments.state)


@_managed
def switch_controllers(manager: Manager, arguments: argparse.Namespace) -> None:
    """Activate and deactivate controllers in one step."""
    kind = srv.SwitchController.Request
    manager.switch(
        arguments.activate,
        arguments.deactivate,
        strictness=kind.STRICT if arguments.strict else kind.BEST_EFFORT,
        activate_asap=arguments.activate_asap,
        timeout=duration_msg(arguments.switch_timeout),
    )
    print("Successfully switched controllers")


@_managed
def reload_controller_libraries(manager: Manager, arguments: argparse.Namespace) -> None:
    """Load the libraries of controllers again."""
    force = arguments.force_kill
    kind, name = srv.ReloadControllerLibraries, "reload_controller_libraries"
    if not manager.ask(kind, name, force_kill=force).ok:
        raise Ros2Error("Error reloading libraries: a controller is loaded; --force-kill ends all")
    print("Reload successful")
