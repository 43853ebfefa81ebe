"""`ros2 run robot_state_publisher robot_state_publisher`: the node, of a description's text."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path
from typing import NoReturn

from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import RosArguments

_NODE, _GROUP = "robot_state_publisher", "description"
_OURS = frozenset({"publish_frequency"})


def start(given: RosArguments) -> NoReturn:
    """Become the process of that node; a description's text goes by a file."""
    text = given.parameters.pop("robot_description", "")
    path = given.own[0] if given.own else ""
    if not text and not path:
        raise Ros2Error('no robot: -p robot_description:="$(cat FILE)", or a FILE as argument')
    if text:
        with tempfile.NamedTemporaryFile("w", suffix=".urdf", delete=False) as file:
            file.write(text)
        path = file.name
    values: dict[str, object] = {"robot": str(Path(path).resolve())}
    values["use_sim_time"] = given.parameters.pop("use_sim_time", "false").lower() == "true"
    values |= {name: float(given.parameters.pop(name)) for name in _OURS & given.parameters.keys()}
    unused = [*given.own[1:], *given.unused, *given.parameters, *given.remapped, *given.files]
    if unused:
        print(f"no effect: {' '.join(unused)}", flush=True)
    words = [_GROUP, "--alone", "--parameters", json.dumps({_NODE: values})]
    os.execv(sys.executable, [sys.executable, "-m", "bringup.host", *words])  # noqa: S606 - ours
