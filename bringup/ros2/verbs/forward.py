"""The commands that hand all their words on: `ros2 run`, `bag`, `doctor`, `daemon`."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Callable
from typing import NoReturn

from arjuna_core.errors import nearest
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.bag import VERBS, translated

_PROGRAMS = "bringup.ros2.programs"


def _teleop(words: list[str]) -> NoReturn:
    """Run teleop_twist_keyboard: its parameters and remapping as our options."""
    _, remapped, parameters = ros_arguments(words)
    options = ["--keys", "twist"]
    if "cmd_vel" in remapped:
        options += ["--topic", remapped["cmd_vel"]]
    for name in ("speed", "turn"):
        if name in parameters:
            options += [f"--{name}", parameters[name]]
    if parameters.get("stamped", "").lower() == "true":
        options.append("--stamped")
    arjuna("teleop", options)


def _save_map(words: list[str]) -> NoReturn:
    """Run map_saver_cli: its options as ours."""
    rest, remapped, parameters = ros_arguments(words)
    parser = argparse.ArgumentParser(prog="ros2 run nav2_map_server map_saver_cli")
    parser.add_argument("-f", dest="name", default="map", help="path without suffix (map)")
    parser.add_argument("-t", dest="topic", default=remapped.get("map"), help="the map's (map)")
    for name in ("occ", "free", "mode", "fmt"):
        parser.add_argument(f"--{name}", help=f"as 'arjuna save-map --{name}'")
    given = vars(parser.parse_args(rest))
    options = [given.pop("name"), "--timeout", parameters.get("save_map_timeout", "10.0")]
    for name, value in given.items():
        options += [f"--{name}", value] if value is not None else []
    arjuna("save-map", options)


# What `ros2 run PACKAGE EXECUTABLE` runs
PROGRAMS: dict[tuple[str, str], str | Callable[[list[str]], None]] = {
    ("nav2_map_server", "map_saver_cli"): _save_map,
    ("teleop_twist_keyboard", "teleop_twist_keyboard"): _teleop,
    ("tf2_ros", "static_transform_publisher"): f"{_PROGRAMS}.static_transform_publisher",
    ("tf2_ros", "tf2_echo"): f"{_PROGRAMS}.tf2_echo",
    ("tf2_tools", "view_frames"): f"{_PROGRAMS}.view_frames",
}


def ros_arguments(words: list[str]) -> tuple[list[str], dict[str, str], dict[str, str]]:
    """Part a program's own words from those between `--ros-args` and `--`.

    Returns:
        Its own words, the remapped names (without leading slash) and the parameters.
    """
    own: list[str] = []
    remapped: dict[str, str] = {}
    parameters: dict[str, str] = {}
    target, for_ros = None, False
    for word in words:
        if word in ("--ros-args", "--") and (for_ros or word == "--ros-args"):
            for_ros = word == "--ros-args"
        elif not for_ros:
            own.append(word)
        elif word in ("-r", "--remap"):
            target = remapped
        elif word in ("-p", "--param"):
            target = parameters
        elif ":=" in word and target is not None:
            name, value = word.split(":=", maxsplit=1)
            target[name.lstrip("/")] = value
    return own, remapped, parameters


def arjuna(command: str, words: list[str]) -> NoReturn:
    """Become `arjuna COMMAND`, which stands above this wing."""
    program = [sys.executable, "-m", "bringup", command, *words]
    os.execv(sys.executable, program)  # noqa: S606 - our own module


def run(words: list[str]) -> int:
    """Run a program of a package.

    Raises:
        Ros2Error: There is no such package or program.
    """
    if len(words) < 2 or words[0] in ("-h", "--help"):
        print("usage: ros2 run [-h] package_name executable_name ...\n")
        print("\n".join(f"  {package} {name}" for package, name in sorted(PROGRAMS)))
        return 0 if words[:1] in (["-h"], ["--help"]) else 2
    package, name = words[:2]
    if package not in {known for known, _ in PROGRAMS}:
        valid = nearest(package, {known for known, _ in PROGRAMS})
        raise Ros2Error(f"Package '{package}' not found; {valid}")
    if (package, name) not in PROGRAMS:
        valid = nearest(name, {known for other, known in PROGRAMS if other == package})
        raise Ros2Error(f"No executable found; {valid}")
    program = PROGRAMS[package, name]
    if isinstance(program, str):
        module = importlib.import_module(program)
        own, _, _ = ros_arguments(words[2:])  # rclpy reads the others itself
        module.main(own)
    else:
        program(words[2:])
    return 0


def daemon(words: list[str]) -> None:
    """Say that there is no daemon; scripts that stop or start it go on."""
    if words[:1] == ["status"] or words[:1] == ["stop"]:
        print("The daemon is not running")
    else:
        print("There is no daemon: every command looks at the graph itself")


def bag(words: list[str]) -> None:
    """Record, play or describe a recording."""
    if words[:1] in ([], ["-h"], ["--help"]):
        print("usage: ros2 bag [-h] VERB ...\n")
        print("\n".join(f"  {verb:8}{about}" for verb, about in VERBS.items()))
        return
    command, *rest = translated(words)
    arjuna(command, rest)


def doctor(words: list[str]) -> NoReturn:
    """Look for what is wrong."""
    arjuna("doctor", words)
