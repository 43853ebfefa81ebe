"""Each limit of a message: what lies on it is taken, what lies beyond is refused by its name."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

from arjuna_core.checks import limits
from arjuna_core.checks.message import call_problem, problem_of
from arjuna_core.checks.rules import (
    grid_problem,
    pose_problem,
    range_problem,
    rotation_problem,
    scan_problem,
    stamp_problem,
    transform_problem,
)
from tests.core.checks.test_rules import grid, rotation, scan, transform

TURN = 2.0 * math.pi


def sonar(**changed: float) -> Any:
    return SimpleNamespace(**{"field_of_view": 0.4, "min_range": 0.1, "max_range": 2.0, **changed})


def place(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return SimpleNamespace(position=SimpleNamespace(x=x, y=y, z=z))


def beams(count: int, each: float, **changed: Any) -> Any:
    return scan(ranges=range(count), angle_increment=each, **changed)


def names(parent: int, child: int) -> Any:
    return transform(frame_id="p" * parent, child_frame_id="c" * child)


BOUNDS = [
    (rotation_problem, rotation(w=1e-6), rotation(w=0.99e-6)),
    (rotation_problem, rotation(x=1e6, w=0.0), rotation(x=1.01e6, w=0.0)),
    (rotation_problem, rotation(x=8e5, z=6e5, w=0.0), rotation(x=8e5, z=6.1e5, w=0.0)),
    (rotation_problem, rotation(y=8e5, w=6e5), rotation(y=8.1e5, w=6e5)),
    (scan_problem, beams(limits.BEAMS, 1e-6), beams(limits.BEAMS + 1, 1e-6)),
    (scan_problem, beams(2, 1e-6), beams(2, 0.99e-6)),
    (scan_problem, beams(3, -TURN), beams(2, -1.01 * TURN)),
    (scan_problem, beams(3, TURN), beams(4, 0.7 * TURN)),
    (scan_problem, scan(angle_min=-2.0 * TURN), scan(angle_min=-2.01 * TURN)),
    (scan_problem, scan(range_min=0.0), scan(range_min=-0.01)),
    (scan_problem, scan(range_min=9.9), scan(range_min=10.0)),
    (scan_problem, scan(range_max=limits.FARTHEST), scan(range_max=1.01 * limits.FARTHEST)),
    (scan_problem, scan(time_increment=-10.0 / 3.0), scan(time_increment=-3.4)),
    (range_problem, sonar(field_of_view=TURN), sonar(field_of_view=1.01 * TURN)),
    (range_problem, sonar(field_of_view=1e-9), sonar(field_of_view=0.0)),
    (range_problem, sonar(min_range=0.0), sonar(min_range=-0.01)),
    (range_problem, sonar(min_range=2.0), sonar(min_range=2.01)),
    (range_problem, sonar(max_range=limits.FARTHEST), sonar(max_range=1.01 * limits.FARTHEST)),
    (grid_problem, grid(limits.FINEST), grid(0.99 * limits.FINEST)),
    (grid_problem, grid(limits.COARSEST), grid(1.01 * limits.COARSEST)),
    (grid_problem, grid(0.1, 1, 1, 1), grid(0.1, 0, 1, 0)),
    (
        grid_problem,
        grid(0.1, limits.CELLS, 1, limits.CELLS),
        grid(0.1, limits.CELLS + 1, 1, limits.CELLS + 1),
    ),
    (pose_problem, place(x=limits.FARTHEST), place(x=1.01 * limits.FARTHEST)),
    (pose_problem, place(y=-limits.FARTHEST), place(y=-1.01 * limits.FARTHEST)),
    (pose_problem, place(z=-limits.FARTHEST), place(z=-1.01 * limits.FARTHEST)),
    (transform_problem, transform(-limits.FARTHEST), transform(-1.01 * limits.FARTHEST)),
    (transform_problem, transform(sec=0), transform(sec=-1)),
    (transform_problem, names(1, limits.TEXT - 1), names(1, limits.TEXT)),
    (transform_problem, names(2, 1), names(0, 1)),
    (transform_problem, names(1, 2), names(1, 0)),
]


@pytest.mark.parametrize(("problem", "on_it", "beyond"), BOUNDS)
def test_a_limit_is_valid_itself(problem: Any, on_it: Any, beyond: Any) -> None:
    assert problem(on_it) is None
    assert problem(beyond) is not None


def test_a_measurement_is_not_far_ahead_of_a_clock_that_has_begun() -> None:
    class Imu:
        header = SimpleNamespace(stamp=SimpleNamespace(sec=110))

    class Path(Imu):
        """What is no measurement may lie ahead."""

    assert stamp_problem(Imu(), 100.0) is None
    assert stamp_problem(Imu(), 0.0) is None
    assert stamp_problem(Path(), 1.0) is None
    ahead = "its stamp is 11 s ahead of the clock; does its sender use sim time?"
    assert stamp_problem(Imu(), 99.0) == ahead


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


def time(sec: int = 5, nanosec: int = 0) -> Any:
    return SimpleNamespace(sec=sec, nanosec=nanosec)


LONG = "x" * (limits.TEXT + 1)
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
        (made(a=("double", limits.GREATEST)), None),
        (made(a=("double", 1.0), b=("float", -1.1e12)), "b is -1100000000000.0, too great"),
        (made(a=("double", math.inf)), "a is inf, not finite"),
        (made(a=("double", 6e11), b=("double", -6e11)), "its numbers are too great"),
        (made(inner=("pkg/Inner", INNER)), "inner.speed is nan, not finite"),
        (made(name=("string", LONG[1:])), None),
        (made(name=("string", LONG)), "name has 4097 characters; at most 4096 are valid"),
        (made(name=("string<9>", LONG)), "name has 4097 characters; at most 4096 are valid"),
        (made(data=("string", LONG)), None),
        (made(data=("string", "x" * (limits.DOCUMENT + 1))), "data has 16777217 characters"),
        (made(stamp=("builtin_interfaces/Time", time())), None),
        (made(stamp=("builtin_interfaces/Time", time(-1))), "stamp: is -1 s"),
        (made(left=("builtin_interfaces/Duration", time(-1))), None),
        (
            made(left=("builtin_interfaces/Duration", time(0, 10**9))),
            "left: 1000000000 ns; valid: less than 1000000000",
        ),
        (made(q=("geometry_msgs/Quaternion", rotation(w=0.0))), "q: quaternion"),
        (made(at=("sequence<double>", [1.0, math.nan])), "at: one is nan, not finite"),
        (made(at=("double[36]", [0.0, 1e300, 0.0])), "at: one is 1e+300, too great"),
        (made(at=("sequence<double>", [1e12, 0.0])), None),
        (made(at=("sequence<double>", [])), None),
        (made(at=("sequence<float, 4>", [math.inf])), "at: one is inf, not finite"),
        (made(at=("sequence<string>", ["a", LONG])), "at: one has 4097 characters; at most 4096"),
        (made(at=("sequence<string>", ["a", LONG[1:]])), None),
        (made(at=("sequence<pkg/Inner>", [INNER])), "at[0]: speed is nan, not finite"),
        (made(at=("sequence<builtin_interfaces/Time>", [time(), time(-2)])), "at[1]: is -2 s"),
        (made(at=("sequence<int32>", range(limits.ITEMS))), None),
        (made(at=("sequence<int32>", range(limits.ITEMS + 1))), "at has 10001 items; at most 1000"),
        (made(at=("sequence<uint8>", np.zeros(limits.ITEMS + 1, np.uint8))), None),
        (made(pose=("geometry_msgs/Pose", POSE)), "pose: position (1000000000.0, 0.0, 0.0)"),
        (made("Range", field_of_view=("float", 0.0), range=("float", math.nan)), "field_of_view"),
    ],
)
def test_a_message_is_looked_at_part_by_part(message: Any, problem: str | None) -> None:
    found = problem_of(message)
    assert (found is None) if problem is None else str(found).startswith(problem)


def test_a_parameter_has_a_type_that_there_is() -> None:
    def request(kind: int) -> Any:
        value = SimpleNamespace(type=kind)
        return SimpleNamespace(parameters=[SimpleNamespace(name="speed", value=value)])

    assert call_problem(request(9)) is None
    assert call_problem(request(10)) == "speed: type 10; valid: 0 to 9"
    assert call_problem(SimpleNamespace()) is None
