"""`ros2 launch`: the launch files of Nav2 and slam_toolbox, as what starts the same here."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from arjuna_core.errors import nearest
from bringup.parameters.files import load_parameters
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import arjuna

_STARTS = "nodes start at once"
_IDLE = {
    "autostart": ("true", _STARTS),
    "use_lifecycle_manager": ("", _STARTS),
    "use_composition": ("", "each group of nodes is one process"),
    "container_name": ("", "there are no containers"),
    "use_respawn": ("true", "what dies is started again"),
    "log_settings": ("", "log_level:=LEVEL counts"),
}
"""Arguments without an effect: the value that says what happens anyhow (none: no matter), why."""
_NAV2 = {"params_file": "--params", "namespace": "--namespace", "log_level": "--log-level"}
_MAP = {"map": "--map", **_NAV2}
_SLAM = {"slam_params_file": "--params", **_NAV2}
_NAV2_ONLY = ("autostart", "use_composition", "container_name", "use_respawn")


@dataclass(frozen=True)
class Launch:
    """The command of ours that starts the same as a launch file.

    Attributes:
        options: The command's option for an argument of the file.
        idle: Its arguments that have no effect here.
        instead: Its arguments that say what locates the robot in place of a map.
    """

    words: tuple[str, ...]
    options: Mapping[str, str]
    idle: tuple[str, ...] = _NAV2_ONLY
    instead: tuple[str, ...] = ()


def _mapper(*parameters: str) -> Launch:
    words = (word for parameter in parameters for word in ("--param", parameter))
    return Launch(("slam", *words), _SLAM, ("autostart", "use_lifecycle_manager"))


LAUNCHES: dict[tuple[str, str], Launch] = {
    ("nav2_bringup", "bringup_launch.py"): Launch(
        ("nav",), _MAP, instead=("slam", "use_localization")
    ),
    ("nav2_bringup", "localization_launch.py"): Launch(("nav", "--without-navigation"), _MAP),
    ("nav2_bringup", "navigation_launch.py"): Launch(("nav", "--without-localization"), _NAV2),
    ("nav2_bringup", "rviz_launch.py"): Launch(
        ("view",), {"namespace": "--namespace", "rviz_config": "--config"}, ()
    ),
    ("nav2_bringup", "slam_launch.py"): Launch(
        ("slam", "--param", "synchronous:=true"), _NAV2, _NAV2_ONLY
    ),
    ("slam_toolbox", "online_async_launch.py"): _mapper(),
    ("slam_toolbox", "online_sync_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "offline_launch.py"): _mapper("synchronous:=true"),
    ("slam_toolbox", "localization_launch.py"): _mapper("mode:=localization"),
    ("slam_toolbox", "lifelong_launch.py"): _mapper("mode:=lifelong"),
}


@dataclass
class Translation:
    """A launch file with arguments, as a command of ours, and remarks on those without effect."""

    command: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def run(words: list[str]) -> int:
    """Start what a launch file starts; say which command that is."""
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
    if {"-s", "--show-args", "--show-arguments"} & set(words[2:]):
        print(arguments_of(LAUNCHES[package, file]))
        return 0
    translation = translated(LAUNCHES[package, file], words[2:])
    print("".join(f"{line}\n" for line in translation.remarks), end="")
    print(f"$ python -m bringup {shlex.join(translation.command)}", flush=True)
    return arjuna(translation.command[0], translation.command[1:])


def arguments_of(launch: Launch) -> str:
    """Return the arguments of a launch file, those without an effect apart."""
    known = sorted(_known(launch) - set(launch.idle))
    lines = [f"Arguments (NAME:=VALUE): {', '.join(known)}"]
    return "\n".join([*lines, f"Without an effect here: {', '.join(sorted(launch.idle))}"])


def translated(launch: Launch, words: list[str]) -> Translation:
    """Return our command for a launch file with arguments, and what of them has no effect."""
    found = Translation()
    known = _known(launch)
    given: dict[str, str] = {}
    for word in words:
        name, sign, value = word.partition(":=")
        if sign and name in known:
            given[name] = value
        else:
            what = "argument" if sign else "option"
            found.remarks.append(f"no effect: {word} (unknown {what}; {nearest(name, known)})")
    found.remarks += _idle(launch, given)
    if given.get("use_namespace", "true").lower() == "false" and given.pop("namespace", ""):
        found.remarks.append("no effect: namespace (use_namespace is false)")
    found.command = _command(launch, given)
    return found


def _known(launch: Launch) -> set[str]:
    return {*launch.options, *launch.idle, *launch.instead, "use_namespace", "use_sim_time"}


def _idle(launch: Launch, given: Mapping[str, str]) -> list[str]:
    lines = []
    for name in (name for name in launch.idle if name in given):
        anyhow, reason = _IDLE[name]
        if given[name].lower() != anyhow:
            lines.append(f"no effect: {name}:={given[name]} ({reason})")
    return lines


def _command(launch: Launch, given: dict[str, str]) -> list[str]:
    first, *rest = launch.words
    if given.get("use_sim_time", "true").lower() == "false":
        if first == "slam":
            rest += ["--use-sim-time", "false"]
        first = "robot" if first == "nav" else first
    if "map" in launch.options:
        rest += _located(given)
    for name, option in launch.options.items():
        if given.get(name):
            rest += [option, given[name]]
    return [first, *rest]


def _located(given: dict[str, str]) -> list[str]:
    if given.get("slam", "false").lower() == "true":
        given.pop("map", None)
        return ["--slam"]
    if given.get("use_localization", "true").lower() == "false":
        given.pop("map", None)
        return ["--without-localization"]
    if not given.get("map") and given.get("params_file"):
        nodes = load_parameters([Path(given["params_file"])])
        named = (values.get("yaml_filename") for values in nodes.values())
        given["map"] = next((name for name in named if isinstance(name, str) and name), "")
    return []
