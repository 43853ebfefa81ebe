"""RViz's configuration files, read and written: the fixed frame and the displays."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.yaml_file import read_yaml
from bringup.viewing.displays.base import (
    ALL,
    DISPLAYS,
    PIXELS,
    SHOWN,
    DisplaySpec,
    properties_of,
    settings_of,
)
from bringup.viewing.rviz_view import View, read_view

_MOVE_BASE = "/move_base/"  # below which ROS 1 publishes what has no such place here
_OTHER_NAMES = {
    "Camera": "Image",
    "WrenchStamped": "Wrench",
}
"""Displays of RViz that are shown by another one of ours."""
_PACKAGES = {"ParticleCloud": "nav2_rviz_plugins"} | dict.fromkeys(
    ("People", "Speed", "LocalizationQuality", "DistanceToGoal", "BehaviorTree"), "arjuna"
)
"""Where RViz has a display's class, if it has it elsewhere than most, or not at all."""
_OF_RVIZ = re.compile(
    r"rviz(_common|_default_plugins)?/|nav2_rviz_plugins/(Navigation 2|GoalTool)$"
).match
"""Panels and tools that RViz always has, or that the viewer has a part for."""
_USUAL = {"move_base_simple/goal": "goal_pose"}
"""Topics of ROS 1 whose messages go elsewhere here."""
_NAMESPACE = re.compile(r"^/?<\w+>/")
_QOS = {
    latched: {
        "Depth": 5,
        "Durability Policy": "Transient Local" if latched else "Volatile",
        "History Policy": "Keep Last",
        "Reliability Policy": "Reliable" if latched else "Best Effort",
    }
    for latched in (True, False)
}
"""The QoS that fits every publisher of what is latched, or is not."""
_FLAT = re.compile(r"^\s*(-\s+)?([\w ()]+?):\s*(.*?)\s*$")


@dataclass(frozen=True)
class RvizFile:
    """The wanted frame and displays.

    Attributes:
        fixed_frame: Empty where it names none.
        unsupported: Displays that it shows, panels, tools and views that nothing here is for, each
            with its class.
        document: All of the file; the displays' `rviz` are parts of it.
    """

    fixed_frame: str
    displays: tuple[DisplaySpec, ...]
    unsupported: tuple[str, ...] = ()
    document: Mapping[str, Any] | None = None
    view: View | None = None
    tools: Mapping[str, str] = field(default_factory=dict)


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
    displays, unsupported = [], []
    for display, shown in _displays(manager, True):
        spec = _spec(display, shown)
        if spec is not None:
            displays.append(spec)
        elif shown and _kind(display) != "Grid":
            unsupported.append(_named(display))
    for what, parts in (("panel", document.get("Panels")), ("tool", manager.get("Tools"))):
        others = [part for part in _mappings(parts) if not _OF_RVIZ(_class(part))]
        unsupported += [f"{what} {_named(part)}" for part in others]
    frame = str((manager.get("Global Options") or {}).get("Fixed Frame", "")).lstrip("/")
    views = manager.get("Views")
    current = views.get("Current") if isinstance(views, dict) else None
    view = read_view(current, frame) if isinstance(current, dict) else None
    if view is None and isinstance(current, dict):
        unsupported.append(f"view {_named(current)}")
    tools = {
        _kind(tool): _USUAL.get(topic.lstrip("/"), topic)
        for tool in _mappings(manager.get("Tools"))
        if (topic := _topic(tool, "Topic"))
    }
    return RvizFile(frame, tuple(displays), tuple(unsupported), document, view, tools)


def _class(part: Mapping[str, Any]) -> str:
    return str(part.get("Class", ""))


def _kind(display: Mapping[str, Any]) -> str:
    return _class(display).rpartition("/")[2]


def _named(part: Mapping[str, Any]) -> str:
    name = str(part.get("Name", ""))
    return f"{name} ({_class(part)})" if name else _class(part)


def _displays(parent: Mapping[str, Any], shown: bool) -> Iterator[tuple[Mapping[str, Any], bool]]:
    for display in _mappings(parent.get("Displays")):
        now = shown and bool(display.get("Enabled", True))
        if "Displays" in display:
            yield from _displays(display, now)
        else:
            yield display, now


def _mappings(parts: Any) -> list[Mapping[str, Any]]:
    return [part for part in parts if isinstance(part, Mapping)] if isinstance(parts, list) else []


def _spec(display: Mapping[str, Any], shown: bool) -> DisplaySpec | None:
    """Return a display; None where nothing here shows it."""
    name = str(display.get("Name", ""))
    kind = _OTHER_NAMES.get(_kind(display), _kind(display))
    try:
        cls = DISPLAYS.resolve(kind)
    except ConfigError:
        return None
    topic = _topic(display, cls.property)
    if kind == "PoseArray" and topic.lstrip("/") == "particlecloud":
        kind, topic = "ParticleCloud", ""  # AMCL's, which before Nav2's 1.0 were poses
    settings = settings_of(kind, display)
    if kind == "Map" and "costmap" in topic:
        settings.setdefault("color_scheme", "costmap")
    if settings.get("color_scheme") == "costmap":
        settings.setdefault("height", 0.02 if "local" in topic else 0.01)
    if topic.startswith(_MOVE_BASE):
        topic = _of_ours(kind, topic)
    return DisplaySpec(kind, name or kind, topic, shown, settings, rviz=display)


