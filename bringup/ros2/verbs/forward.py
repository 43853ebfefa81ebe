"""The commands that hand all their words on: `ros2 run`, `doctor`, `daemon`."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NoReturn

from arjuna_core.errors import nearest
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.python_file import run_file
from bringup.stack import PROGRAMS as NODES

_PROGRAMS = "bringup.ros2.programs"


@dataclass
class RosArguments:
    """A program's own words, and what stands between `--ros-args` and `--`.

    Attributes:
        remapped: The new name of each remapped one, which has no leading slash.
        level: What to log at least, "" if it is not said.
        unused: The other words.
    """

    own: list[str] = field(default_factory=list)
    remapped: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, str] = field(default_factory=dict)
    files: list[str] = field(default_factory=list)
    level: str = ""
    unused: list[str] = field(default_factory=list)


def ros_arguments(words: list[str]) -> RosArguments:
    """Part a program's own words from those between `--ros-args` and `--`."""
    found = RosArguments()
    option, for_ros = "", False
    for word in words:
        if word in ("--ros-args", "--") and (for_ros or word == "--ros-args"):
            for_ros, option = word == "--ros-args", ""
        elif not for_ros:
            found.own.append(word)
        elif word.startswith("-") and ":=" not in word:
            option = word
            if word not in _WITH_VALUE:
                found.unused.append(word)
        else:
            _note(found, option, word)
    return found


_WITH_VALUE = ("-r", "--remap", "-p", "--param", "--params-file", "--log-level")


def _note(found: RosArguments, option: str, word: str) -> None:
    name, sign, value = word.partition(":=")
    if option == "--params-file":
        found.files.append(word)
    elif option == "--log-level":
        found.level = value or word
    elif sign and option in ("-r", "--remap"):
        found.remapped[name.lstrip("/")] = value
    elif sign and option in ("-p", "--param"):
        found.parameters[name.lstrip("/")] = value
    else:
        found.unused.append(word)


def _teleop(words: list[str]) -> NoReturn:
    given = ros_arguments(words)
    options = ["--keys", "twist", "--timeout", "1e9"]  # as theirs, which waits for nobody
    if "cmd_vel" in given.remapped:
        options += ["--topic", given.remapped["cmd_vel"]]
    for name, usual in (("speed", "0.5"), ("turn", "1.0")):  # teleop_twist_keyboard's
        options += [f"--{name}", given.parameters.get(name, usual)]
    if given.parameters.get("stamped", "").lower() == "true":
        options.append("--stamped")
    arjuna("teleop", options)


def _save_map(words: list[str]) -> NoReturn:
    given = ros_arguments(words)
    parser = argparse.ArgumentParser(prog="ros2 run nav2_map_server map_saver_cli")
    name = f"map_{int(time.time())}"
    parser.add_argument("-f", dest="name", default=name, help="path without suffix (map_TIME)")
    parser.add_argument("-t", dest="topic", default=given.remapped.get("map"), help="its topic")
    for name in ("occ", "free", "mode", "fmt"):
        parser.add_argument(f"--{name}", help=f"as 'arjuna save-map --{name}'")
    chosen = vars(parser.parse_args(given.own))
    options = [chosen.pop("name"), "--timeout", given.parameters.get("save_map_timeout", "10.0")]
    for name, value in chosen.items():
        options += [f"--{name}", value] if value is not None else []
    arjuna("save-map", options)


_REMAPPED = {"scan": "--scan-topic", "__ns": "--namespace"}
"""Our option for what slam_toolbox's nodes are remapped by."""


def _slam_toolbox(words: list[str], parameter: str = "") -> NoReturn:
    """Run a node of slam_toolbox; the parameter is what makes it that node."""
    given = ros_arguments(words)
    options: list[str] = []
    for file in given.files:
        options += ["--params", file]
    if "use_sim_time" in given.parameters:
        options += ["--use-sim-time", given.parameters.pop("use_sim_time")]
    set_here = [f"{name}:={value}" for name, value in given.parameters.items()]
    unused = [*given.own, *given.unused]
    for name, value in given.remapped.items():
        if name in _REMAPPED:
            options += [_REMAPPED[name], value]
        elif name == "map":
            set_here.append(f"map_name:={value}")
        else:
            unused.append(f"{name}:={value}")
    for item in [*set_here, *filter(None, [parameter])]:
        options += ["--param", item]
    options += ["--log-level", given.level] if given.level else []
    if unused:
        print(f"no effect: {' '.join(unused)}", flush=True)
    arjuna("slam", options)


