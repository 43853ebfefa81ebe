"""`ros2 run robot_localization ekf_node`, and its others: the node with its usual arguments."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any, NoReturn

from arjuna_core.errors import ConfigError
from arjuna_core.files.yaml_file import plain
from bringup.parameters.checking import checked, write_remarks
from bringup.parameters.files import EVERY_NODE, SIM_TIME, Parameters, Source, node_of, of_file
from bringup.ros2.verbs.forward import RosArguments
from bringup.stack import FUSION_GROUP, UNSCENTED

NAMES = {
    "ekf_node": "ekf_filter_node",
    "ukf_node": "ukf_filter_node",
    "navsat_transform_node": "navsat_transform_node",
}
"""The node's name by that of its program, where no other is given."""


def start(program: str, given: RosArguments) -> NoReturn:
    """Become the process of the node.

    Raises:
        ConfigError: Its parameters are not valid.
    """
    name = given.remapped.pop("__node", given.remapped.pop("__name", NAMES[program]))
    namespace = given.remapped.pop("__ns", "").strip("/")
    values = _values(given, name)
    sim_time = values.pop(SIM_TIME, False)
    if program == "ukf_node":
        values = {**UNSCENTED, **values}
    read = checked(Source(f"ros2 run robot_localization {program}", {name: values}), {}, namespace)
    if read.problems:
        raise ConfigError(*read.problems)
    write_remarks(read.remarks)
    if unused := [*given.own, *given.unused]:
        print(f"no effect: {' '.join(unused)}", flush=True)
    parameters: Parameters = {name: {**read.parameters.get(name, {}), SIM_TIME: sim_time}}
    words = [FUSION_GROUP.name, "--alone", "--parameters", json.dumps(parameters)]
    words += ["--namespace", namespace] if namespace else []
    renamed = [word for item in given.remapped.items() for word in ("-r", ":=".join(item))]
    level = ["--log-level", given.level] if given.level else []
    words += ["--ros-args", *renamed, *level]
    os.execv(sys.executable, [sys.executable, "-m", "bringup.host", *words])  # noqa: S606 - ours


def _values(given: RosArguments, name: str) -> dict[str, Any]:
    """Return the node's values: those of `/**` in files, its own there, then `-p`."""
    values: dict[str, Any] = {}
    for path in given.files:
        sections = of_file(Path(path)).values
        values |= sections.get(EVERY_NODE, {})
        for section, own in sections.items():
            values |= own if node_of(section, [name]) == name else {}
    return {**values, **{key: plain(text) for key, text in given.parameters.items()}}
