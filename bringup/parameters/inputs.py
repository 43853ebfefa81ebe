"""A command's groups of nodes and their parameters, from all sources, merged and checked."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from functools import cache
from typing import Any

from arjuna_core.errors import ArjunaError, ConfigError
from bringup.parameters.checking import merged_sources, problems_of, read_named_files, write_remarks
from bringup.parameters.files import (
    EVERY_NODE,
    SAFETY,
    SIM_TIME,
    Parameters,
    for_node,
    merged,
    sim_time_of,
)
from bringup.parameters.fusion import between_filters
from bringup.parameters.remarks import Remark
from bringup.parameters.robot_file import (
    Driven,
    contradictions,
    lacking,
    of_robot,
    other_names,
)
from bringup.parameters.sources import is_fleet, of_options, originals_of
from bringup.parameters.world_robots import take_robots_of_world
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
    NodeSpec,
    with_further,
)

_OF_SIMULATED_ROBOT = ("demo", "sim", "slam", "nav")
"""The commands that take topics, frames and outline from a robot's file."""
_MAPS_FIRST: Parameters = {"map_server": {"yaml_filename": ""}}
"""The demo loads the map that it has made, not one that a file names."""
_ENOUGH_CLOUDS: Parameters = {"sim": {"cloud_rate": 10.0}}
"""In the demo nobody but the costmaps looks, the faster of which is updated so often [Hz]."""
_PATHS = {"robot", "world", "yaml_filename", "maps_folder"}
"""Parameters that are checked by reading what they name: the nodes need not be imported for it."""
_PATIENCE = 1.0  # [s] for what runs to be discovered
_GET = "/get_parameters"


