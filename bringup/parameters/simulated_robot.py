"""What a simulated robot's own file says of it, as parameters of the nodes that drive it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from arjuna_core.files.shipped import shipped_file
from bringup.parameters.files import Parameters, merged, shipped_parameters
from bringup.parameters.robot_names import of_names
from bringup.stack import Group

_COSTMAPS = {
    "local_costmap/local_costmap": "",
    "global_costmap/global_costmap": "",
    "explorer": "costmap.",
}
"""The nodes with a costmap, and what stands before its parameters."""
_SHAPE = ("footprint", "robot_radius")


def of_simulated_robot(
    parameters: Parameters, sim: Mapping[str, Any], groups: Iterable[Group]
) -> Parameters:
    """Return a robot's names and its outline, but for those that parameter files say otherwise.

    Args:
        parameters: The files' over the shipped ones.
        sim: The simulator's, which may name the robot.
        groups: The groups that run.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    from arjuna_sim.inputs import footprint_of, named_robot, names_of

    if not sim.get("robot") or Path(sim["robot"]) == shipped_file("urdf/arjuna.urdf"):
        return {}  # the shipped parameters are of that one
    robot = named_robot(sim["robot"], sim.get("robot_arguments", ""))
    names = names_of(robot)
    if sim.get("standard_topics"):
        names = {key: name for key, name in names.items() if key == "base_frame"}
    shipped = shipped_parameters()
    own = _unsaid(of_names(names, groups, parameters), parameters, shipped)
    for node, prefix in _COSTMAPS.items():
        frame = _value(merged(parameters, own), node, f"{prefix}robot_base_frame") or "base_link"
        if not any(_said(parameters, shipped, node, f"{prefix}{key}") for key in _SHAPE):
            outline = footprint_of(robot, frame)
            own = merged(own, {node: {f"{prefix}footprint": outline}} if outline else {})
    return own


def _unsaid(own: Parameters, parameters: Parameters, shipped: Parameters) -> Parameters:
    """Return what no file says."""
    return {
        node: {k: value for k, value in values.items() if not _said(parameters, shipped, node, k)}
        for node, values in own.items()
    }


def _said(parameters: Parameters, shipped: Parameters, node: str, key: str) -> bool:
    """Tell whether a file gives a value that is not the shipped one."""
    return bool(_value(parameters, node, key) != _value(shipped, node, key))


def _value(parameters: Parameters, node: str, key: str) -> Any:
    return parameters.get(node, {}).get(key)
