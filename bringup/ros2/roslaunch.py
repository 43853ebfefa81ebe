"""Launch files of ROS 1: what starts the same here, as commands."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.files.input_file import head_of, is_xml
from arjuna_core.files.shipped import shipped_file
from bringup.parameters.foreign.conversion import converted
from bringup.parameters.foreign.launch_file import LaunchFile, Program
from bringup.ros2.verbs.forward import PROGRAMS, executables_of, remedy

_SIGNS = re.compile(rb"<node[^>]*\stype=|\$\((find|arg)\s|<rosparam")
_SIGNS_OF_ROS2 = re.compile(rb"<node[^>]*\sexec=|\$\((find-pkg-\w+|var)\s")
_BURGER = str(shipped_file("urdf/burger.urdf"))
_WORLDS = {
    "turtlebot3_empty_world.launch": ("empty", ("0", "0")),
    "turtlebot3_world.launch": ("pillar_arena", ("-2", "-0.5")),
    "turtlebot3_house.launch": ("office", ("0", "0")),
}
_WITH_SIMULATOR = {"robot_state_publisher", "joint_state_publisher", "turtlebot3_remote.launch"}
_POSE = {"-x": "x", "-y": "y", "-Y": "yaw"}
_RENAMED = {"tf": "tf2_ros", "tf2_ros": "tf2_ros"}


@dataclass
class _Found:
    """Programs of a file, as found."""

    world: str = ""
    robot: str = ""
    start: dict[str, str] = field(default_factory=dict)
    map: str = ""
    parts: set[str] = field(default_factory=set)
    others: list[list[str]] = field(default_factory=list)


def is_ros1(path: Path) -> bool:
    """Return whether a launch file is of ROS 1; one that mixes it with ROS 2 is not."""
    text = head_of(path, 2**20) if is_xml(path) else b""
    return bool(_SIGNS.search(text)) and not _SIGNS_OF_ROS2.search(text)


def commands(
    path: Path, keep: Callable[[str], Path]
) -> tuple[list[list[str]], list[str], list[str]]:
    """Return the commands that start what a ROS 1 launch file does, notes, and what cannot be.

    Each command begins with one of `arjuna`, or with `run` of `ros2`.

    Raises:
        InputFileError: The file, or one that it includes, cannot be used.
    """
    file, found = LaunchFile(path), _Found()
    found.robot = file.description
    for program in file.programs:
        _take(found, program)
    known = {program.name for program in file.programs if program.name.endswith(".launch")}
    problems = [note for note in file.notes if not any(name in note for name in known)]
    problems += [
        f"{one.name}: '{' '.join(one.given)}' has no value; {remedy('')}"
        for one in file.programs
        if any("$(" in word for word in one.given)
    ]
    parameters = []
    if {"amcl", "move_base", "slam"} & found.parts and any(file.document.values()):
        conversion = converted(path)
        problems += [*conversion.unknown, *conversion.problems]
        parameters = ["--params", str(keep(conversion.text))]
    made, missing = _commands(found, parameters)
    return made, problems, missing


def commands_of(package: str, file: str, words: list[str]) -> list[list[str]]:
    """Return the commands of a known launch file of ROS 1; none where it is not known."""
    found = _Found()
    _take(found, Program(package, file, tuple(words)))
    return [command for command in _commands(found, [])[0] if command[:3] != ["run", package, file]]


def _commands(found: _Found, parameters: list[str]) -> tuple[list[list[str]], list[str]]:
    made, problems = _simulator(found), []
    if {"amcl", "move_base", "slam"} & found.parts:
        made += _navigation(found, parameters)
    elif found.map:
        made.append(_map_server(found.map))
    for words in found.others:
        package, name = words[1:3]
        own = executables_of(package)
        if words[0] == "run" and name not in own and (package, name) not in PROGRAMS:
            problems.append(f"{package} {name} is not started: {remedy(package)}")
        else:
            made.append(words)
    return made, problems


def _take(found: _Found, program: Program) -> None:
    package, name, given, _ = program
    arguments = dict(word.split(":=", 1) for word in given if ":=" in word)
    options = dict(itertools.pairwise(given))
    if name in ("empty_world.launch", "gzserver", "gazebo"):
        found.world = arguments.get("world_name", "") or next(iter(given), "empty.world")
    elif name in _WORLDS:
        world, start = _WORLDS[name]
        found.world, found.robot = str(shipped_file(f"worlds/{world}.world")), _BURGER
        pairs = zip("xy", start, strict=True)
        found.start = {axis: arguments.get(f"{axis}_pos", usual) for axis, usual in pairs}
    elif name in ("spawn_model", "spawn_urdf"):
        found.start = {of: options[word] for word, of in _POSE.items() if word in options}
        found.robot = options.get("-file", found.robot)
    elif name == "map_server":
        found.map = next((word for word in given if word[:1] not in "_-"), "")
    elif name in ("amcl", "amcl.launch", "move_base", "move_base.launch"):
        found.parts.add(name.removesuffix(".launch"))
    elif name == "turtlebot3_navigation.launch":
        found.parts |= {"amcl", "move_base"}
        found.map = arguments.get("map_file", "")
    elif name in ("slam_gmapping", "turtlebot3_slam.launch"):
        found.parts.add("slam")
    elif name == "rviz":
        found.others.append(["view", *(["--config", options["-d"]] if "-d" in options else [])])
    elif name in ("teleop_twist_keyboard.py", "turtlebot3_teleop_key.launch"):
        found.others.append(["run", "teleop_twist_keyboard", "teleop_twist_keyboard"])
    elif name == "static_transform_publisher":
        found.others.append(["run", "tf2_ros", name, *given[:-1]])  # the last is the period
    elif name not in _WITH_SIMULATOR or not found.world:
        found.others.append(["run", _RENAMED.get(package, package), name, *given])


def _simulator(found: _Found) -> list[list[str]]:
    if not found.world:
        return []
    at = ["--at", found.start.get("x", "0"), found.start.get("y", "0")]
    at = at if found.robot or found.start else []  # else a robot that the world has
    yaw = ["--yaw", found.start["yaw"]] if "yaw" in found.start else []
    robot = ["--robot", found.robot] if found.robot else []
    return [["sim", "--world", found.world, *robot, *at, *yaw]]


def _navigation(found: _Found, parameters: list[str]) -> list[list[str]]:
    if "slam" in found.parts:
        whole = "move_base" in found.parts
        return [["nav", "--slam", *parameters] if whole else ["slam", *parameters]]
    made = []
    if "amcl" in found.parts and found.map:
        where = ["--map", found.map]
    else:
        where = ["--without-localization"]
        made += [_map_server(found.map)] if found.map else []
    part = [] if "move_base" in found.parts else ["--without-navigation"]
    return [*made, ["nav", *where, *part, *parameters]]


def _map_server(file: str) -> list[str]:
    return ["run", "nav2_map_server", "map_server", "--ros-args", "-p", f"yaml_filename:={file}"]
