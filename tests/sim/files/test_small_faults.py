"""Faults that Gazebo loads a robot in spite of: here too, with a note that names each."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_sim.devices.drive import Velocity
from arjuna_sim.files.urdf.robot_file import load_robot
from tests.sim.builders import ROBOT, edited, run, simulator, texts

BODY, MESH = '<box size="0.45 0.30 0.10"/>', '<mesh filename="missing.stl"/>'
SENSOR = '<link name="imu_link"/>'
INERTIA = '<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/>'
LIGHT = '<inertial><mass value="{}"/>' + INERTIA.format("1e-5") + "</inertial>"
BALL = '<{0}><geometry><sphere radius="0"/></geometry></{0}>'
NOTHING = "<visual><geometry/></visual>"
FOLLOWER = """<link name="arm"/><joint name="arm_joint" type="continuous">
<parent link="base_link"/><child link="arm"/><mimic joint="none_joint"/></joint>"""


def sensor_with(tags: str) -> str:
    return SENSOR.replace("/>", f">{tags}</link>")


@pytest.mark.parametrize(
    ("old", "new", "note"),
    [
        (SENSOR, sensor_with(LIGHT.format("0")), "link 'imu_link' inertial: mass 0"),
        (SENSOR, sensor_with(LIGHT.format("1e-9")), "link 'imu_link' inertial: mass 1e-09"),
        (SENSOR, sensor_with(BALL.format("visual")), "visual: a <sphere> of no size is left out"),
        (SENSOR, sensor_with(BALL.format("collision")), "collision: a <sphere> of no size"),
        (
            BODY,
            MESH,
            "link 'base_link' visual: mesh 'missing.stl' does not exist, so it is left out",
        ),
        (SENSOR, sensor_with(NOTHING), "visual: <geometry> must hold one of box"),
        (SENSOR, SENSOR + FOLLOWER, "'arm_joint' mimic: joint 'none_joint' does not exist"),
        (
            'reference="lidar_link"',
            'reference="lidr_link"',
            "reference 'lidr_link' does not exist; did you mean 'lidar_link'",
        ),
        (
            '<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.10" iyz="0" izz="0.15"/>',
            INERTIA.format("1e-20"),
            "link 'base_link' inertial: the inertia is not positive definite",
        ),
        ("<?xml", "\n  <?xml", ""),
    ],
)
def test_a_small_fault_is_noted_and_the_robot_drives(
    tmp_path: Path, old: str, new: str, note: str
) -> None:
    path = edited(ROBOT, tmp_path, old, new)
    notes = texts(load_robot(path).notes)
    assert any(note in text for text in notes) or (not note and not notes)
    last = run(simulator(robot=path), 2.0, Velocity(0.3, 0.0))
    assert last.truth.v == pytest.approx(0.3, rel=0.05)
