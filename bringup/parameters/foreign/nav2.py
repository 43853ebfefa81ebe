"""Nav2's, slam_toolbox's and AMCL's names without effect here, and older ones: `nav2.yaml`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import Any

from arjuna_core.errors import ConfigError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.plugins import canonical
from bringup.parameters.foreign.later import controllers_as_in_jazzy
from bringup.parameters.remarks import Kind

COSTMAPS = ("local_costmap/local_costmap", "global_costmap/global_costmap")
_TABLES: dict[str, Any] = read_yaml(Path(__file__).with_suffix(".yaml"))
_OLDER = _TABLES["older"]
_DWB = "dwb_core::DWBLocalPlanner"
_BACKWARD = ".allow_backward"
_FADING = "spatio_temporal_voxel_layer"
_PLANAR = 0, 1, 5  # of x, y, z, roll, pitch, yaw
LATER_CLASSES: dict[str, str | None] = _TABLES["later"]
"""Each with the class that does its work, but for what is new; None where none does."""
LIMITS = {ours: tuple(theirs.split()) for ours, theirs in _TABLES["limits"].items()}
"""A controller's limits, each with what controllers of others call it."""
_CRITICS = frozenset(_TABLES["critics"].split())


@cache
def _entries(node: str) -> tuple[tuple[str, Kind, str], ...]:
    """Return pattern, kind and reason of each name of a node, its own before everybody's."""
    return tuple(
        (pattern, kind, reason)
        for name in (node, "*")
        for kind in (Kind.NOT_NEEDED, Kind.NO_EFFECT, Kind.UNKNOWN)
        for reason, patterns in _TABLES["names"][kind.value].get(name, {}).items()
        for pattern in patterns.split()
    )


def of_key(node: str, key: str) -> tuple[Kind, str] | None:
    """Return why a name of a node has no effect; None where nobody is known to use it."""
    for pattern, kind, reason in _entries(node):
        if "=" not in pattern and fnmatchcase(key, pattern):
            return kind, reason
    return None


def of_value(node: str, key: str, value: Any) -> tuple[Kind, str] | None:
    """Return why a value has no effect where other values of its parameter have one.

    A pattern's `NAME=` is before those that have none, `NAME!=` before those that have one.
    """
    text = str(value).lower()
    for pattern, kind, reason in _entries(node):
        name, equals, values = pattern.partition("=")
        without = (text in values.split("|")) != name.endswith("!")
        if equals and without and fnmatchcase(key, name.removesuffix("!")):
            return kind, reason
    return None


def of_node(name: str) -> tuple[Kind, str] | None:
    """Return why a node has no counterpart."""
    last = name.rsplit("/", 1)[-1]
    for kind, reasons in _TABLES["nodes"].items():
        for reason, patterns in reasons.items():
            if any(fnmatchcase(last, pattern) for pattern in patterns.split()):
                return Kind(kind), reason
    return None


def is_safety(node: str, key: str) -> bool:
    """Return whether a name, or one of the node "nodes", keeps a robot from harm elsewhere."""
    patterns = (_TABLES["safety"].get(name, "").split() for name in (node, "*"))
    return any(fnmatchcase(key, pattern) for each in patterns for pattern in each)


def made_of(node: str) -> set[str]:
    """Return the names that a whole section has of a node without classes."""
    return set(_TABLES["whole"].get(node, "").split())


def section_as_today(name: str) -> str:
    """Return a section's name with the node's name of today."""
    before, slash, node = name.rpartition("/")
    return f"{before}{slash}{_OLDER['nodes'].get(node, node)}"


