"""RViz's configuration files, read and written: the fixed frame and the displays."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.yaml_file import read_yaml
from bringup.viewing.displays.base import DISPLAYS, DisplaySpec, properties_of, settings_of

_MOVE_BASE = "/move_base/"  # below which ROS 1 publishes what has no such place here
_OTHER_NAMES = {
    "Camera": "Image",
    "Axes": "TF",
    "WrenchStamped": "Wrench",
}
"""Displays of RViz that are shown by another one of ours."""
_PACKAGES = {"ParticleCloud": "nav2_rviz_plugins"} | dict.fromkeys(
    ("People", "Speed", "LocalizationQuality", "DistanceToGoal", "BehaviorTree"), "arjuna"
)
"""Where RViz has a display's class, if it has it elsewhere than most, or not at all."""
_FLAT = re.compile(r"^\s*(-\s+)?([\w ()]+?):\s*(.*?)\s*$")


@dataclass(frozen=True)
class RvizFile:
    """The wanted frame and displays.

    Attributes:
        fixed_frame: Empty where it names none.
        others: Displays that nothing here shows, as the file has them.
        document: All of the file.
    """

    fixed_frame: str
    displays: tuple[DisplaySpec, ...]
    others: tuple[Mapping[str, Any], ...] = ()
    document: Mapping[str, Any] | None = None

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the displays that nothing here shows, though the file does."""
        shown = (each for each in self.others if each.get("Enabled", True))
        kinds = ((each, str(each.get("Class", "")).rpartition("/")[2]) for each in shown)
        return tuple(str(each.get("Name", kind)) for each, kind in kinds if kind != "Grid")


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
    displays, others = [], []
    for display, shown in _displays(manager, True):
        spec = _spec(display, shown)
        if spec is None:
            others.append({**display, "Enabled": shown})
        else:
            displays.append(spec)
    frame = str((manager.get("Global Options") or {}).get("Fixed Frame", "")).lstrip("/")
    return RvizFile(frame, tuple(displays), tuple(others), document)


def _displays(parent: Mapping[str, Any], shown: bool) -> Iterator[tuple[Mapping[str, Any], bool]]:
    for display in parent.get("Displays") or ():
        if isinstance(display, Mapping):
            now = shown and bool(display.get("Enabled", True))
            if "Displays" in display:
                yield from _displays(display, now)
            else:
                yield display, now


def _spec(display: Mapping[str, Any], shown: bool) -> DisplaySpec | None:
    """Return a display; None where nothing here shows it."""
    given = str(display.get("Class", ""))
    kind, name = given.rpartition("/")[2], str(display.get("Name", ""))
    kind = _OTHER_NAMES.get(kind, kind)
    try:
        cls = DISPLAYS.resolve(kind)
    except ConfigError:
        return None
    topic = _topic(display, cls.property)
    if kind == "PoseArray" and given.startswith("rviz/") and "particle" in topic:
        kind, topic = "ParticleCloud", ""  # AMCL's, which in ROS 1 were poses
    settings = settings_of(kind, display)
    if kind == "Map" and "costmap" in topic:
        settings.setdefault("color_scheme", "costmap")
    if settings.get("color_scheme") == "costmap":
        settings.setdefault("height", 0.02 if "local" in topic else 0.01)
    if topic.startswith(_MOVE_BASE):
        topic = _of_ours(kind, topic)
    return DisplaySpec(kind, name or kind, topic.lstrip("/"), shown, settings, rviz=display)


def _topic(display: Mapping[str, Any], where: str) -> str:
    """Return a display's topic: a name in ROS 1, a mapping with its value in ROS 2."""
    topic = display.get(where) or display.get("Topic") or display.get("Image Topic") or ""
    topic = topic or display.get("Marker Topic") or display.get("Update Topic") or ""
    return str(topic.get("Value", "") if isinstance(topic, Mapping) else topic)


def _of_ours(kind: str, topic: str) -> str:
    """Return our topic of what ROS 1's move_base publishes; empty for a display's own."""
    which = "local" if "local" in topic else "global"
    if kind == "Map":
        return f"{which}_costmap/costmap" if "costmap" in topic else ""
    return "local_plan" if kind == "Path" and which == "local" else ""


def write_rviz(
    fixed_frame: str, displays: Iterable[DisplaySpec], read: RvizFile | None = None
) -> str:
    """Return a configuration that RViz 2 reads.

    Args:
        read: The file that they came from; what it says of RViz alone stays.
    """
    entries = [{"Class": "rviz_default_plugins/Grid", "Name": "Grid", "Enabled": True}]
    entries = list(read.others) if read else entries  # type: ignore[arg-type]
    entries += [_entry(each) for each in displays]
    document = dict(read.document or {}) if read else {}
    manager = {"Class": "", **(document.get("Visualization Manager") or {})}
    manager["Displays"] = [dict(each) for each in entries]
    manager["Global Options"] = {
        **(manager.get("Global Options") or {"Background Color": "48; 48; 48", "Frame Rate": 30}),
        "Fixed Frame": fixed_frame,
    }
    document["Visualization Manager"] = manager
    return str(yaml.safe_dump(document, sort_keys=False, allow_unicode=True))


def _entry(spec: DisplaySpec) -> dict[str, Any]:
    display = spec.make()
    package = _PACKAGES.get(spec.kind, "rviz_default_plugins")
    kind = spec.kind if ":" in spec.kind else f"{package}/{spec.kind}"
    entry = {
        "Class": kind,
        **spec.rviz,
        "Name": spec.name,
        "Enabled": spec.shown,
        "Value": spec.shown,
    }
    if display.types:
        before = entry.get(display.property)
        topic: Any = dict(before) if isinstance(before, Mapping) else {"Depth": 5}
        if "Interactive" in display.property:
            topic = display.name
        else:
            topic["Value"] = display.name if display.name[0] in "/~" else f"/{display.name}"
        entry[display.property] = topic
    return entry | properties_of(display)


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
