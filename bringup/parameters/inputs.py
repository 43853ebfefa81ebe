"""What the command line and parameter files ask for, as the nodes' parameters, checked."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from arjuna_core.errors import ArjunaError, ConfigError, InputFileError
from arjuna_core.files.maps import load_map
from bringup.parameters.clock import with_clock
from bringup.parameters.composition import check_parameters, node_class, problems_of
from bringup.parameters.files import (
    Parameters,
    for_node,
    lines_of,
    load_parameters,
    merged,
    node_of,
    shipped_parameters,
)
from bringup.parameters.fleet_options import is_fleet, of_starts
from bringup.parameters.foreign.older import section_as_today
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.remarks import Kind, Remark, lines
from bringup.parameters.robot_names import of_names
from bringup.parameters.simulated_robot import of_simulated_robot
from bringup.stack import (
    DESCRIPTION_GROUP,
    ODOMETRY_GROUP,
    REAL_STACKS,
    STACKS,
    VELOCITY_CHAIN,
    WORLD_GROUP,
    Group,
    NodeSpec,
)

DEMO_GROUPS = tuple(dict.fromkeys(group for groups in STACKS.values() for group in groups))
"""Every group: the demo runs them all, and a parameter file may name any node of theirs."""
ALL_GROUPS = (*DEMO_GROUPS, WORLD_GROUP, DESCRIPTION_GROUP, ODOMETRY_GROUP)
"""Those, and the ones that several robots or a real one have in place of the simulator's."""

_STAMPED = "enable_stamped_cmd_vel"
_OF_SIMULATED_ROBOT = ("demo", "slam", "nav")
"""The commands that take topics, frames and outline from a robot's file."""
_MAPS_FIRST: Parameters = {"map_server": {"yaml_filename": ""}}
"""The demo loads the map that it has made, not one that a file names."""
_PATHS = {"robot", "world", "yaml_filename", "maps_folder"}
"""Parameters that are checked by reading what they name: the nodes need not be imported for it."""


def groups_of(arguments: argparse.Namespace) -> tuple[Group, ...]:
    """Return the groups of nodes that a command runs."""
    command = arguments.command
    if command == "demo":
        return DEMO_GROUPS
    if command == "sim" and is_fleet(vars(arguments)):
        return (WORLD_GROUP,)
    if vars(arguments).get("slam"):
        command += " --slam"
    if command in STACKS:
        return STACKS[command]
    without = {DESCRIPTION_GROUP} if arguments.robot is None else set()
    without |= {ODOMETRY_GROUP} if arguments.imu is None else set()
    return tuple(group for group in REAL_STACKS[command] if group not in without)


def gather(arguments: argparse.Namespace) -> Parameters:
    """Return the parameters of all nodes, the command line's over the files' over the shipped.

    Args:
        arguments: What `cli_parser.parse` returned.

    Raises:
        ArjunaError: A file cannot be used, or a node, key or value is not valid.
    """
    groups = groups_of(arguments)
    options_given = vars(arguments)
    parameters = over_shipped(
        arguments.params, options_given.get("namespace", ""), options_given.get("strict", False)
    )
    options = _of_options(arguments, groups)
    options = merged(options, of_names(vars(arguments), groups))
    if arguments.command != "demo":
        parameters = with_clock(parameters, groups, options_given.get("use_sim_time"))
    if arguments.command == "demo":
        parameters = merged(parameters, _MAPS_FIRST)
    if arguments.command in _OF_SIMULATED_ROBOT:
        parameters = merged(parameters, of_simulated_robot(parameters, options, groups))
    parameters = merged(parameters, options)
    if {key for values in options.values() for key in values} - _PATHS:
        check_parameters(parameters, groups)
    for group in groups:
        for spec in group.nodes:
            _read_files(spec, for_node(parameters, spec.name))
    return parameters


def over_shipped(paths: Iterable[Path], namespace: str = "", strict: bool = False) -> Parameters:
    """Return the shipped parameters under those of files; write what of each has no effect.

    Args:
        paths: The files; what a later one says wins.
        namespace: Of the robot, which the files' nodes may stand below.
        strict: Whether an unknown name refuses a file.

    Raises:
        ArjunaError: A file cannot be used.
    """
    parameters = shipped_parameters()
    for path in paths:
        read = read_over(path, parameters, namespace)
        if problems := read.refused_by(strict):
            raise ConfigError(*problems)
        listing = f"'params check -v {path}'"
        for line in lines(read.remarks, (Kind.NO_EFFECT, Kind.NOT_NEEDED), listing):
            sys.stderr.write(f"{line}\n")
        parameters = read.parameters
    return _of_one_type(parameters)


