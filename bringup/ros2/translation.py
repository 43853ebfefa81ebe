"""Launch files of other packages with arguments, as commands of ours."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from pathlib import Path

from arjuna_core.errors import nearest
from bringup.parameters.files import load_parameters
from bringup.ros2.launches import Launch
from bringup.stack import nodes_beside_navigation

_STARTS = "nodes start at once"
_IDLE = {
    "autostart": ("true", _STARTS),
    "use_lifecycle_manager": ("", _STARTS),
    "use_composition": ("", "each group of nodes is one process"),
    "container_name": ("", "there are no containers"),
    "use_respawn": ("true", "what dies is started again"),
    "log_settings": ("", "log_level:=LEVEL counts"),
    "gui": ("false", "the simulator has no window; 'arjuna view' shows it"),
    "pause": ("false", "'arjuna world pause' pauses it"),
}
"""Arguments without an effect: the value that says what happens anyhow (none: no matter), why."""
_STACK_COMMANDS = ("nav", "robot", "slam")
_ZONES = {
    f"{kind}_{name}"
    for kind in ("keepout", "speed")
    for name in ("filter_mask_server", "costmap_filter_info_server")
}
"""The nodes of filters that Nav2's launch files start; others have launch files of their own."""


def arguments_of(launch: Launch) -> str:
    """Return the arguments of a launch file, those without an effect apart."""
    known = sorted(known_arguments(launch) - set(launch.idle))
    lines = [f"Arguments (NAME:=VALUE): {', '.join(known)}"]
    return "\n".join([*lines, f"Without an effect here: {', '.join(sorted(launch.idle))}"])


def translated(launch: Launch, words: list[str]) -> tuple[list[str], list[str]]:
    """Return our command for a launch file with arguments, and remarks on those without effect."""
    known, remarks = known_arguments(launch), []
    given: dict[str, str] = {}
    for word in words:
        name, sign, value = word.partition(":=")
        if sign and name in known:
            given[name] = value
        else:
            what = "argument" if sign else "option"
            remarks.append(f"no effect: {word} (unknown {what}; {nearest(name, known)})")
    for name in (name for name in launch.idle if name in given):
        anyhow, reason = _IDLE[name]
        if given[name].lower() != anyhow:
            remarks.append(f"no effect: {name}:={given[name]} ({reason})")
    if given.get("use_namespace", "true").lower() == "false" and given.pop("namespace", ""):
        remarks.append("no effect: namespace (use_namespace is false)")
    if "x_pose" in launch.options and {"x_pose", "y_pose"} & given.keys():
        given["at"] = " ".join(given.pop(name, "0") for name in ("x_pose", "y_pose"))
    return _command(launch, given), remarks


def known_arguments(launch: Launch) -> set[str]:
    """Return the arguments that a launch file has."""
    return {*launch.options, *launch.idle, *launch.instead, "use_namespace", "use_sim_time"}


def _command(launch: Launch, given: dict[str, str]) -> list[str]:
    first, *rest = launch.words
    clock = given.get("use_sim_time", "true").lower()
    if first == "slam" and clock == "false":
        rest += ["--use-sim-time", "false"]
    elif "use_sim_time" in given and clock == "true" and any("params_file" in key for key in given):
        rest += ["--use-sim-time", "true"]  # whatever the file says
    first = "robot" if first == "nav" and clock == "false" else first
    if "map" in launch.options and first in _STACK_COMMANDS:
        rest += _located(given)
    if first in _STACK_COMMANDS and Path(given.get("params_file", "")).is_file():
        beside = nodes_beside_navigation(load_parameters([Path(given["params_file"])]))
        others = (spec.name for spec in beside if spec.name not in _ZONES)
        rest += [word for name in others for word in ("--leave-out", name)]
    if "at" in given:
        rest[-3:] = ["--at", *shlex.split(given["at"])]
    for name, option in launch.options.items():
        if value := given.get(name, ""):
            words = option.replace("/{}", f"/{value.lstrip('/')}").split()
            inside = [word.replace("{}", value) for word in words]
            rest += inside if "{}" in option else [option, value] if option else shlex.split(value)
    return [first, *rest]


def renamed(command: str, rules: Iterable[tuple[str, str]]) -> list[str]:
    """Return the options of a stack's command for what a launch file remaps in all its nodes.

    A remapped `cmd_vel` is that of the wheels: of Nav2's own files the whole chain that ends in it
    would have one name, and answer itself.
    """
    words: list[str] = []
    for old, new in rules if command in _STACK_COMMANDS else ():
        wheels = old.lstrip("/") == "cmd_vel"
        words += ["--cmd-vel-topic", new] if wheels else ["--remap", f"{old}:={new}"]
    return words


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
