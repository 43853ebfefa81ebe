"""Drives that are simulated as others say so, and drive."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_sim.devices.drive import Velocity
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.robot_file import load_robot
from tests.sim.builders import run, simulator, texts
from tests.sim.files.test_robots import FOUR, LEFT, _robot

JOINT = "<{told}_{side}_joint>{end}_{side}_wheel_joint</{told}_{side}_joint>"
FOUR_JOINTS = "".join(
    JOINT.format(told=told, end=end, side=side)
    for told, end in (("front", "front"), ("back", "rear"))
    for side in ("left", "right")
)
SIDES = re.sub("(</?)(front|back)_", r"\1", FOUR_JOINTS)
PARAMETERS = """
mecanum_drive_controller:
  ros__parameters:
    front_left_wheel_command_joint_name: front_left_wheel_joint
    front_right_wheel_command_joint_name: front_right_wheel_joint
    rear_left_wheel_command_joint_name: rear_left_wheel_joint
    rear_right_wheel_command_joint_name: rear_right_wheel_joint
"""
KNUCKLE = """<link name="{name}"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/></inertial></link>
<joint name="{name}_steer" type="revolute"><parent link="base"/><child link="{name}"/>
<origin xyz="0.1 {y} 0"/><axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5"/></joint>"""


def _plugin(file: str, inside: str = "") -> str:
    return f"<gazebo><plugin filename='{file}' name='p'>{inside}</plugin></gazebo>"


@pytest.mark.parametrize(
    ("file", "inside", "said"),
    [
        ("gz-sim-mecanum-drive-system", FOUR_JOINTS, "mecanum wheels: .* not move sideways"),
        ("libgazebo_ros_planar_move.so", "", "moves in the plane: .* not move sideways"),
        ("gz-sim-velocity-control-system", "", "moves in the plane: .* not move sideways"),
        ("libgazebo_ros_omni_drive.so", "", "omni wheels: .* not move sideways"),
        ("gz-sim-ackermann-steering-system", FOUR_JOINTS, "steering does not turn"),
        ("libgazebo_ros_ackermann_drive.so", FOUR_JOINTS, "steering does not turn"),
        ("gz_ros2_control-system", "<parameters>mecanum.yaml</parameters>", "mecanum wheels"),
        ("gz-sim-diff-drive-system", SIDES, ""),
    ],
)
def test_drive_that_is_simulated_as_another_says_so(
    tmp_path: Path, file: str, inside: str, said: str
) -> None:
    (tmp_path / "mecanum.yaml").write_text(PARAMETERS, encoding="utf-8")
    path = _robot(tmp_path, FOUR + _plugin(file, inside))
    robot = load_robot(path, SearchPath())
    assert set(robot.drive.left) == set(LEFT)
    told = [note for note in texts(robot.notes) if "sides; it" in note or "steering does" in note]
    assert len(told) == (1 if said else 0)
    if said:
        assert re.search(said, told[0])
    last = run(simulator(robot=path), 1.5, Velocity(0.3, 0.0))
    assert last.truth.v == pytest.approx(0.3, rel=0.1)


def test_guess_says_that_wheels_are_mecanum_ones(tmp_path: Path) -> None:
    wheels = FOUR.replace("_wheel", "_mecanum_wheel")
    robot = load_robot(_robot(tmp_path, wheels), SearchPath())
    assert any("has mecanum wheels" in note for note in texts(robot.notes))


def test_guess_says_that_wheels_are_steered(tmp_path: Path) -> None:
    text = FOUR
    for side, y in (("left", 0.13), ("right", -0.13)):
        wheel, knuckle = f"front_{side}_wheel", f"{side}_knuckle"
        on_base = f'<parent link="base"/><child link="{wheel}"/>\n<origin xyz="0.1 {y} 0"'
        assert on_base in text
        on_it = f'<parent link="{knuckle}"/><child link="{wheel}"/>\n<origin xyz="0 0 0"'
        text = text.replace(on_base, on_it)
        text += KNUCKLE.format(name=knuckle, y=y)
    robot = load_robot(_robot(tmp_path, text), SearchPath())
    assert any("steering does not turn" in note for note in texts(robot.notes))