def _of_one_type(parameters: Parameters) -> Parameters:
    """Return parameters in which the whole chain of velocities is stamped if one of it is."""
    if not any(parameters.get(name, {}).get(_STAMPED) for name in VELOCITY_CHAIN):
        return parameters
    return merged({name: {_STAMPED: True} for name in VELOCITY_CHAIN}, parameters)


def all_nodes() -> list[NodeSpec]:
    """Return every node there is."""
    return [spec for group in DEMO_GROUPS for spec in group.nodes]


class ReadFile(NamedTuple):
    """A parameter file, read over what holds below it.

    Attributes:
        parameters: Of all nodes.
        remarks: The names without effect, with file and line.
        problems: What refuses the file, a sentence each, with file and line.
    """

    parameters: Parameters
    remarks: list[Remark]
    problems: list[str]

    def refused_by(self, strict: bool) -> list[str]:
        """Return what refuses the file; where it is strict, unknown names too."""
        unknown = [str(one) for one in self.remarks if one.kind is Kind.UNKNOWN]
        return [*self.problems, *(unknown if strict else ())]


def read_over(path: Path, below: Parameters, namespace: str = "") -> ReadFile:
    """Read a parameter file over what holds below it.

    Raises:
        InputFileError: The file cannot be read, is no YAML or of another form.
    """
    given = load_parameters([path])
    understood = understand(given, below, all_nodes(), namespace)
    after = understood.parameters
    specs = [spec for spec in all_nodes() if after.get(spec.name) != below.get(spec.name)]
    problems = [*understood.problems, *problems_of(understood.parameters, specs)]
    at = _Places(path, given)
    remarks = [one._replace(place=at(one.where)) for one in understood.remarks]
    return ReadFile(understood.parameters, remarks, [f"{at(text)}: {text}" for text in problems])


class _Places:
    """Finds file and line of what a sentence is about: `node: key...` or `node: 'key'...`."""

    def __init__(self, path: Path, given: Parameters) -> None:
        self._path, self._lines = path, lines_of(path)
        nodes = {spec.name for spec in all_nodes()}
        for (name, key), line in list(self._lines.items()):
            node = node_of(section_as_today(name), nodes)
            self._lines.setdefault((node or name, key), line)

    def __call__(self, sentence: str) -> str:
        node, _, rest = sentence.partition(": ")
        found = re.search(r"'([^']+)'", rest) or re.match(r"(\S+)", rest)
        line = self._lines.get((node, found[1] if found else "")) or self._lines.get((node, ""))
        return f"{self._path}:{line}" if line else str(self._path)


def check_file(path: Path) -> ReadFile:
    """Read a parameter file over the shipped ones, and the files that its parameters name."""
    try:
        read = read_over(path, shipped_parameters())
    except InputFileError as error:
        return ReadFile({}, [], [str(error)])
    for spec in all_nodes():
        values = for_node(read.parameters, spec.name)
        lacking = _lacking_map(values) if spec.name == "map_server" else ""
        if lacking:
            reason = f"there is no {lacking}; 'nav --map FILE' takes its place"
            read.remarks.append(Remark(Kind.NO_EFFECT, f"{spec.name}: yaml_filename", reason))
            continue
        try:
            _read_files(spec, values)
        except ArjunaError as error:
            read.problems.append(f"{path}: {spec.name}: {error}")
    return read


def _lacking_map(values: Mapping[str, Any]) -> str:
    """Return the map that stock files name and nobody has, or nothing."""
    name = str(values.get("yaml_filename") or "")
    return "" if Path(name).exists() else name


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


def _read_files(spec: NodeSpec, values: dict[str, Any]) -> None:
    """Read the files that a node's parameters name: a bad one is refused before anything starts."""
    if spec.name in ("sim", "robot_state_publisher") and values.get("robot"):
        from arjuna_sim.inputs import named_robot

        named_robot(values["robot"], values.get("robot_arguments", ""))
    if spec.name == "sim" and values.get("robots"):
        from arjuna_sim.inputs import named_robot

        for path in values["robots"]:
            named_robot(path, values.get("robot_arguments", ""))
    if spec.name == "sim" and values.get("viewer"):
        from arjuna_sim.physics.viewer import need_screen

        need_screen()
    if spec.name == "sim" and values.get("world"):
        from arjuna_sim.inputs import named_world

        named_world(values["world"])
    if spec.name == "map_server" and values.get("yaml_filename"):
        load_map(values["yaml_filename"])