def _topic(display: Mapping[str, Any], where: str) -> str:
    """Return a display's topic: a name in ROS 1, a mapping with its value in ROS 2.

    What a launch file would put in place of `<robot_namespace>` is the viewer's own namespace.
    """
    topic = display.get(where) or display.get("Topic") or display.get("Image Topic") or ""
    topic = topic or display.get("Marker Topic") or display.get("Update Topic") or ""
    topic = str(topic.get("Value", "") if isinstance(topic, Mapping) else topic)
    return _NAMESPACE.sub("", topic)


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
        read: The file that they came from: what it says stays, but for displays that are not as it
            has them.
    """
    document = dict(read.document or {}) if read else {}
    manager = {"Class": "", **(document.get("Visualization Manager") or {})}
    now = list(displays)
    before = {id(spec.rviz): spec for spec in read.displays} if read else {}
    grid = {"Class": "rviz_default_plugins/Grid", "Name": "Grid", "Enabled": True, "Value": True}
    manager["Displays"] = [
        *(_kept(manager.get("Displays"), before, {id(s.rviz): s for s in now}) if read else [grid]),
        *(_entry(spec) for spec in now if id(spec.rviz) not in before),
    ]
    manager["Global Options"] = {
        **(manager.get("Global Options") or {"Background Color": "48; 48; 48", "Frame Rate": 30}),
        "Fixed Frame": fixed_frame,
    }
    document["Visualization Manager"] = manager
    return str(yaml.safe_dump(document, sort_keys=False, allow_unicode=True))


_ById = Mapping[int, DisplaySpec]


def _kept(given: Any, before: _ById, now: _ById, opened: bool = False) -> list[Any]:
    """Return a file's displays as they are now, those that nothing here shows as they were.

    Args:
        before: The displays as they were read, by their mappings.
        opened: Whether they are of a group that was off and is on.
    """
    kept: list[Any] = []
    for each in _mappings(given):
        key = id(each)
        if "Displays" in each:
            was = bool(each.get("Enabled", True))
            inside = (now.get(id(part)) for part, _ in _displays(each, True))
            on = was or any(spec.shown for spec in inside if spec)
            parts = _kept(each["Displays"], before, now, opened or on > was)
            kept.append({**each, "Displays": parts, "Enabled": on})
        elif key in now:
            same = now[key] == before[key] and not opened
            kept.append(each if same else _entry(now[key], before[key]))
        elif key not in before:
            kept.append({**each, "Enabled": False} if opened else each)
    return kept


def _entry(spec: DisplaySpec, was: DisplaySpec | None = None) -> dict[str, Any]:
    """Return a display as RViz has it: what its file said of it, but for what has changed."""
    package = _PACKAGES.get(spec.kind, "rviz_default_plugins")
    kind = spec.kind if ":" in spec.kind else f"{package}/{spec.kind}"
    entry = {"Class": kind, **spec.rviz}
    entry |= {"Name": spec.name, "Enabled": spec.shown, "Value": spec.shown}
    before = {} if was is None else _properties(was)
    found = {key: value for key, value in _properties(spec).items() if before.get(key) != value}
    if entry.get("Style") == "Points" and "Size (m)" in found:
        found["Size (Pixels)"] = round(PIXELS * found["Size (m)"])
    shape = entry.get("Shape")
    if isinstance(shape, Mapping):
        inside = {key: found.pop(key) for key in shape.keys() & found.keys()}
        entry["Shape"] = {**shape, **inside}
    for key, value in found.items():
        old = entry.get(key)
        if key in SHOWN:
            named = (one for one in old or () if one != ALL)
            entry[key] = {**dict.fromkeys(named, SHOWN[key]), **value}
        elif isinstance(old, Mapping):
            entry[key] = {**old, **(value if isinstance(value, Mapping) else {"Value": value})}
        else:
            entry[key] = value
    return entry


def _properties(spec: DisplaySpec) -> dict[str, Any]:
    display = spec.make()
    found = properties_of(display)
    if display.types and "Namespace" in display.property:
        found[display.property] = display.name
    elif display.types:
        qos = {} if display.property in spec.rviz else _QOS[display.latched]
        found[display.property] = {**qos, "Value": display.name}
        if "Update Topic" in spec.rviz:
            found["Update Topic"] = {"Value": f"{display.name}_updates"}
    return found


def _flat(path: Path) -> dict[str, Any] | None:
    """Return what a file without indentation says, None where it is no such file.

    A page on the web loses it: a display begins at a dash and ends at the next.
    """
    text = read_bytes(path).decode("utf-8", "replace")
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
