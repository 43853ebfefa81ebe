"""URDF tags of links, joints and Gazebo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.check import check
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import Inertial
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Joint, Mimic
from tests.sim.builders import texts
from tests.sim.files.test_robots import TWO, _load, _robot

pytestmark = pytest.mark.usefixtures("without_sills")

LINK = """<robot name="r"><link name="base_link"><inertial>{inside}</inertial><collision>
<geometry><box size="1.0 2.0 3.0"/></geometry></collision></link></robot>"""
MASS = "<mass value='{}'/>"
TENSOR = "<inertia ixx='{}' iyy='{}' izz='{}' ixy='{}' ixz='0' iyz='0'/>"
BOX = np.array([13.0, 10.0, 5.0]) / 12.0 * 6.0  # of 6 kg


def read(folder: Path, inside: str) -> tuple[Inertial, str]:
    """Return the link's mass properties and what is noted of them."""
    path = folder / "r.urdf"
    path.write_text(LINK.format(inside=inside), encoding="utf-8")
    robot = load_robot(path)
    found = robot.urdf.links["base_link"].inertial
    assert found is not None
    return found, " ".join(text for text in texts(robot.notes) if "inerti" in text)


@pytest.mark.parametrize("tensor", [(1.0, 2.0, 2.5, 0.0), (1.0, 2.0, 2.5, 0.3), (1, 1, 3.9, 0)])
def test_a_possible_inertia_is_taken(tmp_path: Path, tensor: tuple[float, ...]) -> None:
    found, noted = read(tmp_path, MASS.format(6.0) + TENSOR.format(*tensor))
    xx, yy, zz, xy = tensor
    assert (found.mass, noted) == (6.0, "")
    np.testing.assert_allclose(found.inertia, [[xx, xy, 0], [xy, yy, 0], [0, 0, zz]])


def test_it_is_turned_and_placed_by_its_origin(tmp_path: Path) -> None:
    origin = "<origin xyz='0.1 0.2 0.3' rpy='0 0 1.5707963267948966'/>"
    found, _ = read(tmp_path, origin + MASS.format(6.0) + TENSOR.format(1.0, 2.0, 2.5, 0.0))
    assert found.center == pytest.approx((0.1, 0.2, 0.3))
    np.testing.assert_allclose(found.inertia, np.diag([2.0, 1.0, 2.5]), atol=1e-12)


@pytest.mark.parametrize(
    ("tensor", "problem"),
    [
        ("", "lacks <inertia>"),
        (TENSOR.format(1, 1, 4.1, 0), "the inertia's largest axis is more than the sum of the"),
        (TENSOR.format(1, 1, 1, 1.5), "the inertia is not positive definite"),
        (TENSOR.format(0, 0, 0, 0), "the inertia is not positive definite"),
        (TENSOR.format(1e13, 1e13, 1e13, 0), "the inertia is beyond all bounds"),
    ],
)
def test_an_impossible_inertia_is_computed(tmp_path: Path, tensor: str, problem: str) -> None:
    found, noted = read(tmp_path, MASS.format(6.0) + tensor)
    assert f"{problem}" in noted
    assert "so it is computed from its shapes of 6 kg" in noted
    np.testing.assert_allclose(found.inertia, np.diag(BOX), rtol=1e-6)


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        ("", "mass"),
        (MASS.format(" "), "<mass> lacks the attribute 'value'"),
        (MASS.format(-1), "weighs -1 kg; valid: 0 to 1e\\+07 kg"),
        (MASS.format(2e7), "weighs 2e\\+07 kg"),
        (MASS.format("heavy"), "heavy"),
    ],
)
def test_an_invalid_mass_is_refused(tmp_path: Path, inside: str, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        read(tmp_path, inside + TENSOR.format(1, 1, 1, 0))


def read_1(*joints: tuple[str, str, str]) -> tuple[dict[str, Joint], XmlFile]:
    """Return joints from a base to a link each, of a name, a kind and further tags."""
    given = "".join(
        f"<link name='{name}_link'/><joint name='{name}' type='{kind}'><parent link='base'/>"
        f"<child link='{name}_link'/><limit lower='-1' upper='1'/>{more}</joint>"
        for name, kind, more in joints
    )
    text = f"<robot name='r'><link name='base'/>{given}</robot>".encode()
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text)
    return read_urdf(xml).joints, xml


def after(name: str, more: str = "") -> str:
    return f"<mimic joint='{name}' {more}/>"


def test_a_joint_follows_another_by_a_factor_and_an_offset() -> None:
    given = after("a", "multiplier='-2' offset='0.5'")
    joints, xml = read_1(
        ("a", "revolute", ""), ("b", "prismatic", given), ("c", "revolute", after("b"))
    )
    assert joints["a"].mimic is None
    assert joints["b"].mimic == Mimic("a", -2.0, 0.5)
    assert joints["c"].mimic == Mimic("b", 1.0, 0.0)
    assert not xml.notes


@pytest.mark.parametrize(
    ("leader", "follower"), [("fixed", "revolute"), ("revolute", "planar"), ("planar", "revolute")]
)
def test_only_joints_of_one_position_follow_each_other(leader: str, follower: str) -> None:
    with pytest.raises(RobotError, match=r"joint 'b' mimic.*only joints with one position"):
        read_1(("a", leader, ""), ("b", follower, after("a")))


