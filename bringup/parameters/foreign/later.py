"""A controller server's parameters in the forms that Nav2 has after Jazzy, in those of Jazzy."""

from __future__ import annotations

from typing import Any

_MPPI = "nav2_mppi_controller::MPPIController"
_MODELS = {f"mppi::{name}MotionModel": name for name in ("DiffDrive", "Omni", "Ackermann")}
_RADIUS = "min_turning_r"
_HANDLER = "nav2_controller::FeasiblePathHandler"
_HANDLED = (
    *("prune_distance", "max_robot_pose_search_dist", "enforce_path_inversion"),
    *("inversion_xy_tolerance", "inversion_yaw_tolerance"),
)
"""What a path handler does for every controller, and here MPPI for itself."""


def controllers_as_in_jazzy(values: dict[str, Any]) -> dict[str, Any]:
    """Return values in which wrapped controllers, models and path handlers are as in Jazzy."""
    for key in [key for key in values if key.endswith(".primary_controller.plugin")]:
        values = _unwrapped(values, key.removesuffix(".plugin"))
    for key, cls in list(values.items()):
        if key.endswith(".plugin") and (model := _MODELS.get(str(cls))):
            values = _with_model(values, key.removesuffix(".plugin"), model)
    return _with_handled_paths(values)


def _unwrapped(values: dict[str, Any], primary: str) -> dict[str, Any]:
    """Return values in which a wrapped controller's parameters stand beside its shim's.

    One that the shim has as well stays where it is: the two share it.
    """
    shim = primary.rpartition(".")[0]
    found = {key: value for key, value in values.items() if not key.startswith(f"{primary}.")}
    for key, value in values.items():
        if key.startswith(f"{primary}."):
            beside = shim + key.removeprefix(primary)
            found[key if beside in found else beside] = value
    found[primary] = values[f"{primary}.plugin"]
    return {key: value for key, value in found.items() if key != f"{primary}.plugin"}


def _with_model(values: dict[str, Any], group: str, model: str) -> dict[str, Any]:
    """Return values in which MPPI's motion model is named, not a group with its class."""
    plugin, _, name = group.rpartition(".")
    named = values.get(f"{plugin}.motion_model", "diff_drive")
    if named not in (name, model):
        return values
    found = {key: value for key, value in values.items() if not key.startswith(f"{group}.")}
    found[f"{plugin}.motion_model"] = model
    if f"{group}.{_RADIUS}" in values:
        found.setdefault(f"{plugin}.AckermannConstraints.{_RADIUS}", values[f"{group}.{_RADIUS}"])
    return found


def _with_handled_paths(values: dict[str, Any]) -> dict[str, Any]:
    """Return values in which MPPI has the parameters of the first path handler of the list."""
    listed = values.get("path_handler_plugins", ())
    handlers = [key.rpartition(".")[0] for key, cls in values.items() if cls == _HANDLER]
    handlers.sort(key=lambda name: listed.index(name) if name in listed else len(listed))
    for handler in handlers[:1]:
        own = {
            key: values.pop(f"{handler}.{key}") for key in _HANDLED if f"{handler}.{key}" in values
        }
        for key in [key for key, cls in values.items() if cls == _MPPI]:
            plugin = key.rpartition(".")[0]
            values = {**{f"{plugin}.{name}": value for name, value in own.items()}, **values}
    return values