def _run_node(words: list[str], package: str, program: str) -> None:
    module = importlib.import_module(f"{_PROGRAMS}.node")
    module.start(package, program, ros_arguments(words))


# What `ros2 run PACKAGE EXECUTABLE` runs
PROGRAMS: dict[tuple[str, str], str | Callable[[list[str]], None]] = {
    ("controller_manager", "spawner"): f"{_PROGRAMS}.spawner",
    ("controller_manager", "unspawner"): f"{_PROGRAMS}.spawner:unspawn",
    ("nav2_map_server", "map_saver_cli"): _save_map,
    ("slam_toolbox", "async_slam_toolbox_node"): _slam_toolbox,
    ("slam_toolbox", "map_and_localization_slam_toolbox_node"): _slam_toolbox,
    ("slam_toolbox", "lifelong_slam_toolbox_node"): partial(
        _slam_toolbox, parameter="mode:=lifelong"
    ),
    ("slam_toolbox", "localization_slam_toolbox_node"): partial(
        _slam_toolbox, parameter="mode:=localization"
    ),
    ("slam_toolbox", "sync_slam_toolbox_node"): partial(
        _slam_toolbox, parameter="synchronous:=true"
    ),
    ("teleop_twist_keyboard", "teleop_twist_keyboard"): _teleop,
    **{names: partial(_run_node, package=names[0], program=names[1]) for names in NODES},
    ("rviz2", "rviz2"): f"{_PROGRAMS}.rviz2",
    ("tf2_ros", "static_transform_publisher"): f"{_PROGRAMS}.static_transform_publisher",
    ("tf2_ros", "tf2_echo"): f"{_PROGRAMS}.tf2_echo",
    ("tf2_tools", "view_frames"): f"{_PROGRAMS}.view_frames",
}


def arjuna(command: str, words: list[str]) -> NoReturn:
    """Become `arjuna COMMAND`, which stands above this wing."""
    program = [sys.executable, "-m", "bringup", command, *words]
    os.execv(sys.executable, program)  # noqa: S606 - our own module


def run(words: list[str]) -> int:
    """Run a program of a package, or a file of Python."""
    if not words or words[0] in ("-h", "--help"):
        print(
            "usage: ros2 run [-h] package_name executable_name ...\n       ros2 run FILE.py ...\n"
        )
        print("\n".join(f"  {package} {name}" for package, name in sorted(PROGRAMS)))
        return 0 if words else 2
    if words[0].endswith(".py"):
        run_file(Path(words[0]), words[1:])
        return 0
    package, name = words[0], "".join(words[1:2])
    if package not in {known for known, _ in PROGRAMS}:
        valid = nearest(package, {known for known, _ in PROGRAMS})
        raise Ros2Error(f"Package '{package}' not found; {valid}; 'ros2 run FILE.py' runs a file")
    if (package, name) not in PROGRAMS:
        valid = nearest(name, {known for other, known in PROGRAMS if other == package})
        raise Ros2Error(f"No executable found; {valid}")
    program = PROGRAMS[package, name]
    if isinstance(program, str):
        module, _, function = program.partition(":")
        main = getattr(importlib.import_module(module), function or "main")
        main(ros_arguments(words[2:]).own)  # rclpy reads the others itself
    else:
        program(words[2:])
    return 0


def daemon(words: list[str]) -> None:
    """Print that there is no daemon, so that scripts that stop or start it continue."""
    if words[:1] == ["status"] or words[:1] == ["stop"]:
        print("The daemon is not running")
    else:
        print("There is no daemon: every command looks at the graph itself")


def doctor(words: list[str]) -> NoReturn:
    """Look for what is wrong."""
    arjuna("doctor", words)
