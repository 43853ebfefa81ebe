"""Others' parameter files written anew by our names: ROS 1's, and any that Nav2 takes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import read_yaml
from bringup.parameters.composition import problems_of
from bringup.parameters.files import Parameters, load_parameters, shipped_parameters
from bringup.parameters.inputs import all_nodes
from bringup.parameters.ros1 import convert
from bringup.parameters.stock import understand


class Conversion(NamedTuple):
    """A file by our names.

    Attributes:
        text: What to write.
        notes: What has no meaning here, a line each.
        problems: What nobody knows, and values that are not valid, a sentence each.
    """

    text: str
    notes: list[str]
    problems: list[str]


def converted(path: Path) -> Conversion:
    """Return a ROS 1 or ROS 2 parameter file by our names.

    Raises:
        InputFileError: It is no YAML, or not of names and values.
    """
    document = read_yaml(path)
    if not isinstance(document, Mapping):
        raise InputFileError(path, f"expected names and values, got {document!r}")
    notes: list[str] = []
    problems: list[str] = []
    if _is_ros2(document):
        given = load_parameters([path])
    else:
        given, notes, problems = convert(document)
    understood = understand(given, {}, all_nodes())
    problems = [*problems, *understood.problems]
    specs = [spec for spec in all_nodes() if spec.name in understood.parameters]
    whole = understand(understood.parameters, shipped_parameters(), all_nodes()).parameters
    problems += problems_of(whole, specs, [spec.name for spec in all_nodes()])
    return Conversion(_as_text(understood.parameters), [*notes, *understood.notes], problems)


def _is_ros2(document: Mapping[str, Any]) -> bool:
    return "ros__parameters" in document or any(
        isinstance(value, Mapping) and _is_ros2(value) for value in document.values()
    )


def _as_text(parameters: Parameters) -> str:
    nodes = {f"/{node}": {"ros__parameters": values} for node, values in parameters.items()}
    return yaml.safe_dump(nodes, sort_keys=False, default_flow_style=None, width=100)
