"""The viewer's entities and navigation."""

from __future__ import annotations

import math

import pytest

from arjuna_core.pose3 import Pose3
from bringup.viewing.robot.entities import HUMAN, ROBOT, Kind, bodies
from bringup.viewing.robot.managed import nodes_text
from bringup.viewing.robot.navigation import Navigation

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


DRIVING = Navigation("driving", 2.345, 12.4, 1)


def test_driving_says_how_far_and_how_often_it_recovered() -> None:
    assert DRIVING.text() == "**driving** · 2.35 m to go · 12 s, recoveries: 1"


def test_a_failure_says_why_and_no_distance() -> None:
    state = DRIVING.ended(6, 204, "no valid path")
    assert state.text() == "**failed** · 12 s, recoveries: 1\n\n⚠ no valid path"


def test_a_failure_without_words_says_its_code() -> None:
    assert Navigation().ended(6, 204, "").error == "error code 204"


def test_arrival_has_no_error() -> None:
    assert Navigation("driving").ended(4, 0, "").text() == "**arrived**"


def test_nodes_are_listed_by_name_with_their_states() -> None:
    rows = nodes_text(
        {"planner": "inactive", "amcl": "active", "x": "errorprocessing"},
        {"amcl": 0.25, "sim": 1.0},
    )
    assert rows.splitlines()[2:] == [
        "| ● | amcl | active | 25% |",
        "| ○ | planner | inactive |  |",
        "|  | sim |  | 100% |",
        "| ✖ | x | errorprocessing |  |",
    ]
    assert nodes_text({}) == "no managed nodes found"
