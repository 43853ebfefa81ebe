"""The options that several commands share, as data, and the types of their values."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from arjuna_core.files.shipped import found_or_shipped

DOMAINS = 101  # ports of those above are given to any program (OMG DDSI-RTPS 2.5, 9.6.2; Linux)
_DOMAIN_MAX = 232  # ports above do not exist (OMG DDSI-RTPS 2.5, 9.6.2.3)
_NAMESPACE = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*/?", re.ASCII)
_ARGUMENT = re.compile(r"[A-Za-z_]\w*:=")
_RULE = re.compile(r"(\w+:)?(ros(topic|service)://)?[\w/~]+:=[\w/~]+$")
_SEARCHED = {
    "package_path": "ROS_PACKAGE_PATH",
    "model_path": "GAZEBO_MODEL_PATH",
    "plugin_path": "PYTHONPATH",
}
"""The environment's variable of folders for each option with folders."""


class Each(argparse.Action):
    """Keeps all values of an option: the last one by its name, all of them by its plural."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Take a value."""
        plural = f"{self.dest}s"
        setattr(namespace, self.dest, values)
        setattr(namespace, plural, [*(getattr(namespace, plural, None) or []), values])


def _number(valid: Callable[[float], bool], problem: str) -> Callable[[str], float]:
    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or not valid(value):
            raise argparse.ArgumentTypeError(f"{text!r} {problem}")
        return value

    return number


finite = _number(lambda value: True, "is no finite number")
factor = _number(lambda value: value >= 0.0, "is no factor; valid: a number from 0")
"""A factor of time, 0 for as fast as it goes, or a time [s]."""
positive = _number(lambda value: value > 0.0, "is no number above 0")