def as_today(node: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a node's values with keys, classes and forms of today."""
    values: dict[str, Any] = {}
    for key, value in given.items():
        today = _key_as_today(node, key, given)
        if key.endswith("plugin") and isinstance(value, str):
            value = canonical(value).replace("nav2_recoveries::", "nav2_behaviors::")
            value = _OLDER["classes"].get(value, value)
            value = value if today == key else [value]
        if node == "velocity_smoother" and isinstance(value, list) and len(value) == 6:
            value = [value[at] for at in _PLANAR]
        if key.endswith(".input_sensor_type"):
            value = str(value).upper()  # as Nav2 reads it
        if key.endswith(".aggregation_type"):
            value = str(value).lower()  # as Nav2 reads it
        if isinstance(value, str):
            value = _OLDER["values"].get(node, {}).get(key, {}).get(value, value)
        values[today] = value
    if node == "controller_server":
        values = _critics_as_today(controllers_as_in_jazzy(values))
    return _zones_as_today(values) if node == "collision_monitor" else values


def _key_as_today(node: str, key: str, given: Mapping[str, Any]) -> str:
    """Return today's name of a key, unless the file has that one too."""
    names, (before, _, last) = _OLDER["names"].get(node, {}), key.rpartition(".")
    today = names.get(key, key)
    if f"*.{last}" in names and _FADING not in str(given.get(f"{key.partition('.')[0]}.plugin")):
        today = f"{before}.{names[f'*.{last}']}"
    return key if today in given else today


def as_started(node: str, whole: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """Yield name, new value and reason of each of all values that Nav2 replaces at the start."""
    from arjuna_nav.costmap.footprint import Footprint

    for key, value in whole.items():
        if key.endswith(_BACKWARD) and value is True:
            beside = key.removesuffix(_BACKWARD) + ".initial_rotation"
            if whole.get(beside) is True:
                yield key, False, f"'{beside}' is true: false holds, as in Nav2"
        if ".decel_lim_" in key and isinstance(value, float) and value > 0.0:
            yield key, -value, f"{value:g} would slow nothing down: {-value:g} holds"
        if node in COSTMAPS and key == "footprint" and isinstance(value, str):
            try:
                Footprint.parse(value, 0.0, 0.0)
            except ConfigError as error:
                yield key, "[]", f"{error}; robot_radius holds, as in Nav2"
    if node == "velocity_smoother":
        yield from _brakes(whole)
    least, most = (whole.get(key) for key in ("min_particles", "max_particles"))
    if node == "amcl" and isinstance(least, int) and isinstance(most, int) and least > most:
        yield "max_particles", least, f"{most} is below min_particles: {least} holds, as in Nav2"


def _brakes(whole: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """Yield a smoother's decelerations where one is 0 of what accelerates: it would never stop."""
    speeds, slows = (whole.get(f"max_{of}") for of in ("accel", "decel"))
    if not isinstance(speeds, (list, tuple)) or not isinstance(slows, (list, tuple)):
        return
    pairs = list(zip(speeds, slows, strict=False))
    stopped = [-up if up and down == 0.0 else down for up, down in pairs]
    if len(speeds) == len(slows) and stopped != list(slows):
        never = f"{list(slows)} would let what max_accel sets moving never stop"
        yield "max_decel", stopped, f"{never}: {stopped} holds"


def _critics_as_today(values: dict[str, Any]) -> dict[str, Any]:
    """Return values in which each critic of DWB has the name that says its class.

    Nav2 takes a class's package and its `Critic` in the list too, and any name beside `NAME.class`.
    """
    for key, given in list(values.items()):
        plugin, dot, last = key.rpartition(".")
        if last != "critics" or not dot or not isinstance(given, list):
            continue
        if _DWB not in (values.get(f"{plugin}.{one}") for one in ("plugin", "primary_controller")):
            continue
        for name in map(str, given):
            cls = str(values.get(f"{plugin}.{name}.class", name))
            plain = cls.removeprefix("dwb_critics::").removesuffix("Critic")
            if plain in _CRITICS:
                own = {k: v for k, v in values.items() if k.startswith(f"{plugin}.{name}.")}
                values = {k: v for k, v in values.items() if k not in own}
                own.pop(f"{plugin}.{name}.class", None)
                tail = len(f"{plugin}.{name}")
                values |= {f"{plugin}.{plain}{k[tail:]}": v for k, v in own.items()}
                values[key] = [plain if one == name else one for one in values[key]]
    return values


def _zones_as_today(values: dict[str, Any]) -> dict[str, Any]:
    """Return a collision monitor's values with zones as Nav2 has them since Iron."""
    lists = {k: v for k, v in values.items() if k.endswith(".points") and isinstance(v, list)}
    for key, given in lists.items():
        flat = all(isinstance(each, (int, float)) for each in given)
        pairs = zip(given[::2], given[1::2], strict=False)
        values[key] = str([list(pair) for pair in pairs] if flat else given)
    return values
