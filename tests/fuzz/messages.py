"""Messages of any type filled at random, and the topics and services that take them.

They are plausible, extreme, or plausible with a few traps.
"""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosidl_parser import definition

from arjuna_core.ros.messages import interface

MOODS = (0.0, 0.03, 0.2, 1.0)  # the share of a message's values that are extreme
_FLOATS = (
    *(math.nan, math.inf, -math.inf, 1e300, -1e300, 1e38, 1e12, 1e9, -1e7, 1e-9, 1e-300),
    *(5e-324, -1e-310, 1e-40, 0.0, -0.0, -1.0, 1.0 + 2.0**-52, 180.0),
)
_FLOAT32 = tuple(value for value in _FLOATS if not math.isfinite(value) or abs(value) < 3e38)
_STRINGS = (
    *("", "x" * 300, "(a+)+$", "(" * 200, "[", "//[", "http://[", "file://", "package://nothing"),
    *("../../etc/passwd", "/dev/zero", "/proc/self/mem", ".", "~", "%s%n{0}", "[[[[" * 100),
    *("a b\nc\t", "\u202e\U0001f4a5" * 60, "&lol;<!DOCTYPE", "nan", "1e999", "-", "x" * 100_000),
)
_NAMES = (
    *("map", "odom", "base_footprint", "base_link", "lidar_link", "", "GridBased", "FollowPath"),
    *("box", "a", "arjuna_room", "test_map", "goal_checker", "SmoothPath", "false", "1"),
)
_LATE = (0.0, -0.05, -0.5, -5.0, -1e3, 0.05, 0.5, 5.0, 1e3, 1e9)
"""How far from now a stamp may be [s]."""
LENGTHS = (0, 1, 7, 1000, 20_000)
ZIGZAG = 100_000
"""Poses of a path that goes to and fro."""
_MOST = 200_000  # items of a message, those within items too
_BYTES = 512  # of text for each: 100 MB in all; what DDS itself takes for more, none can refuse
_INTEGERS = {
    f"{sign}int{bits}": (0 if sign else -(2 ** (bits - 1)), 2 ** (bits if sign else bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}
_WIDEST = (np.uint64, np.int64)


class Filler:
    """Fills messages at random.

    Args:
        rng: Chooses everything.
        now: Time that plausible stamps are near [s].
    """

    def __init__(self, rng: np.random.Generator, now: float = 0.0) -> None:
        self._rng = rng
        self.now = now
        self._share = 0.0
        self._budget = _MOST

    def message(self, cls: Any) -> Any:
        """Return a message in a mood of its own; half of the well-known ones fit together."""
        self._share = float(self._rng.choice(MOODS))
        made = self._fill(cls)
        if self._rng.random() < 0.6:
            self._fit(made)
        return made

    def garble(self, serialized: bytes) -> bytes:
        """Return a serialized message with bytes changed or cut off, never longer."""
        data = bytearray(serialized)
        for _ in range(int(self._rng.integers(1, 8))):
            at = int(self._rng.integers(4, max(len(data), 5)))  # the header of four stays
            kind = self._rng.integers(0, 4)
            if kind == 0:
                data[at : at + 4] = self._rng.bytes(4)
            elif kind == 1:
                data[at : at + 4] = b"\xff\xff\xff\x7f"
            elif kind == 2:
                del data[max(at, 4) :]
            else:
                data[at : at + 1] = self._rng.bytes(1)
        return bytes(data[: len(serialized)])

    def _pick(self, values: Any) -> Any:
        return values[int(self._rng.integers(0, len(values)))]

    def _extreme(self) -> bool:
        return bool(self._rng.random() < self._share)

    def _fill(self, cls: Any) -> Any:
        made = cls()
        for name, kind in zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True):
            value = self._value(kind)
            if value is not None:
                setattr(made, name, value)
        return made

    def _value(self, kind: Any) -> Any:
        if isinstance(kind, definition.BasicType):
            return self._basic(kind.typename)
        if isinstance(kind, definition.AbstractGenericString):
            text = self._pick(_STRINGS if self._extreme() else _NAMES)[: self._budget * _BYTES]
            return text[: kind.maximum_size] if kind.has_maximum_size() else text
        if isinstance(kind, definition.NamespacedType):
            return self._fill(interface(kind))
        if isinstance(kind, definition.Array):
            return [self._value(kind.value_type) for _ in range(kind.size)]
        most = kind.maximum_size if isinstance(kind, definition.BoundedSequence) else _MOST
        return self._sequence(kind.value_type, most)

    def _sequence(self, kind: Any, most: int) -> Any:
        """Return few items, or a few of them repeated very often."""
        primitive = isinstance(kind, definition.BasicType)
        number = int(self._rng.integers(0, 6))
        if self._extreme():
            number = int(self._pick(LENGTHS))
            number = self._budget if primitive and number == LENGTHS[-1] else number
        number = min(number, most, self._budget)
        budget, self._budget = self._budget, self._budget // max(number, 1)
        few = [self._value(kind) for _ in range(min(number, 5))]
        self._budget = budget
        return (few * (number // 5 + 1))[:number]

    def _basic(self, name: str) -> Any:
        extreme = self._extreme()
        if name in ("double", "float"):
            values = _FLOATS if name == "double" else _FLOAT32
            return float(self._pick(values) if extreme else self._rng.uniform(-3.0, 3.0))
        if name == "boolean":
            return bool(self._rng.integers(0, 2))
        if name == "octet":
            return self._rng.bytes(1)
        low, high = _INTEGERS.get(name, (0, 127))
        if not extreme:
            return int(self._pick(range(6)))
        any_one = int(self._rng.integers(low, high, endpoint=True, dtype=_WIDEST[low < 0]))
        return int(self._pick((low, high, 0, max(low, -1), any_one, any_one)))

    def _fit(self, message: Any) -> None:
        """Make the parts of a message fit each other, so that it comes further."""
        fields = message.get_fields_and_field_types()
        for name, kind in fields.items():
            value = getattr(message, name)
            if hasattr(value, "get_fields_and_field_types"):
                self._fit(value)
            elif isinstance(value, list) and len(value) < 100:
                for item in value:
                    if hasattr(item, "get_fields_and_field_types"):
                        self._fit(item)
            elif kind == "builtin_interfaces/Time":
                self._stamp(value)
        self._fit_type(message, type(message).__name__)

    def _stamp(self, stamp: Any) -> None:
        time = self.now + (float(self._pick(_LATE)) if self._extreme() else 0.0)
        time = min(max(time, 0.0), 2.0**31 - 1.0)
        stamp.sec, stamp.nanosec = int(time), int(time % 1.0 * 1e9)

    def _fit_type(self, message: Any, name: str) -> None:
        if name == "Time":
            self._stamp(message)
        elif name == "Quaternion" and not self._extreme():
            angle = float(self._rng.uniform(-3.1, 3.1))
            message.x = message.y = 0.0
            message.z, message.w = math.sin(angle / 2.0), math.cos(angle / 2.0)
        elif name == "LaserScan" and not self._extreme():
            message.angle_min, message.angle_increment = -math.pi, 2.0 * math.pi / 360.0
            message.angle_max, message.header.frame_id = math.pi, "lidar_link"
            message.range_min, message.range_max = 0.1, 12.0
            message.ranges = [self._basic("float") for _ in range(360)]
        elif name == "OccupancyGrid" and len(message.data) < 1000:
            message.header.frame_id = "map"
            message.info.width, message.info.height = 40, 30
            message.info.resolution = self._basic("float") if self._extreme() else 0.05
            message.data = [int(self._rng.integers(-128, 128)) for _ in range(1200)]
        elif name == "Path" and self._rng.random() < 0.5:
            self._path(message)

    def _path(self, message: Any) -> None:
        """Give a path's poses its frame; one in three goes to and fro very often."""
        message.header.frame_id = "map"
        for item in message.poses:
            item.header.frame_id = "map"
        if message.poses and self._rng.random() < 0.3:
            few = message.poses[:ZIGZAG]
            message.poses = (few * (ZIGZAG // len(few) + 1))[:ZIGZAG]


_ACTION_PARTS = {
    "_SendGoal": "SendGoalService",
    "_GetResult": "GetResultService",
    "_FeedbackMessage": "FeedbackMessage",
}
_REFUSED_TRANSITIONS = (0, 1, 2, 9, 10, 42, 60, 99, 255)  # of an active node
_NOT_TO_ASK = ("unload_world",)  # what a client may ask, and then nothing drives


@dataclass(frozen=True)
class Target:
    """Something to send to.

    Attributes:
        name: The topic or service.
        kind: `topic` or `service`; an action is three services.
        cls: The message class, or the service's.
    """

    name: str
    kind: str
    cls: Any


def found(node: Any) -> list[Target]:
    """Return all that others in a node's graph hear or serve, sorted by name."""
    own = {publisher.topic_name for publisher in node.publishers}
    topics = [
        Target(name, "topic", _class(types[0]))
        for name, types in node.get_topic_names_and_types()
        if node.count_subscribers(name) and name not in own
    ]
    services = [
        Target(name, "service", _class(types[0]))
        for name, types in node.get_service_names_and_types()
        if not name.endswith(_NOT_TO_ASK) and f"/{node.get_name()}/" not in name
    ]
    return sorted(topics + services, key=lambda target: target.name)


def drawn(targets: list[Target], rng: np.random.Generator) -> Target:
    """Return one of them; every type is as likely, however many nodes have a service of it."""
    kinds = sorted({str(target.cls) for target in targets if target.kind == "service"})
    kind = str(rng.choice(kinds))
    topics = rng.random() < 0.5
    some = [t for t in targets if (t.kind == "topic" if topics else str(t.cls) == kind)]
    return some[int(rng.integers(0, len(some)))]


def _class(name: str) -> Any:
    package, kind, short = name.split("/")
    module = importlib.import_module(f"{package}.{kind}")
    for suffix, part in _ACTION_PARTS.items():
        if kind == "action" and short.endswith(suffix):
            return getattr(getattr(module, short.removesuffix(suffix)).Impl, part)
    return getattr(module, short)


def profile(node: Any, topic: str) -> QoSProfile:
    """Return a profile that every subscription of a topic hears."""
    ends = node.get_subscriptions_info_by_topic(topic)
    latched = any(e.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for e in ends)
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=10, durability=durability)


def harmless(request: Any, rng: np.random.Generator) -> Any:
    """Return a request without what a client may rightly ask for and nothing drives after."""
    package, name = type(request).__module__.split(".")[0], type(request).__name__
    if name == "ChangeState_Request":
        request.transition.id = int(rng.choice(_REFUSED_TRANSITIONS))
        request.transition.label = str(rng.choice(("", "", "", "x")))
    if name == "ManageLifecycleNodes_Request":
        request.command = max(request.command, 7)
    if name == "SetSimulationState_Request" and request.state.state == 3:
        request.state.state = 2
    if name == "TFMessage" and package == "tf2_msgs":
        for item in request.transforms[:100]:
            item.child_frame_id = f"foreign_{item.child_frame_id[:20]}"
    return request


def filled(target: Target, filler: Filler, rng: np.random.Generator, names: list[str]) -> Any:
    """Return a message or request for a target; parameters are often those that are there."""
    cls = target.cls if target.kind == "topic" else target.cls.Request
    made = harmless(filler.message(cls), rng)
    for item in getattr(made, "parameters", [])[:100]:
        if hasattr(item, "value") and names and rng.random() < 0.9:
            item.name = str(rng.choice(names))
            item.value.type = int(rng.choice((1, 2, 3, 4, 3, 3)))
    return made
