"""Robot and world files: faults that are refused, and those that are only noted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError, WorldError
from arjuna_core.se2 import IDENTITY
from arjuna_core.twist import Velocity
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import is_file
from arjuna_sim.files.world_file import load_world
from tests.sim.builders import ROBOT, ROOM, edited, run, simulator, texts

PLAIN = """<robot name="plain">
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.02"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.05"/></geometry></collision>
  </link>
</robot>"""


def test_shipped_robot_says_what_it_is() -> None:
    robot = load_robot(ROBOT)
    assert robot.notes == ()
    assert robot.urdf.root == "base_footprint"
    assert robot.drive.left == ("front_left_joint", "rear_left_joint")
    assert (robot.drive.separation, robot.drive.radius) == (0.34, 0.05)
    lidar = robot.settings.first(LidarSettings)
    assert lidar is not None
    assert (lidar.samples, lidar.range_max, lidar.rate, lidar.noise) == (360, 12.0, 10.0, 0.01)
    assert lidar.angle_max == pytest.approx(np.pi)
    assert robot.urdf.T_root("lidar_link").position == pytest.approx((0.0, 0.0, 0.28))


def test_a_name_too_long_for_the_disk_is_no_file() -> None:
    assert is_file(ROBOT)
    assert not is_file(Path("x" * 5000))


def test_shipped_world_has_the_guides_walls_and_boxes() -> None:
    world = load_world(ROOM)
    assert world.notes == ()
    solid = {b.model: b.part for b in world.bodies if b.collides and b.model != "ground_plane"}
    assert sorted(solid) == sorted(
        [f"wall_{side}" for side in ("north", "south", "east", "west")]
        + [f"obstacle_{colour}" for colour in ("red", "green", "blue", "yellow")]
    )
    assert solid["obstacle_yellow"].pose.position == (3.0, -3.0, 0.3)


def test_files_that_are_missing_or_hold_no_robot_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=r"none\.urdf: cannot be read: No such file"):
        load_robot(tmp_path / "none.urdf")
    with pytest.raises(RobotError, match="is a world in which no model has a drive"):
        load_robot(ROOM)
    with pytest.raises(WorldError, match="No such file"):
        load_world(tmp_path / "none.world")


def test_macros_are_expanded_to_the_shipped_urdf() -> None:
    pytest.importorskip("xacro")
    expanded = load_robot(ROBOT.with_suffix(".urdf.xacro"))
    shipped = load_robot(ROBOT)
    assert expanded.settings == shipped.settings
    assert expanded.drive == shipped.drive
    assert expanded.urdf.joints == shipped.urdf.joints
    assert {n: link.collisions for n, link in expanded.urdf.links.items()} == {
        n: link.collisions for n, link in shipped.urdf.links.items()
    }


def test_robot_without_wheels_loads_and_stands_still(tmp_path: Path) -> None:
    path = tmp_path / "plain.urdf"
    path.write_text(PLAIN, encoding="utf-8")
    sim = simulator(robot=path)
    assert sim.robot.model.drive.wheels == ()
    assert any("has no drive" in note for note in sim.notes)
    last = run(sim, 1.0, Velocity(0.5, yaw_rate=0.5))
    assert last.truth.pose.distance(IDENTITY) < 1e-3
    assert last.odometry.T_odom_base.distance(IDENTITY) == 0.0


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
def test_a_small_fault_is_noted(tmp_path: Path, old: str, new: str, note: str) -> None:
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
