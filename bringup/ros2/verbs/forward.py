"""The programs of `ros2 run` and what they take of its words; `ros2 test`."""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NoReturn

from arjuna_core.files.shipped import environment_folders
from bringup.parameters.files import load_parameters
from bringup.ros2.verbs.remedies import remedy_of
from bringup.stack import NAV2_PROGRAMS
from bringup.stack import PROGRAMS as ROBOT_PROGRAMS

NODES = {**ROBOT_PROGRAMS, **NAV2_PROGRAMS}
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

    @property
    def values(self) -> dict[str, str]:
        """The parameters of its files, whatever node they are of, and those given by name."""
        files = load_parameters(self.files).values()
        return {k: str(v) for file in files for k, v in file.items()} | self.parameters


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
        options += [f"--{name}", given.values.get(name, usual)]
    if given.values.get("stamped", "").lower() == "true":
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
    options = [chosen.pop("name"), "--timeout", given.values.get("save_map_timeout", "10.0")]
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
        elif name != "__node":
            options += ["--remap", f"{name}:={value}"]
        elif value != "slam_toolbox":
            unused.append(f"{name}:={value}")
    for item in [*set_here, *filter(None, [parameter])]:
        options += ["--param", item]
    options += ["--log-level", given.level] if given.level else []
    if unused:
        print(f"no effect: {' '.join(unused)}", flush=True)
    arjuna("slam", options)


def _foxglove(words: list[str]) -> NoReturn:
    given = ros_arguments(words).values
    options = ["--foxglove"]
    for name, option in (("port", "--port"), ("address", "--host")):
        if value := given.get(name):
            options += [option, value]
    arjuna("view", options)


def _xacro(words: list[str]) -> NoReturn:
    program = [sys.executable, "-c", "import xacro; xacro.main()", *ros_arguments(words).own]
    os.execv(sys.executable, program)  # noqa: S606 - what the user asked for


def _run_node(words: list[str], package: str, program: str) -> None:
    module = importlib.import_module(f"{_PROGRAMS}.node")
    module.start(package, program, ros_arguments(words))


def _joint_state_publisher_gui(words: list[str]) -> None:
    """Run the publisher with the view's sliders as a source."""
    words = [*words, "--ros-args", "-p", "sliders:=true"]
    _run_node(words, "joint_state_publisher", "joint_state_publisher")


def nothing(words: list[str], why: str) -> None:
    """Say why a program has nothing to do, and stay as the other would.

    Launch files end all where a window or a container does.
    """
    print(f"nothing to do: {why}", flush=True)
    signal.pause()


_IMAGES = partial(nothing, why="the simulator publishes ROS's topics itself")
_BRIDGE = f"{_PROGRAMS}.bridge"
_GAZEBO = f"{_PROGRAMS}.gazebo"
_MOCK = f"{_PROGRAMS}.mock_hardware"
_RELAYS = f"{_PROGRAMS}.relays"
_ROSBRIDGE = "bringup.ros2.rosbridge.bridge"
_TURTLESIM = "bringup.ros2.turtlesim"
TAKES_ALL = (_GAZEBO, _BRIDGE, _MOCK, _RELAYS, _ROSBRIDGE)
"""Programs that read ROS' own words themselves; of others rclpy does."""


