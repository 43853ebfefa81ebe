"""`ros2 control`: the verbs and options of ros2controlcli, Jazzy's."""

from __future__ import annotations

from bringup.ros2.grammar import Argument, Command, Verb, argument, switch

STATES = ("unconfigured", "inactive", "active")
MANAGER = argument(
    *("-c", "--controller-manager"),
    default="/controller_manager",
    help="name of the controller manager (/controller_manager)",
)
_NAME = argument("controller_name", help="name of the controller")
_VERBOSE = switch("-v", "--verbose", help="all that is known")


def _verb(name: str, about: str, *arguments: Argument) -> Verb:
    return Verb(name, about, (*arguments, MANAGER))


def _names(flag: str, about: str) -> Argument:
    return argument(flag, nargs="+", default=[], metavar="NAME", help=about)


CONTROL = Command(
    *("control", "Various control related sub-commands"),
    (
        _verb(
            *("list_controllers", "Output the list of loaded controllers"),
            switch("--claimed-interfaces", help="the interfaces that each claims"),
            switch("--required-state-interfaces", help="the states that each reads"),
            switch("--required-command-interfaces", help="the interfaces that each wants"),
            _VERBOSE,
        ),
        _verb("list_controller_types", "Output the available controller types"),
        _verb("list_hardware_components", "Output the list of hardware components", _VERBOSE),
        _verb("list_hardware_interfaces", "Output the list of command and state interfaces"),
        _verb(
            *("load_controller", "Load a controller in a controller manager", _NAME),
            argument("--set-state", choices=STATES[1:], help="bring it to this state"),
        ),
        _verb(
            *("reload_controller_libraries", "Reload controller libraries"),
            switch("--force-kill", help="end all controllers first"),
        ),
        _verb(
            *("set_controller_state", "Adjust the state of the controller", _NAME),
            argument("state", choices=STATES, help="the state"),
        ),
        _verb(
            *("switch_controllers", "Switch controllers in a controller manager"),
            _names("--activate", "controllers to activate"),
            _names("--deactivate", "controllers to deactivate"),
            switch("--strict", help="all or none"),
            switch("--activate-asap", help="accepted: hardware is always ready"),
            argument("--switch-timeout", type=float, default=5.0, metavar="N", help="in s (5)"),
        ),
        _verb("unload_controller", "Unload a controller in a controller manager", _NAME),
    ),
    graph=True,
)
