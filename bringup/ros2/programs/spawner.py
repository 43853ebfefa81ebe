"""`ros2 run controller_manager spawner` and `unspawner`: controllers brought to a state."""

from __future__ import annotations

import argparse
import shlex

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters

from bringup.ros2.client import Client
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.control import Manager


def _parser(name: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=f"ros2 run controller_manager {name}")
    parser.add_argument("controller_names", nargs="+", help="the controllers, in this order")
    parser.add_argument("-c", "--controller-manager", default="controller_manager")
    parser.add_argument("--switch-timeout", type=float, default=5.0, help="accepted")
    return parser


def main(words: list[str]) -> None:
    """Load, configure and activate controllers; those that are active stay so."""
    parser = _parser("spawner")
    parser.add_argument("-p", "--param-file", action="append", help="accepted: see the robot's")
    parser.add_argument("-n", "--namespace", default="", help="namespace of the manager")
    parser.add_argument("--load-only", action="store_true", help="do not configure them")
    parser.add_argument("--inactive", action="store_true", help="do not activate them")
    parser.add_argument("-u", "--unload-on-kill", action="store_true", help="wait, then unload")
    parser.add_argument("--activate-as-group", action="store_true", help="all in one step")
    parser.add_argument("--controller-manager-timeout", type=float, default=0.0, metavar="N")
    parser.add_argument("--service-call-timeout", type=float, default=10.0, metavar="N")
    parser.add_argument("--controller-ros-args", action="append", help="remaps: '-r FROM:=TO'")
    given = parser.parse_args(words)
    if given.namespace:
        given.controller_manager = f"{given.namespace}/{given.controller_manager.lstrip('/')}"
    state = "unconfigured" if given.load_only else "inactive" if given.inactive else "active"
    patience = given.controller_manager_timeout or 600.0  # theirs waits for ever
    with Client(given, f"spawner_{given.controller_names[0]}") as client:
        known = _states(client, given, patience)
        manager = Manager(client, given, patience)
        for name in given.controller_names:
            _rename(manager, name, shlex.split(" ".join(given.controller_ros_args or ())))
            if known.get(name) == "active" or (state == known.get(name)):
                print(f"Controller {name} is {known[name]} already")
            else:
                manager.bring_to(name, state)
        if given.unload_on_kill:
            try:
                client.pause()
            finally:
                _unspawn(manager, given.controller_names)


def _states(client: Client, given: argparse.Namespace, patience: float) -> dict[str, str]:
    """Return the states of controllers, within a patience [s]; say what is long waited for."""
    quiet = min(patience, 10.0)
    try:
        return Manager(client, given, quiet).states()
    except Ros2Error:
        if quiet == patience:
            raise
    where = f"{given.controller_manager}/list_controllers"
    print(f"waiting for {where}: 'arjuna sim --robot FILE' has it; hardware is ROS's", flush=True)
    return Manager(client, given, patience).states()


def _rename(manager: Manager, controller: str, words: list[str]) -> None:
    """Hand a controller's remaps on, as ros2_control's spawner does; say which have no effect."""
    if not words:
        return
    value = ParameterValue(type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=words)
    parameter = Parameter(name=f"{controller}.node_options_args", value=value)
    for result in manager.ask(SetParameters, "set_parameters", parameters=[parameter]).results:
        if not result.successful:
            print(f"no effect: {controller}: {result.reason}", flush=True)


def unspawn(words: list[str]) -> None:
    """Deactivate and unload controllers."""
    given = _parser("unspawner").parse_args(words)
    with Client(given, f"unspawner_{given.controller_names[0]}") as client:
        _unspawn(Manager(client, given), given.controller_names)


def _unspawn(manager: Manager, names: list[str]) -> None:
    for name in names:
        if manager.states().get(name) == "active":
            manager.bring_to(name, "inactive")
        manager.step("unload", name, "unloaded")
