"""What the command line and parameter files ask for, as the nodes' parameters, checked."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError
from bringup.parameters.composition import check_parameters, node_class
from bringup.parameters.files import SAFETY, Parameters, for_node, merged
from bringup.parameters.fleet_options import is_fleet, of_starts
from bringup.parameters.given import with_words
from bringup.parameters.reading import read_files, read_named_files, write_remarks
from bringup.parameters.remarks import Remark
from bringup.parameters.robot_names import of_names
from bringup.parameters.running import robot_of_simulator, with_clock
from bringup.parameters.simulated_robot import of_simulated_robot
from bringup.stack import (
    DEMO_GROUPS,
    DESCRIPTION_GROUP,
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    ODOMETRY_GROUP,
    REAL_STACKS,
    SLAM_GROUP,
    STACKS,
    WORLD_GROUP,
    Group,
)

_OF_SIMULATED_ROBOT = ("demo", "slam", "nav")
"""The commands that take topics, frames and outline from a robot's file."""
_MAPS_FIRST: Parameters = {"map_server": {"yaml_filename": ""}}
"""The demo loads the map that it has made, not one that a file names."""
_PATHS = {"robot", "world", "yaml_filename", "maps_folder"}
"""Parameters that are checked by reading what they name: the nodes need not be imported for it."""


def groups_of(arguments: argparse.Namespace) -> tuple[Group, ...]:
    """Return the groups of nodes that a command runs.

    Raises:
        ArjunaError: None is left.
    """
    command = arguments.command
    if command == "demo":
        return DEMO_GROUPS
    if command == "sim" and is_fleet(vars(arguments)):
        return (WORLD_GROUP,)
    if vars(arguments).get("slam"):
        command += " --slam"
    without: set[Group] = set()
    if vars(arguments).get("without_localization"):
        without |= {LOCALIZATION_GROUP, SLAM_GROUP}
    if vars(arguments).get("without_navigation"):
        without |= {NAVIGATION_GROUP}
    if command in REAL_STACKS:
        without |= {DESCRIPTION_GROUP} if arguments.robot is None else set()
        without |= {ODOMETRY_GROUP} if arguments.imu is None else set()
    stacks = {**STACKS, **REAL_STACKS}
    groups = tuple(group for group in stacks[command] if group not in without)
    if not groups:
        raise ArjunaError("nothing is left to run: leave out localization or navigation, not both")
    return groups


def gather(arguments: argparse.Namespace, ask: bool = False) -> Parameters:
    """Return the parameters of all nodes, the command line's over the files' over the shipped.

    Args:
        arguments: What `cli_parser.parse` returned.
        ask: Whether what runs already is asked for its clock and its robot.

    Raises:
        ArjunaError: A file cannot be used, or a node, key or value is not valid.
    """
    groups = groups_of(arguments)
    given = vars(arguments)
    read = read_files(arguments.params, given.get("namespace", ""), given.get("strict", False))
    supervised = arguments.command != "demo"
    write_remarks(one for one in read.remarks if not (supervised and one.safety))
    named = with_words(read.parameters, given.get("param") or [], given.get("namespace", ""))
    parameters = named if supervised else merged(named, _MAPS_FIRST)
    options = _of_options(arguments, groups)
    options = merged(options, of_names(vars(arguments), groups, parameters))
    for spec in (spec for group in groups for spec in group.nodes):
        read_named_files(spec, for_node(merged(parameters, options), spec.name))
    if supervised:
        parameters = with_clock(parameters, groups, given.get("use_sim_time"), ask)
    if arguments.command in _OF_SIMULATED_ROBOT:
        robot = {**for_node(parameters, "sim"), **options.get("sim", {})}
        if not robot.get("robot") and ask:
            robot = robot_of_simulator(given.get("namespace", ""))
        parameters = merged(parameters, of_simulated_robot(parameters, robot, groups))
    parameters = merged(parameters, options)
    if {key for values in options.values() for key in values} - _PATHS:
        check_parameters(parameters, groups)
    if supervised:
        parameters[SAFETY] = _safety_lines(read.remarks, groups)
    return parameters


def _safety_lines(remarks: Iterable[Remark], groups: Sequence[Group]) -> dict[str, Any]:
    """Return the lines that each group logs at its start; the first has those of no node."""
    found: dict[str, Any] = {}
    for remark in remarks:
        node = remark.where.partition(": ")[0]
        of = [group for group in groups for spec in group.nodes if spec.name == node]
        if remark.safety:
            found.setdefault((of or groups)[0].name, []).append(str(remark))
    return found


def _of_options(arguments: argparse.Namespace, groups: tuple[Group, ...]) -> Parameters:
    """Return the parameters that command line options stand for."""
    options = vars(arguments)
    found: Parameters = {}

    def put(node: str, key: str, value: Any) -> None:
        if value is not None:
            found.setdefault(node, {})[key] = value

    put("sim", "world", _absolute(options.get("world")))
    for node in ("sim", "robot_state_publisher"):
        put(node, "robot", _absolute(options.get("robot")))
        put(node, "robot_arguments", shlex.join(options.get("robot_arguments") or []) or None)
    for key, value in of_starts(options).items():
        put("sim", key, value)
    put("sim", "viewer", options.get("viewer") or None)
    put("sim", "real_time_factor", options.get("rtf"))
    put("map_server", "yaml_filename", _absolute(options.get("map")))
    for node in ("map_saver", "map_server", "slam_toolbox"):
        put(node, "maps_folder", _absolute(options.get("maps_folder")))
    seed = options.get("seed")
    for spec in (spec for group in groups for spec in group.nodes if seed is not None):
        if "seed" in node_class(spec).Config.__dataclass_fields__:
            put(spec.name, "seed", seed)
    return found


def _absolute(path: Path | None) -> str | None:
    return None if path is None else str(path.resolve())