def groups_of(arguments: argparse.Namespace) -> tuple[Group, ...]:
    """Return the groups of nodes that a command runs.

    Raises:
        ArjunaError: None is left.
    """
    command = arguments.command
    if command == "demo":
        return DEMO_GROUPS
    if command == "sim" and (is_fleet(vars(arguments)) or arguments.without_description):
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

    With `ask`, a robot that runs already is asked for its clock and its file.

    Raises:
        ArjunaError: A file cannot be used, or a node, key or value is not valid.
    """
    from arjuna_sim.inputs import named_robot

    take_robots_of_world(arguments)
    groups, given = groups_of(arguments), vars(arguments)
    namespace, supervised = given.get("namespace", ""), arguments.command != "demo"
    read = merged_sources(
        arguments.params,
        given.get("param") or (),
        namespace,
        given.get("strict", False),
        originals_of(given),
    )
    parameters = read.parameters
    if not supervised:
        parameters = merged(_ENOUGH_CLOUDS, parameters, _MAPS_FIRST)
    for section in [*parameters]:
        if section.rpartition("/")[2] in (given.get("leave_out") or ()):
            del parameters[section]
    parameters = merged(parameters, between_filters(parameters))
    options = of_options(given, groups, parameters)
    specs = [spec for group in groups for spec in with_further(group, parameters).nodes]
    read_robot = cache(named_robot)  # each once a start
    for spec in specs:
        read_named_files(spec, for_node(merged(parameters, options), spec.name), read_robot)
    if supervised:
        parameters = _with_clock(parameters, specs, given.get("use_sim_time"), ask)
    parameters, unlike = _of_robot(
        parameters, arguments.command, options, groups, namespace, ask, read_robot
    )
    remarks = [*read.remarks, *unlike]
    write_remarks(one for one in remarks if not (supervised and one.safety))
    parameters = merged(parameters, options)
    if {key for values in options.values() for key in values} - _PATHS and (
        problems := problems_of(parameters, specs)
    ):
        raise ConfigError(*problems)
    if supervised:
        parameters[SAFETY] = _safety_lines(remarks, groups)
    return parameters


def _of_robot(
    parameters: Parameters,
    command: str,
    options: Parameters,
    groups: Sequence[Group],
    namespace: str,
    ask: bool,
    read_robot: Callable[[str, str], Any],
) -> tuple[Parameters, list[Remark]]:
    """Return parameters with what the robot's own file adds to them, and what contradicts it.

    Of a real robot there may be no file; its topics and frames are its drivers'.
    """
    robot, simulated = options.get("sim", {}), command in _OF_SIMULATED_ROBOT
    if simulated:
        robot = {**for_node(parameters, "sim"), **robot}
        if not robot.get("robot") and ask:
            robot = _robot_of_simulator(namespace)
            simulated = bool(robot)
    driven = Driven(robot, read_robot)
    if simulated or "robot" in robot:
        named = merged(parameters, options)
        parameters = merged(parameters, of_robot(named, driven, groups, simulated))
    known = NAVIGATION_GROUP in groups and (simulated or "robot" in robot)
    remarks = list(contradictions(parameters, driven)) if known else []
    if known and simulated:
        remarks += lacking(driven)
        remarks += other_names(merged(parameters, options), driven, groups, namespace)
    return parameters, remarks


def _safety_lines(remarks: Iterable[Remark], groups: Sequence[Group]) -> dict[str, Any]:
    """Return the lines that each group logs at its start; the first has those of no node."""
    found: dict[str, Any] = {}
    for remark in remarks:
        node = remark.where.partition(": ")[0]
        of = [group for group in groups for spec in group.nodes if spec.name == node]
        if remark.safety:
            found.setdefault((of or groups)[0].name, []).append(str(remark))
    return found


def _with_clock(
    parameters: Parameters, specs: Iterable[NodeSpec], insisted: bool | None, ask: bool
) -> Parameters:
    """Return parameters in which every node has one clock.

    A file that says `use_sim_time: false` is one that a launch file's argument overrides: where a
    simulator publishes /clock, its time is taken all the same, and that is written.
    """
    simulated = sim_time_of(parameters, [spec.name for spec in specs])
    if insisted is not None:
        simulated = insisted
    elif not simulated and ask:
        from bringup.client.session import Connection

        with closing(Connection("clock_probe")) as session:
            simulated = session.run_until(
                lambda: bool(session.client.count_publishers("/clock")), _PATIENCE, required=False
            )
        if simulated:
            sys.stderr.write(
                "use_sim_time: false in a file, but a simulator publishes /clock: its time is"
                " taken ('--use-sim-time false' insists)\n"
            )
    plain = {
        node: {key: value for key, value in values.items() if key != SIM_TIME}
        for node, values in parameters.items()
    }
    plain.setdefault(EVERY_NODE, {})[SIM_TIME] = simulated
    return plain


def _robot_of_simulator(namespace: str) -> dict[str, Any]:
    """Return the robot's parameters of the simulator that runs, if one does; imports rclpy."""
    from rcl_interfaces.srv import GetParameters
    from rclpy.parameter import parameter_value_to_python

    from bringup.client.session import ClientError, Connection

    asked = ["robot", "robot_arguments", "standard_topics", "namespaces", "robots"]
    services = [*([f"/{namespace}/sim{_GET}"] if namespace else []), f"/sim{_GET}"]
    with closing(Connection("robot_probe")) as session:

        def values_of(services: list[str], names: list[str]) -> list[Any]:
            request = GetParameters.Request(names=names)
            try:
                answer = session.call(GetParameters, services, request, _PATIENCE)
            except ClientError:
                return []
            return list(map(parameter_value_to_python, answer.values))

        if not (answered := values_of(services, asked)):
            return {}
        *found, namespaces, robots = answered
        values = dict(zip(asked, found, strict=False))
        if namespace in (namespaces or ()) and robots:
            values["robot"] = robots[list(namespaces).index(namespace)]
        elif namespace and (own := values_of([f"/{namespace}/simulated_robot{_GET}"], ["robot"])):
            values["robot"] = own[0]  # it was spawned
        return values