def test_joints_do_not_follow_each_other_in_a_circle() -> None:
    with pytest.raises(RobotError, match="joints follow each other in a circle"):
        read_1(("a", "revolute", after("b")), ("b", "revolute", after("a")))
    with pytest.raises(RobotError, match="joints follow each other in a circle"):
        read_1(("a", "revolute", after("a")))


def test_a_joint_whose_leader_is_not_there_moves_freely() -> None:
    joints, xml = read_1(("a", "revolute", ""), ("b", "revolute", after("aa")))
    assert joints["b"].mimic is None
    (note,) = xml.notes
    assert note.kind is NoteKind.MISSING
    assert note.text.startswith("joint 'b' mimic: joint 'aa' does not exist; ")
    assert note.text.endswith("; it moves freely")


def test_a_visuals_own_colour_may_be_none() -> None:
    """As in urdfdom, which refuses a robot for a shared one alone."""
    colour = "<material name='m'><color rgba='0 0 0.5'/></material>"
    visual = f"<visual><geometry><sphere radius='1'/></geometry>{colour}</visual>"
    text = "<robot name='r'>{}<link name='a'>" + visual + "</link></robot>"
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text.format("").encode())
    read_urdf(xml)
    assert [note.text for note in xml.notes] == [
        "material 'm': has 3 numbers ('0 0 0.5'); valid: 4; it is left out"
    ]
    with pytest.raises(RobotError, match="has 3 numbers"):
        read_urdf(XmlFile(Path("r.urdf"), "robot", RobotError, text.format(colour).encode()))


def test_tags_that_no_urdf_has_are_named_once_with_where_they_belong() -> None:
    shape = "<geometry><sphere radius='1'/></geometry><material name='m'/>"
    touched = f"<collision>{shape}<surface><friction/></surface></collision>"
    seen = f"<visual>{shape}<origin/></visual><inertial><mass value='0'/></inertial>"
    links = f"<link name='a'>{touched}{seen}</link><link name='b'>{touched}<pose>0</pose></link>"
    joint = "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"
    text = f"<robot name='r'>{links}{joint}</robot>".encode()
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text)
    read_urdf(xml)
    gone = "no tag of a URDF, and left out, as Gazebo does;"
    assert texts(xml.notes)[:2] == (
        f"link <collision><surface> (at a, b): {gone} <gazebo reference='a'> holds Gazebo's",
        f"link <pose> (at b): {gone} the <origin> of a link's joint places it",
    )


_LIDAR = """<plugin name="lidar" filename="libgazebo_ros_ray_sensor.so">
<ros><remapping>~/out:=scan</remapping></ros><output_type>sensor_msgs/LaserScan</output_type>
<frame_name>{}</frame_name></plugin>"""


@pytest.mark.parametrize(
    ("file", "type_"),
    [
        ("libgazebo_ros_ray_sensor.so", "ray"),
        ("libgazebo_ros_laser.so", "ray"),
        ("libgazebo_ros_gpu_laser.so", "gpu_ray"),
        ("libgazebo_ros_camera.so", "camera"),
        ("libgazebo_ros_openni_kinect.so", "depth"),
        ("libgazebo_ros_imu_sensor.so", "imu"),
    ],
)
@pytest.mark.parametrize(("frame", "link"), [("left_wheel", "left_wheel"), ("laser_link", "LINK")])
def test_a_sensors_plugin_outside_it_says_where_it_goes(
    tmp_path: Path, file: str, type_: str, frame: str, link: str
) -> None:
    plugin = _LIDAR.format(frame).replace("libgazebo_ros_ray_sensor.so", file)
    robot = _load(tmp_path, f"{TWO}<gazebo>{plugin}</gazebo>")
    assert robot.settings.sensors == ()
    (said,) = [note for note in texts(robot.notes) if "plugin 'lidar'" in note]
    assert "stands outside <sensor>" in said
    assert f'<gazebo reference="{link}"><sensor type="{type_}" name="NAME">' in said


def test_a_ray_outside_a_sensor_says_where_it_goes_in_the_check_too(tmp_path: Path) -> None:
    ray = "<ray><scan><horizontal><samples>360</samples></horizontal></scan></ray>"
    inside = f"{TWO}<gazebo reference='ball'>{ray}{_LIDAR.format('ball')}</gazebo>"
    found = check(_robot(tmp_path, inside), SearchPath(), {})
    remedy = 'put it into <gazebo reference="ball"><sensor type="ray" name="NAME">'
    assert sum(remedy in note for note in texts(found.notes)) == 2


def test_inside_a_sensor_nothing_is_said(tmp_path: Path) -> None:
    sensor = f"<sensor type='ray' name='s'>{_LIDAR.format('ball')}</sensor>"
    robot = _load(tmp_path, f"{TWO}<gazebo reference='ball'>{sensor}</gazebo>")
    assert robot.settings.first(LidarSettings) is not None
    assert not any("outside" in note for note in texts(robot.notes))
