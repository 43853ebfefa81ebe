"""Claims: every part of a message is checked, and the first that cannot be used is named."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
import pytest

from arjuna_core.ros.health import rules
from arjuna_core.ros.health.checks import problem_of


class Message:
    """A message of a made type: its fields with their types of ROS, and their values."""

    KINDS: ClassVar[dict[str, str]] = {}

    def __init__(self, **values: Any) -> None:
        self.__dict__.update(values)

    def get_fields_and_field_types(self) -> dict[str, str]:
        return self.KINDS


def made(name: str = "Made", /, **fields: tuple[str, Any]) -> Message:
    """Return a message of a type made for it alone, of fields' types and values."""
    kinds = {key: kind for key, (kind, _) in fields.items()}
    cls = type(name, (Message,), {"KINDS": kinds})
    message: Message = cls(**{key: value for key, (_, value) in fields.items()})
    return message


def time(sec: int = 5, nanosec: int = 0, kind: str = "Time") -> Message:
    return made(kind, sec=("int32", sec), nanosec=("uint32", nanosec))


def rotation(w: float = 1.0) -> Message:
    parts = dict.fromkeys("xyz", ("double", 0.0))
    return made("Quaternion", **parts, w=("double", w))


LONG = "x" * (rules.TEXT + 1)
INNER = made("Inner", speed=("double", math.nan))
POSE = made(
    "Pose",
    position=(
        "geometry_msgs/Point",
        made("Point", x=("double", 1e9), y=("double", 0.0), z=("double", 0.0)),
    ),
    orientation=("geometry_msgs/Quaternion", rotation()),
)


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (made(a=("double", rules.GREATEST)), None),
        (made(a=("double", 1.0), b=("float", -1.1e12)), "b: -1100000000000.0 is too great"),
        (made(a=("double", math.inf)), "a: inf is not finite"),
        (made(inner=("pkg/Inner", INNER)), "inner.speed: nan is not finite"),
        (made(name=("string", LONG[1:])), None),
        (made(name=("string", LONG)), "name: 4097 characters; at most 4096 are valid"),
        (made(name=("string<9>", LONG)), "name: 4097 characters; at most 4096 are valid"),
        (made(data=("string", LONG)), None),
        (made(data=("string", "x" * (rules.DOCUMENT + 1))), "data: 16777217 characters"),
        (made(stamp=("builtin_interfaces/Time", time())), None),
        (made(stamp=("builtin_interfaces/Time", time(-1))), "stamp: -1 s"),
        (made(left=("builtin_interfaces/Duration", time(-1, kind="Duration"))), None),
        (
            made(left=("builtin_interfaces/Duration", time(0, 10**9, "Duration"))),
            "left: 1000000000 ns; valid: less than 1000000000",
        ),
        (made(q=("geometry_msgs/Quaternion", rotation(w=0.0))), "q: quaternion"),
        (made(at=("sequence<double>", [1.0, math.nan])), "at: nan is not finite"),
        (made(at=("double[36]", [0.0, 1e300, 0.0])), "at: 1e+300 is too great"),
        (made(at=("sequence<double>", [1e12, 0.0])), None),
        (made(at=("sequence<double>", [])), None),
        (made(at=("sequence<float, 4>", [math.inf])), "at: inf is not finite"),
        (made(at=("sequence<string>", ["a", LONG])), "at: item 1: 4097 characters; at most 4096"),
        (made(at=("sequence<string>", ["a", LONG[1:]])), None),
        (made(at=("sequence<pkg/Inner>", [INNER])), "at: item 0: speed: nan is not finite"),
        (made(at=("sequence<builtin_interfaces/Time>", [time(), time(-2)])), "at: item 1: -2 s"),
        (made(at=("sequence<int32>", range(rules.ITEMS))), None),
        (made(at=("sequence<int32>", range(rules.ITEMS + 1))), "at: 10001 items; at most 1000"),
        (made(at=("sequence<uint8>", np.zeros(rules.ITEMS + 1, np.uint8))), None),
        (made(pose=("geometry_msgs/Pose", POSE)), "pose: position (1000000000.0, 0.0, 0.0)"),
        (made("ParameterValue", type=("uint8", 9)), None),
        (made("ParameterValue", type=("uint8", 10)), "type 10; valid: 0 to 9"),
        (made(names=("sequence<string>", ["a"] * (rules.CALLS + 1))), "names: 1001 items"),
        (made("Range", field_of_view=("float", 0.0), range=("float", math.nan)), "field_of_view"),
    ],
)
def test_a_message_is_looked_at_part_by_part(message: Any, problem: str | None) -> None:
    found = problem_of(message)
    assert (found is None) if problem is None else str(found).startswith(problem)
