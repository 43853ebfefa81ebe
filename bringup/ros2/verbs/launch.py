"""`ros2 launch`: the launch files of Nav2 and slam_toolbox, as what starts the same here."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

from arjuna_core.errors import nearest
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import arjuna

_NAV2 = {
    "map": "--map",
    "params_file": "--params",
    "namespace": "--namespace",
    "log_level": "--log-level",
}
_SLAM = {"slam_params_file": "--params", **_NAV2}
LAUNCHES: dict[tuple[str, str], tuple[str, Mapping[str, str]]] = {
    ("nav2_bringup", "bringup_launch.py"): ("nav", _NAV2),
    ("nav2_bringup", "rviz_launch.py"): ("view", {"namespace": "--namespace"}),
    ("nav2_bringup", "slam_launch.py"): ("slam", _SLAM),
    ("slam_toolbox", "online_async_launch.py"): ("slam", _SLAM),
    ("slam_toolbox", "online_sync_launch.py"): ("slam", _SLAM),
}
"""Our command for a package's launch file, and its option for an argument."""
_ON_REAL_TIME = {"nav": "robot", "slam": "robot"}


def run(words: list[str]) -> int:
    """Start what a launch file starts; say which command that is.

    Raises:
        Ros2Error: The file is not one of those that are known.
    """
    listed = "\n".join(f"  {package} {file}" for package, file in LAUNCHES)
    if len(words) < 2 or words[0] in ("-h", "--help"):
        print(f"usage: ros2 launch [-h] package_name launch_file [NAME:=VALUE ...]\n\n{listed}")
        return 0 if words[:1] in (["-h"], ["--help"]) else 2
    package, file = words[:2]
    if (package, file) not in LAUNCHES:
        near = nearest(f"{package} {file}", [" ".join(known) for known in LAUNCHES])
        raise Ros2Error(
            f"no launch file '{file}' of '{package}'; {near}\n"
            "What others start has a command here: 'python -m bringup' lists them all"
        )
    command, unused = translated(package, file, words[2:])
    if unused:
        print(f"not used here: {' '.join(unused)}")
    print(f"$ python -m bringup {shlex.join(command)}")
    return arjuna(command[0], command[1:])


def translated(package: str, file: str, words: list[str]) -> tuple[list[str], list[str]]:
    """Return our command for a launch file with arguments, and those that mean nothing to it."""
    command, options = LAUNCHES[package, file]
    given = dict(word.split(":=", maxsplit=1) for word in words if ":=" in word)
    if given.pop("use_sim_time", "true").lower() == "false":
        command = _ON_REAL_TIME.get(command, command)
    ours = []
    if given.pop("slam", "false").lower() == "true" or (command == "robot" and "map" not in given):
        ours.append("--slam")
        given.pop("map", None)
    unused = [word for word in words if ":=" not in word]
    for name, value in given.items():
        if name in options:
            ours += [options[name], value]
        else:
            unused.append(f"{name}:={value}")
    return [command, *ours], unused
