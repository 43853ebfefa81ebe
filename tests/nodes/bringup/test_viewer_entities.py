"""Claims: what a simulator knows is placed around the robot, whatever the map's origin."""

from __future__ import annotations

import math

import pytest

from arjuna_core.pose3 import Pose3
from bringup.viewing.robot.entities import HUMAN, ROBOT, Kind, bodies

BOX = Kind(0, (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))


def test_a_box_ahead_of_the_robot_is_ahead_of_it() -> None:
    kinds = {"robot": Kind(ROBOT, (0, 0, 0), (1, 1, 1)), "box": BOX}
    robot = Pose3.from_rpy((3.0, 1.0, 0.0), (0.0, 0.0, math.pi / 2))
    found = bodies(kinds, [("robot", robot), ("box", Pose3((3.0, 3.0, 0.0)))])
    assert found is not None
    (((position, _, size, _, _),), people) = found["box"], found["cylinder"]
    assert position == pytest.approx((2.0, 0.0, 0.5))
    assert tuple(size) == (1.0, 1.0, 1.0)
    assert not people


def test_people_are_known_and_shapeless_things_left_out() -> None:
    kinds = {
        "robot": Kind(ROBOT, (0, 0, 0), (1, 1, 1)),
        "ann": Kind(HUMAN, (-0.2, -0.2, 0.0), (0.2, 0.2, 1.8)),
        "ghost": Kind(0, (0, 0, 0), (0, 0, 0)),
    }
    found = bodies(kinds, [(name, Pose3()) for name in (*kinds, "unknown")])
    assert found is not None
    assert {shape: len(rows) for shape, rows in found.items()} == {"cylinder": 1, "box": 0}


def test_without_a_robot_nothing_can_be_placed() -> None:
    assert bodies({"box": BOX}, [("box", Pose3())]) is None
