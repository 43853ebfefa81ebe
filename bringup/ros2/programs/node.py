"""`ros2 run PACKAGE EXECUTABLE` of a node that stands alone, with its usual arguments."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from arjuna_core.errors import ConfigError
from arjuna_core.files.yaml_file import plain
from bringup.parameters.checking import checked, write_remarks
from bringup.parameters.files import EVERY_NODE, SIM_TIME, Parameters, Source, node_of, of_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import RosArguments
from bringup.stack import (
    LIFECYCLE_MANAGER,
    NAV2_PROGRAMS,
    PROGRAMS,
    ROBOT_STATE_PUBLISHER,
    program_nodes,
)

_DESCRIPTION = "robot_description"
_ALONE = {
    "controller_server": {"cmd_vel_topic": "cmd_vel"},
    "behavior_server": {"cmd_vel_topic": "cmd_vel"},
    "velocity_smoother": {"cmd_vel_in_topic": "cmd_vel"},
}
"""The topics of Nav2's nodes before a launch file renames them; our stacks have them renamed."""


def start(package: str, program: str, given: RosArguments) -> NoReturn:
    """Become the process of the node.

    Raises:
        ConfigError: Its parameters are not valid.
    """
    usual = {**PROGRAMS, **NAV2_PROGRAMS}[package, program]
    name = given.remapped.pop("__node", given.remapped.pop("__name", usual.name))
    if usual == LIFECYCLE_MANAGER and not name.startswith("lifecycle_manager_"):
        name = usual.name
    namespace = given.remapped.pop("__ns", "").strip("/")
    spec = replace(usual, name=name)
    values = _values(given, name)
    for problem in _of_others(given, name, usual.name):
        print(problem, file=sys.stderr, flush=True)
    if usual == ROBOT_STATE_PUBLISHER:
        if given.own:
            values["robot"] = str(Path(given.own.pop(0)).resolve())
        if not {"robot", _DESCRIPTION} & values.keys():
            raise Ros2Error('no robot: -p robot_description:="$(cat FILE)", or a FILE as argument')
    sim_time = values.pop(SIM_TIME, False)
    parameters: Parameters = {}
    for one in (spec, *program_nodes(usual)[:-1]):
        own = values if one == spec else _values(given, one.name)
        own = {**(_ALONE.get(usual.name, {}) if one == spec else {}), **own}
        own.pop(SIM_TIME, None)
        source = Source(f"ros2 run {package} {program}", {one.name: own})
        read = checked(source, {}, namespace, only=one)
        if read.problems:
            raise ConfigError(*read.problems)
        write_remarks(read.remarks)
        parameters[one.name] = {**read.parameters.get(one.name, {}), SIM_TIME: sim_time}
    if unused := [*given.own, *given.unused]:
        print(f"no effect: {' '.join(unused)}", flush=True)
    words = [f"{package}/{program}", "--alone", "--parameters", _as_word(json.dumps(parameters))]
    words += ["--namespace", namespace] if namespace else []
    renamed = [word for item in given.remapped.items() for word in ("-r", ":=".join(item))]
    level = ["--log-level", given.level] if given.level else []
    words += ["--ros-args", *renamed, *level]
    os.execv(sys.executable, [sys.executable, "-m", "bringup.host", *words])  # noqa: S606 - ours


def _as_word(text: str) -> str:
    """Return a text as an argument of what this process becomes: a file in memory, of any length.

    So `ps` and `top` show a line of the node, not its parameters.
    """
    file = os.memfd_create("parameters", 0)  # without a flag it stays open
    os.write(file, text.encode())
    return f"@/proc/self/fd/{file}"


def _values(given: RosArguments, name: str) -> dict[str, Any]:
    """Return the node's values: those of `/**` in files, its own there, then `-p`."""
    values: dict[str, Any] = {}
    for path in given.files:
        sections = of_file(Path(path)).values
        values |= sections.get(EVERY_NODE, {})
        for section, own in sections.items():
            values |= own if node_of(section, [name]) == name else {}
    read = {k: t if k == _DESCRIPTION else plain(t) for k, t in given.parameters.items()}
    return {**values, **read}


def _of_others(given: RosArguments, name: str, usual: str) -> Iterator[str]:
    """Yield which files hold the parameters of such a node, but under another name.

    Files of several nodes need not name each: of those only the usual name is looked for.
    """
    for path in given.files:
        sections = of_file(Path(path)).values
        named = [each for each in sections if each != EVERY_NODE]
        if EVERY_NODE in sections or any(node_of(each, [name]) == name for each in named):
            continue
        theirs = [each for each in named if len(named) == 1 or node_of(each, [usual]) == usual]
        if theirs:
            other = f"its section is '{theirs[0]}'; give both one name"
            yield f"{path}: nothing of it is taken, for this node is '{name}' and {other}"
