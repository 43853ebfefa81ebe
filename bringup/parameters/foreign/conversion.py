"""Others' parameter files by our names: ROS 1's, and any that Nav2 takes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import is_xml
from arjuna_core.files.yaml_file import read_yaml
from bringup.parameters.checking import problems_of
from bringup.parameters.files import Parameters, load_parameters, shipped_parameters
from bringup.parameters.foreign.launch_file import LaunchFile
from bringup.parameters.foreign.ros1 import convert
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.listing import values_of
from bringup.parameters.sources import with_base_frame
from bringup.stack import all_nodes

_SMOOTHED = {".max_linear_accel": ("max_accel", 1.0), ".max_linear_decel": ("max_decel", -1.0)}
"""The velocity smoother's limit for each of a controller's, and its sign there."""


class Conversion(NamedTuple):
    """A file by our names.

    Attributes:
        notes: The names without meaning here, a line each.
        unknown: A sentence for each name that nobody knows.
        problems: A sentence for each value that is not valid, and where nothing is left.
    """

    text: str
    notes: list[str]
    unknown: list[str]
    problems: list[str]


def converted(path: Path) -> Conversion:
    """Return a ROS 1 or ROS 2 parameter file, or a launch file of ROS 1, by our names.

    Raises:
        InputFileError: It is none of these, or not of names and values.
    """
    given, notes, unknown = _given(path)
    below = shipped_parameters()
    understood = understand(_smoothed(with_base_frame(given, below)), {}, all_nodes())
    specs = [spec for spec in all_nodes() if spec.name in understood.parameters]
    whole = understand(understood.parameters, below, all_nodes()).parameters
    problems = [*understood.problems, *problems_of(whole, specs)]
    if not any(understood.parameters.values()) and not problems:
        problems = ["nothing in it has a meaning here"]
    notes = [*notes, *map(str, understood.remarks)]
    return Conversion(_as_text(understood.parameters), notes, unknown, problems)


def _smoothed(given: Parameters) -> Parameters:
    """Return parameters in which the velocity smoother has the limits of a controller.

    Source: nav2_regulated_pure_pursuit_controller had them before the smoother was there.
    """
    controllers = dict(given.get("controller_server", {}))
    smoother = dict(given.get("velocity_smoother", {}))
    spec = next(spec for spec in all_nodes() if spec.name == "velocity_smoother")
    for key in list(controllers):
        name, sign = next((of for end, of in _SMOOTHED.items() if key.endswith(end)), ("", 0.0))
        if name and isinstance(controllers[key], int | float) and name not in smoother:
            limits = list(values_of(spec.config, {})[name])
            smoother[name] = [sign * float(controllers.pop(key)), *limits[1:]]
    found = {**given, "controller_server": controllers, "velocity_smoother": smoother}
    return {node: values for node, values in found.items() if values or node in given}


def _given(path: Path) -> tuple[Parameters, list[str], list[str]]:
    """Return a file's parameters, its names without meaning here, and those that nobody knows."""
    if is_xml(path):
        launch = LaunchFile(path)
        parameters, without, unknown = convert(launch.document, launch.topics)
        return parameters, [*launch.notes, *without], unknown
    document = read_yaml(path)
    if not isinstance(document, Mapping):
        kind = "a text" if isinstance(document, str) else repr(document)
        raise InputFileError(path, f"expected names and values in YAML, got {kind}")
    return (load_parameters([path]), [], []) if _is_ros2(document) else convert(document)


def _is_ros2(document: Mapping[str, Any]) -> bool:
    return "ros__parameters" in document or any(
        isinstance(value, Mapping) and _is_ros2(value) for value in document.values()
    )


def _as_text(parameters: Parameters) -> str:
    set_ones = {node: values for node, values in parameters.items() if values}
    nodes = {f"/{node}": {"ros__parameters": values} for node, values in set_ones.items()}
    return yaml.safe_dump(nodes, sort_keys=False, default_flow_style=None, width=100)
