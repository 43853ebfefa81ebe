"""Faults that Gazebo loads a robot in spite of: here too, with a note that names each."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import RobotError
from arjuna_core.twist import Velocity
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from tests.sim.builders import ROBOT, ROOM, edited, run, simulator, texts

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
    last = run(simulator(robot=path), 2.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.05)


@pytest.mark.parametrize(
    ("head", "encoding"),
    [
        ("<!-- wheels ---- left and right --->\n", "utf-8"),
        ("<!-- Räder -->\n", "latin-1"),
        ("<!-- Räder -- links --><!---->\n", "cp1252"),
    ],
)
def test_what_gazebos_parser_reads_is_read(tmp_path: Path, head: str, encoding: str) -> None:
    robot, world = tmp_path / "a.urdf", tmp_path / "a.world"
    for path, source in ((robot, ROBOT), (world, ROOM)):
        text = source.read_text(encoding="utf-8")
        first, _, rest = text.partition("\n")
        assert first.startswith("<?xml")
        path.write_bytes(f"<?xml version='1.0'?>\n{head}{rest}".encode(encoding))
    assert load_robot(robot).drive == load_robot(ROBOT).drive
    assert load_world(world).bodies == load_world(ROOM).bodies


def test_an_empty_friction_is_left_out_and_a_fixed_robot_says_so(tmp_path: Path) -> None:
    world = "<link name='world'/><joint name='w' type='fixed'><parent link='world'/>"
    world += "<child link='base_footprint'/></joint><gazebo reference='base_link'><mu1/></gazebo>"
    robot = load_robot(edited(ROBOT, tmp_path, "</robot>", f"{world}</robot>"))
    assert "gazebo 'base_link' mu1: is empty, so it is left out" in texts(robot.notes)
    fixed = "link 'world': fixes it to the world, as in Gazebo: it does not drive"
    assert fixed in texts(robot.notes)


def test_a_broken_file_is_refused_at_its_line_whatever_its_comments(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_text("<robot name='a'>\n<!-- a -- b\n -->\n<link name='l'></robot>", "utf-8")
    with pytest.raises(RobotError, match="line 4: is broken XML"):
        load_robot(path)
    path.write_text("<!--" * 200_000, encoding="utf-8")
    with pytest.raises(RobotError, match="is broken XML"):
        load_robot(path)
