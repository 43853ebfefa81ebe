"""Wheels whose rollers a file has one by one."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.robots.rollers import is_roller, rollers_of
from arjuna_sim.files.search_path import SearchPath
from tests.sim import drive_cases as cases
from tests.sim.builders import texts


@pytest.mark.parametrize("omni", [True, False])
def test_a_wheel_reaches_as_far_as_its_rollers(tmp_path: Path, omni: bool) -> None:
    robot = load_robot(cases.on_real_rollers(omni).write(tmp_path), SearchPath())
    names = [n for n in robot.urdf.joints if n.endswith("_joint")]
    assert set(robot.drive.wheels) == set(names)
    assert robot.drive.radius == pytest.approx(0.06)
    for name in names:
        child = robot.urdf.joints[name].child
        (rim,) = robot.urdf.links[child].collisions
        assert rim.shape.size[0] == pytest.approx(0.06)
        assert len(rollers_of(robot.urdf, name)) == 8
        assert not robot.urdf.links[f"{child}_3"].collisions
        assert is_roller(robot.urdf, f"{child}_3_pin")
        assert not is_roller(robot.urdf, name)
    notes = [text for text in texts(robot.notes) if "grips as its rollers do" in text]
    assert len(notes) == len(names)


def test_a_hub_in_parts_carries_its_rollers(tmp_path: Path) -> None:
    """Of a shaft that a motor turns and a housing fixed to it, which holds the rollers."""
    path = cases.on_real_rollers(True).write(tmp_path)
    robot = load_robot(path, SearchPath())
    names, text = robot.drive.wheels, path.read_text()
    for name in names:
        child = robot.urdf.joints[name].child
        text = text.replace(f"<parent link='{child}'/>", f"<parent link='{child}_hub'/>")
        hub = f"<link name='{child}_hub'/><joint name='{child}_hub' type='fixed'>"
        hub += f"<parent link='{child}'/><child link='{child}_hub'/></joint></robot>"
        text = text.replace("</robot>", hub)
    assert f"<parent link='{child}_hub'/>" in text
    path.write_text(text)
    whole = load_robot(path, SearchPath())
    assert whole.drive == robot.drive
    assert all(len(rollers_of(whole.urdf, name)) == 8 for name in names)


@pytest.mark.parametrize("axis", ["0 0 1", "0 1 0"])
def test_wheels_of_what_turns_are_no_rollers(tmp_path: Path, axis: str) -> None:
    """A base on a joint about the vertical, and a bogie on one that lies as its wheels' axles."""
    path = cases.Robot(cases.four()).write(tmp_path)
    turn = "<link name='root'/><joint name='turn' type='continuous'><parent link='root'/>"
    turn += f"<child link='base'/><axis xyz='{axis}'/></joint></robot>"
    path.write_text(path.read_text().replace("</robot>", turn))
    robot = load_robot(path, SearchPath())
    assert len(robot.drive.wheels) == 4
    assert not any("rollers" in text for text in texts(robot.notes))
    assert math.isclose(robot.drive.radius, 0.06)