def _whole(text: str, most: int, problem: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > most:
        raise argparse.ArgumentTypeError(f"{text!r} {problem}")
    return int(text)


def seed(text: str) -> int:
    """Return a seed."""
    return _whole(text, 2**63 - 1, "is no seed; valid: a whole number from 0")


def domain_id(text: str) -> int:
    """Return a number of a ROS domain."""
    return _whole(text, _DOMAIN_MAX, f"is no domain; valid: 0 to {_DOMAIN_MAX}")


def namespace(text: str) -> str:
    """Return a namespace without the outer slashes."""
    if text and not _NAMESPACE.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no namespace; valid: words of a-z, 0-9, _")
    return text.strip("/")


def _truth(text: str) -> bool:
    if text.lower() not in ("true", "false"):
        raise argparse.ArgumentTypeError(f"{text!r} is no truth value; valid: true, false")
    return text.lower() == "true"


def _folder(text: str) -> Path:
    if not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is no folder")
    return Path(text)


def _importable(text: str) -> Path:
    """Return the folder in which Python finds a module: that itself, or a package's or file's."""
    path = Path(text)
    if (path.suffix == ".py" and path.is_file()) or (path / "__init__.py").is_file():
        return path.resolve().parent
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is no folder, package or .py file")
    return path


def _input(text: str) -> Path:
    """Return the path of a file to read; maps/, urdf/ and others are the shipped ones elsewhere."""
    return Path(found_or_shipped(text))


def _argument(text: str) -> str:
    if not _ARGUMENT.match(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no argument; valid: NAME:=VALUE")
    return text


def _rule(text: str) -> str:
    if not _RULE.match(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no remapping; valid: OLD:=NEW")
    return text


NODES = (
    *("--params", "--param", "--strict", "--as-nav2", "--as-slam-toolbox", "--log-level"),
    "--plugin-path",
)
"""The options of every command that runs nodes."""
ROBOT_CHOICE = ("--namespace", "--domain-id")
"""Which robot is meant, where there may be several."""
ROBOT = ("--robot", "--package-path", "robot_arguments")
"""Which robot it is."""
SIMULATION = (*ROBOT, "--world", "--model-path")
"""Which robot is simulated, and where."""
SUPERVISED = (*ROBOT_CHOICE, "--json")
"""The options of a command that runs supervised processes."""
BUILDINGS = ("furnished", "house", "shop", "hall")
"""The buildings that are made up by a seed, in the order of their `LAYOUTS`."""
ABOUT_BUILDINGS = (
    "made up by the seed: a room, much of it below and above the lidar's plane; a house; a shop; "
    "an open hall"
)
MESHES = "folder of ROS packages for the robot's meshes; may be given again"


def _path(about: str, metavar: str = "FILE", **more: Any) -> dict[str, Any]:
    return {"type": Path, "metavar": metavar, "help": about, **more}


def _paths(about: str, **more: Any) -> dict[str, Any]:
    """Return an option that may be given again; folders must exist."""
    return {"action": "append", "default": [], "help": f"{about}; may be given again", **more}


def _flag(about: str) -> dict[str, Any]:
    return {"action": "store_true", "help": about}


def _value(kind: Callable[[str], Any], metavar: str, about: str, **more: Any) -> dict[str, Any]:
    return {"type": kind, "metavar": metavar, "help": about, **more}


_OPTIONS: dict[str, dict[str, Any]] = {
    "--params": {
        **_path("a ROS parameter file; may be given again, later files win", type=_input),
        "action": "append",
        "default": [],
    },
    "--param": _paths(
        "a parameter, over those of files; NODE:NAME:=VALUE for one node", metavar="NAME:=VALUE"
    ),
    "--strict": _flag("refuse files with names that no node has"),
    "--as-nav2": _flag("do as Nav2 does where that is another thing; files and --param still win"),
    "--as-slam-toolbox": _flag("map as slam_toolbox does; files and --param still win"),
    "--log-level": {
        "choices": ("debug", "info", "warn", "error", "fatal"),
        "default": "info",
        "help": "what to log at least (info)",
    },
    "--map": _path("the map's YAML file", type=_input),
    "--slam": _flag("map while navigating"),
    "--without-localization": _flag("navigation alone: others localize"),
    "--without-navigation": _flag("localization or mapping alone"),
    "--use-sim-time": _value(
        _truth, "true|false", "whether time is a simulator's (as the files say; true)"
    ),
    "--record": _path(
        "record all topics meanwhile; the folder must not exist (rosbag2_ and the time)",
        "FOLDER",
        nargs="?",
        const=Path(),
    ),
    "--namespace": _value(
        namespace,
        "NAME",
        "the robot's: its nodes and topics, /tf and /clock too, are below /NAME",
        default="",
    ),
    "--domain-id": _value(domain_id, "N", "of ROS, 0 to 232 ($ROS_DOMAIN_ID)"),
    "--json": _flag("print states and log as JSON, an object a line"),
    "--resume": _flag(
        "go on with map and goal under way after a process died, with the goal also after "
        "time was set back"
    ),
    "--maps-folder": _path(
        "folder of relative paths that clients save and load maps by (the working folder)", "DIR"
    ),
    "--leave-out": _paths(
        "a node that only its section of a file starts, where another runs it", metavar="NODE"
    ),
    "--seed": _value(seed, "N", "seed of every random choice, 0 or more (0)"),
    "--scan-topic": _value(str, "TOPIC", "of the lidar (scan), or of several"),
    "--cloud-topic": _value(str, "TOPIC", "of points (depth/points), or of several"),
    "--odom-topic": _value(str, "TOPIC", "of the odometry (odom)"),
    "--cmd-vel-topic": _value(str, "TOPIC", "it is driven by (cmd_vel)"),
    "--remap": _paths(
        "a topic's or service's name, and that in its place; NODE:OLD:=NEW in that node alone",
        metavar="OLD:=NEW",
        type=_rule,
    ),
    "--base-frame": _value(str, "FRAME", "of the robot (base_footprint)"),
    "--odom-frame": _value(str, "FRAME", "of its odometry (odom)"),
    "--robot": _path(
        "its URDF, xacro or SDF; WORLD.sdf#NAME is a model of a world (the robot that the world"
        " holds, else urdf/arjuna.urdf)",
        type=_input,
    ),
    "--package-path": _paths(
        "folder of ROS packages for package:// and $(find ...)", type=_folder, metavar="DIR"
    ),
    "--plugin-path": _paths(
        "where plug-ins of your own are, module:Class: their folder, package or .py file",
        type=_importable,
        metavar="PATH",
    ),
    "robot_arguments": _value(
        _argument, "NAME:=VALUE", "arguments of the robot's xacro file", nargs="*", default=[]
    ),
    "--world": _path(
        "an SDF world, or a map's YAML whose walls are built (worlds/arjuna_room.world)",
        type=_input,
    ),
    "--model-path": _paths("folder of Gazebo models for model://", type=_folder, metavar="DIR"),
    "--at": {
        "nargs": 2,
        "type": finite,
        "metavar": ("X", "Y"),
        "help": "where the robot starts, or the nearest free place [m] (0 0)",
    },
    "--heading": _value(finite, "RAD", "its heading there (0)", dest="yaw"),
    "--check": _path(
        "say what is understood of a robot, world or map, and what is not, and end; without FILE"
        " of --robot and --world",
        type=_input,
        nargs="?",
        const=(),
    ),
    "--save-guess": _path(
        "with --check: write the drive that was guessed; FILE then loads as the robot"
    ),
    "--offline": _path(
        "a CARMEN log (.clf, .log, also .xz, .gz, .bz2), a recording (.mcap, .db3, .bag) or a "
        "rosbag2 folder",
        "INPUT",
    ),
    "--out": _path("", "FOLDER"),
    "--jobs": _value(int, "N", "runs at a time (cores)", default=os.cpu_count() or 1),
    "--cluster": _value(
        str,
        "ADDRESS",
        "run on a Ray cluster, HOST:PORT; auto: the one of $RAY_ADDRESS, else one of this machine",
    ),
    "x": _value(finite, "X", "of the map [m]"),
    "y": _value(finite, "Y", "of the map [m]"),
    "yaw": _value(finite, "HEADING", "heading [rad] (0)", nargs="?", default=0.0),
    "--tolerance": _value(
        positive,
        "M",
        "how far from it the robot may stand in the end [m] (%(default)g)",
        default=0.3,
    ),
    "--timeout": {"type": positive, "default": 600.0, "help": "give up after [s] (%(default)g)"},
    "--speed": {"type": positive, "default": 0.3, "help": "forward [m/s] (%(default)s)"},
    "--turn": {"type": positive, "default": 0.5, "help": "turning [rad/s] (%(default)s)"},
    "--duration": _value(positive, "S", "how long to listen [s]"),
}


def add(parser: argparse._ActionsContainer, *names: str, **changes: Any) -> None:
    """Add options and arguments that several commands share."""
    for name in names:
        also = ("--yaw",) if name == "--heading" else ()  # ROS's word
        parser.add_argument(name, *also, **{**_OPTIONS[name], **changes})


def add_running(parser: argparse.ArgumentParser) -> None:
    """Add the options of a command that runs supervised nodes beside a simulator or a robot."""
    add(parser, *NODES)
    about = "its URDF, xacro or SDF (whose topics, frames and outline it has: the shipped one's)"
    add(parser, "--robot", help=about)
    add(parser, "--package-path", "robot_arguments")
    add_robot_names(parser)
    add(parser, "--record", *SUPERVISED, "--resume", "--maps-folder", "--use-sim-time")


def add_parts(parser: argparse.ArgumentParser) -> None:
    """Add where the robot's pose comes from, and which half of the stack is left out."""
    where = parser.add_mutually_exclusive_group(required=True)
    add(where, "--map", "--slam", "--without-localization")
    add(parser, "--without-navigation", "--leave-out")


def add_log_options(
    parser: argparse.ArgumentParser, out: str, what: str
) -> argparse._ArgumentGroup:
    """Add the options of a command that can run on a log instead of a robot."""
    group = parser.add_argument_group("on a log")
    add(group, "--offline")
    add(group, "--out", default=Path(out), help=f"{what} (%(default)s)")
    return group


def add_robot_names(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add the robot's names of topics and frames; each reaches every node that needs it."""
    group = parser.add_argument_group("what the robot, or a recording, calls its own")
    add(group, "--scan-topic", "--cloud-topic", "--odom-topic", "--cmd-vel-topic")
    add(group, "--base-frame", "--odom-frame", "--remap")
    return group


def extend_search(arguments: argparse.Namespace) -> None:
    """Put the folders given in front of those of the environment, for this process and others."""
    for option, name in _SEARCHED.items():
        given = [str(folder.resolve()) for folder in vars(arguments).get(option) or []]
        known = [os.environ[name]] if os.environ.get(name) else []
        if given:
            os.environ[name] = os.pathsep.join(given + known)
            sys.path[:0] = given if name == "PYTHONPATH" else []