# What `ros2 run PACKAGE EXECUTABLE` runs
PROGRAMS: dict[tuple[str, str], str | Callable[[list[str]], None]] = {
    ("controller_manager", "ros2_control_node"): _MOCK,
    **{
        ("rclcpp_components", f"component_container{kind}"): partial(
            nothing, why="each node of a container is a process here"
        )
        for kind in ("", "_isolated", "_mt")
    },
    ("controller_manager", "spawner"): f"{_PROGRAMS}.spawner",
    ("controller_manager", "spawner.py"): f"{_PROGRAMS}.spawner",  # its name before Humble
    ("controller_manager", "unspawner"): f"{_PROGRAMS}.spawner:unspawn",
    ("foxglove_bridge", "foxglove_bridge"): _foxglove,
    ("rosapi", "rosapi_node"): partial(nothing, why="rosbridge_websocket answers for rosapi"),
    ("rosbridge_server", "rosbridge_websocket"): _ROSBRIDGE,
    ("rosbridge_server", "rosbridge_websocket.py"): _ROSBRIDGE,  # its name before Humble
    ("nav2_map_server", "map_saver_cli"): _save_map,
    ("nav2_util", "lifecycle_bringup"): f"{_PROGRAMS}.lifecycle_bringup",
    **{
        ("slam_toolbox", f"{name}_slam_toolbox_node"): partial(_slam_toolbox, parameter=parameter)
        for name, parameter in (
            *(("async", ""), ("map_and_localization", ""), ("lifelong", "mode:=lifelong")),
            *(("localization", "mode:=localization"), ("sync", "synchronous:=true")),
        )
    },
    ("teleop_twist_keyboard", "teleop_twist_keyboard"): _teleop,
    ("turtlebot3_teleop", "teleop_keyboard"): _teleop,
    **{names: partial(_run_node, package=names[0], program=names[1]) for names in NODES},
    ("gazebo_ros", "gzclient"): partial(nothing, why="'arjuna view' shows it"),
    ("gazebo_ros", "gzserver"): f"{_GAZEBO}:serve",
    ("gazebo_ros", "spawn_entity.py"): f"{_GAZEBO}:create",
    ("gazebo_ros", "spawn_model"): f"{_GAZEBO}:create",
    **{  # by today's names, and Humble's
        (package, name): program
        for today, before, name, program in (
            ("ros_gz_bridge", "ros_ign_bridge", "parameter_bridge", _BRIDGE),
            ("ros_gz_image", "ros_ign_image", "image_bridge", _IMAGES),
            ("ros_gz_sim", "ros_ign_gazebo", "create", f"{_GAZEBO}:create"),
            ("ros_gz_sim", "ros_ign_gazebo", "gzserver", f"{_GAZEBO}:serve"),
        )
        for package in (today, before)
    },
    ("joint_state_publisher_gui", "joint_state_publisher_gui"): _joint_state_publisher_gui,
    ("rviz2", "rviz2"): f"{_PROGRAMS}.rviz2",
    ("tf2_ros", "static_transform_publisher"): f"{_PROGRAMS}.static_transform_publisher",
    **{
        ("tf2_ros", name): f"{_PROGRAMS}.{name}"
        for name in ("buffer_server", "tf2_echo", "tf2_monitor")
    },
    ("tf2_tools", "view_frames"): f"{_PROGRAMS}.view_frames",
    **{("topic_tools", name): f"{_RELAYS}:{name}" for name in ("drop", "relay", "throttle")},
    **{
        (f"demo_nodes_{kind}", name): f"{_PROGRAMS}.demo:{name.removesuffix('er')}"
        for kind in ("cpp", "py")
        for name in ("talker", "listener")
    },
    ("image_transport", "republish"): f"{_RELAYS}:republish",
    ("turtlesim", "mimic"): f"{_TURTLESIM}.node:mimic",
    ("turtlesim", "turtle_teleop_key"): f"{_TURTLESIM}.teleop",
    ("turtlesim", "turtlesim_node"): f"{_TURTLESIM}.node",
    ("twist_stamper", "twist_stamper"): f"{_RELAYS}:stamp",
    ("twist_stamper", "twist_unstamper"): f"{_RELAYS}:unstamp",
    ("xacro", "xacro"): _xacro,
}


LAUNCHED = "ARJUNA_LAUNCHED"
"""Set in the environment of what a launch file starts, to the programs that it started before."""
GENERATED = "share/arjuna/generated"
"""Marks the prefix of the packages that are made here."""


def arjuna(command: str, words: list[str]) -> NoReturn:
    """Become `arjuna COMMAND`, which stands above this wing."""
    program = [sys.executable, "-m", module_of(command), command, *words]
    os.execv(sys.executable, program)  # noqa: S606 - our own module


def module_of(command: str) -> str:
    """Return the module that runs a command: `run` is `ros2`'s, all others are `arjuna`'s."""
    return "bringup.ros2.main" if command == "run" else "bringup"


def executables_of(package: str) -> dict[str, Path]:
    """Return the executables of a package of one's own: those of sourced workspaces."""
    found: dict[str, Path] = {}
    for prefix in environment_folders("AMENT_PREFIX_PATH"):
        if prefix == Path(sys.prefix) or (prefix / GENERATED).exists():
            continue
        for path in sorted((prefix / "lib" / package).glob("*")):
            if path.is_file() and os.access(path, os.X_OK):
                found.setdefault(path.name, path)
    return found


def remedy(package: str) -> str:
    """Return what to do where a package, or something of it, is not there."""
    return remedy_of(package, sorted(name for known, name in PROGRAMS if known == package))


def launch_test(words: list[str]) -> NoReturn:
    """Run `launch_test`, as `ros2 test` does."""
    program = [sys.executable, "-m", "launch_testing.launch_test", *words]
    os.execv(sys.executable, program)  # noqa: S606 - what the user asked for
