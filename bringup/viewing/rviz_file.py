"""RViz's configuration files: the fixed frame, and which of our layers show which topics."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.yaml_file import read_yaml

_MOVE_BASE = "/move_base/"  # below which ROS 1 publishes what has no such place here
_KINDS = {
    "RobotModel": "robot",
    "LaserScan": "scan",
    "PoseArray": "particles",
    "ParticleCloud": "particles",
    "PoseWithCovariance": "belief",
    "Polygon": "footprint",
    "TF": "axes",
    "Axes": "axes",
    "Pose": "goal",
    "Image": "camera",
    "Camera": "camera",
}
"""What shows a class of display here: a key of `TOPICS`, or a layer; maps and paths by topic."""
_LAYER_OF = {"belief": "particles", "footprint": "local_costmap", "goal": "goals"}
_LAYER_OF |= {"plan": "global_path", "local_plan": "local_path"}
_OF_OUR_TYPE = (
    *("scan", "map", "global_costmap", "local_costmap", "footprint", "belief", "camera"),
    *("plan", "local_plan"),
)
"""What is shown of a display's own topic; a PoseArray is none of our particles, as ROS 1 has it."""
_FLAT = re.compile(r"^\s*(-\s+)?([\w ()]+?):\s*(.*?)\s*$")


@dataclass(frozen=True)
class RvizFile:
    """The wanted frame, layers and topics.

    Attributes:
        fixed_frame: Empty where it names none.
        topics: Other topics than ours, by the key of what shows them.
        left_out: Names of displays that nothing here shows.
    """

    fixed_frame: str
    layers: frozenset[str]
    topics: Mapping[str, str]
    left_out: tuple[str, ...]


def read_rviz(path: Path) -> RvizFile:
    """Read a configuration of RViz, of ROS 1 or 2; one whose indentation is lost line by line.

    Raises:
        InputFileError: It cannot be read, or is no configuration of RViz.
    """
    try:
        document = read_yaml(path)
    except InputFileError:
        document = _flat(path)
        if document is None:
            raise
    manager = document.get("Visualization Manager") if isinstance(document, dict) else None
    if not isinstance(manager, dict):
        raise InputFileError(path, "has no 'Visualization Manager'; valid: a file that RViz saved")
    shown: set[str] = set()
    topics: dict[str, str] = {}
    left_out = []
    for display in _displays(manager):
        kind = str(display.get("Class", "")).rpartition("/")[2]
        topic = _topic(display)
        key = _key(kind, topic)
        if key is None:
            left_out += [] if kind == "Grid" else [str(display.get("Name", kind))]
            continue
        shown.add(_LAYER_OF.get(key, key))
        if key in _OF_OUR_TYPE and topic and not topic.startswith(_MOVE_BASE):
            topics.setdefault(key, topic.lstrip("/"))
    frame = (manager.get("Global Options") or {}).get("Fixed Frame", "")
    return RvizFile(str(frame).lstrip("/"), frozenset(shown), topics, tuple(left_out))


def _displays(parent: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    for display in parent.get("Displays") or ():
        if isinstance(display, Mapping) and display.get("Enabled", True):
            if "Displays" in display:
                yield from _displays(display)
            else:
                yield display


def _topic(display: Mapping[str, Any]) -> str:
    """Return a display's topic: a name in ROS 1, a mapping with its value in ROS 2."""
    topic = display.get("Topic") or display.get("Image Topic") or ""
    return str(topic.get("Value", "") if isinstance(topic, Mapping) else topic)


def _key(kind: str, topic: str) -> str | None:
    if kind == "Map":
        costmap = next((name for name in ("global", "local") if f"{name}_costmap" in topic), "")
        return f"{costmap}_costmap" if costmap else "map"
    if kind == "Path":
        return "local_plan" if "local" in topic else "plan"
    return _KINDS.get(kind)


def _flat(path: Path) -> dict[str, Any] | None:
    """Return what a file without indentation says, None where it is no such file.

    A page on the web loses it: a display begins at a dash and ends at the next.
    """
    text = read_bytes(path, 2**20, InputFileError).decode("utf-8", "replace")
    displays: list[dict[str, Any]] = []
    options: dict[str, Any] = {}
    among = False  # the displays, not panels and tools
    for line in text.splitlines():
        match = _FLAT.match(line)
        if not match:
            continue
        dash, key, value = match.groups()
        if key in ("Visualization Manager", "Global Options"):
            among = key == "Visualization Manager"
        if key == "Fixed Frame":
            options[key] = value
        if among and dash:
            displays.append({})
        if among and displays and value:
            key = "Topic" if key == "Value" and value.startswith("/") else key
            displays[-1].setdefault(key, value != "false" and value)
    if not options:
        return None
    return {"Visualization Manager": {"Displays": displays, "Global Options": options}}
