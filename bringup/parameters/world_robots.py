"""Robots that stand in a world's file: they are driven where no other robot is asked for."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from arjuna_core.errors import RobotError
from arjuna_core.se2 import IDENTITY, SE2
from bringup.parameters.files import for_node

_ASKED = ("robot", "robots", "starts", "initial_pose")


def take_robots_of_world(arguments: argparse.Namespace) -> None:
    """Name the robots of the world's file as those to be simulated, unless others are named.

    One has the simulator for its own, as any robot; of `sim` several each have a namespace, their
    name. They start where the world puts them, unless places are named.

    Raises:
        ArjunaError: A file cannot be used.
    """
    from arjuna_sim.files.robots.robot_file import load_robot, split_model

    given = vars(arguments)
    names = given.get("namespaces") or []
    asked = given.get("robots") or [file for file in [given.get("robot")] if file is not None]
    world = given.get("world") or (None if asked else _world_of_files(given))
    if world is None or (asked and given.get("ats")):
        return
    if any(split_model(file)[0].resolve() != world.resolve() for file in asked):
        return
    starts = {file: load_robot(file).start or IDENTITY for file in asked} or _held(world)
    if arguments.command != "sim" or len(names) == 1:
        starts = dict(list(starts.items())[:1])
    if not starts or len(names) not in (0, 1, len(starts)):
        return
    arguments.robot, arguments.robots = next(iter(starts)), list(starts)
    if len(starts) > 1:
        spaces = (re.sub(r"\W|^(?=\d)", "_", str(f).rpartition("#")[2], flags=re.A) for f in starts)
        arguments.namespaces = names or list(spaces)
        below = ", ".join(f"/{space}/cmd_vel" for space in arguments.namespaces)
        sys.stderr.write(f"{world} holds {len(starts)} robots: {below}\n")
    if not given.get("ats"):
        arguments.ats = [[start.x, start.y] for start in starts.values()]
        arguments.yaws = given.get("yaws") or [start.theta for start in starts.values()]


def _world_of_files(given: Mapping[str, Any]) -> Path | None:
    """Return the world that parameter files name, where these name neither robot nor start."""
    from bringup.parameters.checking import merged_sources

    files, words = given.get("params") or (), given.get("param") or ()
    if "world" not in given or not (files or words):
        return None
    read = merged_sources(files, words, given.get("namespace", "")).parameters
    values = for_node(read, "sim")
    asked = [key for key in values if key.split(".")[0] in _ASKED and values[key]]
    return Path(values["world"]) if values.get("world") and not asked else None


def _held(world: Path) -> dict[Path, SE2]:
    """Return the robots that a world's file holds, and where each starts."""
    from arjuna_sim.files.robots.robot_file import load_robot
    from arjuna_sim.files.world_file import robots_in

    starts: dict[Path, SE2] = {}
    for name in robots_in(world):
        file = Path(f"{world}#{name}")
        try:
            robot = load_robot(file)
        except RobotError as error:
            sys.stderr.write(f"{file} is taken for a thing: it cannot be a robot: {error}\n")
            continue
        if robot.drive.wheels:
            starts[file] = robot.start or IDENTITY
    return starts
