"""Topics and frames that a robot's file names."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arjuna_sim.inputs import named_robot, names_of, steering_of
from tests.sim.builders import ROBOT
from tests.sim.drive_cases import car

_OTHER = {
    "base_footprint": "chassis_foot",
    "<topicName>scan<": "<topicName>/front/scan<",
    "<commandTopic>cmd_vel<": "<commandTopic>drive<",
    "<odometryTopic>odom<": "<odometryTopic>wheels/odom<",
}


def test_standard_names_are_left_out() -> None:
    assert names_of(named_robot("", "")) == {}


def test_names_of_its_own_are_returned(tmp_path: Path) -> None:
    text = ROBOT.read_text(encoding="utf-8")
    for old, new in _OTHER.items():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "other.urdf"
    path.write_text(text, encoding="utf-8")
    assert names_of(named_robot(str(path), "")) == {
        "scan_topic": "/front/scan",
        "cmd_vel_topic": "drive",
        "odom_topic": "wheels/odom",
        "base_frame": "chassis_foot",
    }


@pytest.mark.parametrize("limit", [0.5, 0.95])
def test_a_steered_robots_tightest_bend_is_that_of_its_inner_wheel(
    tmp_path: Path, limit: float
) -> None:
    robot = named_robot(str(car("gz", limit=limit).write(tmp_path)), "")
    steering = steering_of(robot, "base")
    assert steering is not None
    assert steering.radius == pytest.approx(0.36 / math.tan(limit) + 0.12)
    assert steering.axle == pytest.approx(-0.16)
    assert steering_of(named_robot("", ""), "base_link") is None
