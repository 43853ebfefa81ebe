"""`python -m bringup robot` beside the drivers of a robot that is not simulated by us."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.helpers.processes import Lines
from tests.helpers.real_robot import OPTIONS

pytestmark = [pytest.mark.ros, pytest.mark.system]
MAP = ("topic", "echo", "--once", "/map", "--field", "info.resolution")


@pytest.fixture(autouse=True)
def _own_domain_and_home(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "93")
    monkeypatch.setenv("HOME", str(tmp_path))


def test_it_maps_and_drives_to_a_goal_on_the_system_s_clock() -> None:
    with (
        Lines("-m", "tests.helpers.real_robot", "0") as drivers,
        Lines("-m", "bringup", "robot", "--slam", *OPTIONS) as robot,
    ):
        drivers.wait_for("at ")
        robot.wait_for("Managed nodes are active", 2)
        with Lines("-m", "bringup.ros2.main", *MAP) as first:
            first.wait_for("0.05")
        with Lines("-m", "bringup", "goto", "0.8", "0.4", "0.8") as goal:
            goal.wait_for("GOAL REACHED", within=60.0)
        drivers.wait_for("at ", len(drivers.matching("at ")) + 3)
        x, y, yaw = map(float, drivers.matching("at ")[-1].split()[1:])
        assert math.hypot(x - 0.8, y - 0.4) < 0.3
        assert abs(yaw - 0.8) < 0.5  # it turns on while a busy machine's last command is under way
        assert not [line for line in robot.seen if "[ERROR]" in line or "Traceback" in line]
