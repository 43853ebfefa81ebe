"""When a robot that its file lays down or turns aside is given a root that stands, and which."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.stand_up import stand_up, without_frames
from arjuna_sim.files.urdf.gazebo import read_tags
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.urdf import Urdf
from tests.sim.builders import texts

QUARTER = math.pi / 2


def wheel(name: str, xyz: str, turn: float = 0.0, radius: float = 0.1) -> str:
    """Return a wheel on the base, whose axis lies along y but for a turn about z."""
    disc = f"<geometry><cylinder radius='{radius}' length='0.02'/></geometry>"
    lying = f"<origin rpy='{-QUARTER} 0 0'/>"
    return (
        f"<link name='{name}'><collision>{lying}{disc}</collision></link>"
        f"<joint name='{name}' type='continuous'><parent link='base'/><child link='{name}'/>"
        f"<origin xyz='{xyz}' rpy='0 0 {turn}'/><axis xyz='0 1 0'/></joint>"
    )


def box(name: str, xyz: str, mass: float = 0.0, size: str = "0.02 0.02 0.02") -> str:
    """Return a box fixed to the base."""
    weight = f"<inertial><mass value='{mass}'/><inertia ixx='1' iyy='1' izz='1'/></inertial>"
    return (
        f"<link name='{name}'>{weight * (mass > 0.0)}<collision><geometry><box size='{size}'/>"
        f"</geometry></collision></link><joint name='{name}' type='fixed'><parent link='base'/>"
        f"<child link='{name}'/><origin xyz='{xyz}'/></joint>"
    )


def stood(inside: str, rpy: str = "0 0 0", more: str = "") -> tuple[Urdf, Urdf, XmlFile]:
    """Return a robot whose file turns it, before and after, and the file."""
    text = (
        "<robot name='r'><link name='cad'/><link name='base'/><joint name='turn' type='fixed'>"
        f"<parent link='cad'/><child link='base'/><origin rpy='{rpy}'/></joint>{inside}{more}"
        "</robot>"
    )
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text.encode())
    lying = read_urdf(xml)
    return lying, stand_up(xml, lying, read_tags(xml, lying)), xml


PLATE = box("plate", "0 0 0", size="0.5 0.02 0.02")  # too long to stand on end
PAIR = wheel("left_wheel", "0 0.2 0") + wheel("right_wheel", "0 -0.2 0")


def test_a_robot_that_stands_is_left_as_it_is() -> None:
    lying, up, xml = stood(PAIR)
    assert up is lying
    assert not xml.notes


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("degrees", "turned"), [(59.0, False), (61.0, True), (90.0, True)])
def test_beyond_sixty_degrees_it_looks_aside(degrees: float, sign: float, turned: bool) -> None:
    _, up, _ = stood(PAIR, f"0 0 {sign * math.radians(degrees)}")
    assert (up.root == "base_footprint") is turned
    if turned:
        np.testing.assert_allclose(up.T_root("base").rotation(), np.eye(3), atol=1e-8)


@pytest.mark.parametrize(("degrees", "turned"), [(25.0, True), (26.5, False)])
def test_wheels_that_do_not_turn_across_count_for_nothing(degrees: float, turned: bool) -> None:
    askew = math.radians(degrees)  # cosine 0.906 and 0.895
    wheels = wheel("left_wheel", "0 0.2 0", askew) + wheel("right_wheel", "0 -0.2 0", askew)
    named = "<gazebo><plugin name='p' filename='f'><left_joint>left_wheel</left_joint>"
    named += "<right_joint>right_wheel</right_joint></plugin></gazebo>"
    lying, up, _ = stood(wheels, f"0 0 {QUARTER}", named)
    assert (up is not lying) is turned


def test_sides_that_a_plugin_names_are_believed_if_it_names_both() -> None:
    plugin = "<gazebo><plugin name='p' filename='f'><left_joint>{}</left_joint>"
    plugin += "<right_joint>{}</right_joint></plugin></gazebo>"
    rpy = f"0 0 {QUARTER}"
    _, ahead, _ = stood(PAIR, rpy, plugin.format("left_wheel", "right_wheel"))
    np.testing.assert_allclose(ahead.T_root("base").rotation(), np.eye(3), atol=1e-8)
    _, back, _ = stood(PAIR, rpy, plugin.format("right_wheel", "left_wheel"))
    np.testing.assert_allclose(back.T_root("base").rotation(), np.diag([-1, -1, 1]), atol=1e-8)
    for one in (("left_wheel", "none"), ("none", "left_wheel"), ("", "left_wheel")):
        _, guessed, _ = stood(PAIR, rpy, plugin.format(*one))
        np.testing.assert_allclose(guessed.T_root("base").rotation(), np.eye(3), atol=1e-8)


def test_several_wheels_a_side_are_taken_together() -> None:
    wheels = "".join(
        wheel(f"{end}_{side}_wheel", f"{x} {y} 0")
        for (end, x), (side, y) in itertools.product(
            (("front", 0.3), ("rear", -0.3)), (("left", 0.2), ("right", -0.2))
        )
    )
    _, up, _ = stood(wheels, f"0 0 {-QUARTER}")
    np.testing.assert_allclose(up.T_root("base").rotation(), np.eye(3), atol=1e-8)
    lying, same, _ = stood(wheels, "0 0 0.5")
    assert same is lying


@pytest.mark.parametrize(
    "rpy", [(QUARTER, 0.0, 0.0), (-QUARTER, 0.0, 0.0), (QUARTER, 0.0, QUARTER)]
)
def test_a_robot_on_its_side_stands_on_its_wheels(rpy: tuple[float, ...]) -> None:
    """A mast above its wheels would reach lower than they do if it stood on its head."""
    mast = box("mast", "0 0 0.3", 0.1, "0.02 0.02 0.6")
    _, up, _ = stood(PAIR + PLATE + mast, " ".join(map(str, rpy)))
    np.testing.assert_allclose(up.T_root("base").rotation(), np.eye(3), atol=1e-8)


def test_it_stands_where_its_weight_is_lowest() -> None:
    for z, head in ((-0.05, 1.0), (0.05, -1.0)):
        _, up, _ = stood(PAIR + box("iron", f"0 0 {z}", 5.0), f"{QUARTER} 0 0")
        assert up.T_root("base").rotation()[2, 2] == pytest.approx(head)


def test_weight_that_decides_nothing_leaves_y_up() -> None:
    for z in (0.002, -0.002):  # half a centimetre is what files' rounding may do
        _, up, _ = stood(PAIR + box("iron", f"0 0 {z}", 5.0), f"{QUARTER} 0 0")
        # The root's y is the base's -z here.
        np.testing.assert_allclose(up.T_root("cad").rotation()[2], (0, 1, 0), atol=1e-7)


def test_what_reaches_as_low_as_the_wheels_may_be_a_skid() -> None:
    iron = box("iron", "0 0 0.06", 5.0)  # lowest head down
    for z, head in ((0.094, -1.0), (0.098, 1.0)):  # with its half height, 4 and 8 mm below
        _, up, _ = stood(PAIR + PLATE + iron + box("skid", f"0 0 {z}"), f"{QUARTER} 0 0")
        assert up.T_root("base").rotation()[2, 2] == pytest.approx(head), z


def test_the_new_root_has_a_name_that_is_free() -> None:
    rpy = f"0 0 {QUARTER}"
    taken = box("base_footprint", "0 0 0.1")
    assert stood(PAIR + taken, rpy)[1].root == "base_upright"
    taken += box("base_upright", "0 0 0.1")
    assert stood(PAIR + taken, rpy)[1].root == "base_standing"
    lying, up, xml = stood(PAIR + taken + box("base_standing", "0 0 0.1"), rpy)
    assert up is lying
    assert not xml.notes


@pytest.mark.parametrize(
    "rpy", [(0.0, 0.0, 1.5), (1.4, 0.0, 0.0), (0.3, -0.2, 1.4), (1.3, 0.2, -2.0), (0.0, 0.0, -1.3)]
)
def test_the_note_and_the_file_say_how_it_is_turned(rpy: tuple[float, ...]) -> None:
    lying, up, xml = stood(PAIR, " ".join(map(str, rpy)))
    (note,) = texts(xml.notes)
    words = "its wheels do not turn across: the new root 'base_footprint' carries it turned by "
    assert note.startswith(words)
    angles = tuple(map(float, note.removeprefix(words).split()))
    turn = Pose3.from_rpy((0.0, 0.0, 0.0), angles).rotation()
    np.testing.assert_allclose(up.T_root("cad").rotation(), turn, atol=1e-8)
    np.testing.assert_allclose(
        up.T_root("base").rotation()[:, 1], (0.0, 1.0, 0.0), atol=1e-8, err_msg="across"
    )
    written = read_urdf(XmlFile(xml.path, "robot", RobotError, up.text.encode()))
    assert (written.root, written.links, written.joints) == (up.root, up.links, up.joints)
    assert up.T_root("base").rotation() == pytest.approx(turn @ lying.T_root("base").rotation())


def within(frames: str, base: str = "", kind: str = "fixed") -> tuple[Urdf, XmlFile]:
    """Return a robot below frames, each fixed to the one before, without those it moves in."""
    names = [*frames.split(), "base"]
    links = "".join(f"<link name='{name}'>{base * (name == 'base')}</link>" for name in names)
    joints = "".join(
        f"<joint name='{child}_joint' type='{kind}'><parent link='{parent}'/>"
        f"<child link='{child}'/><origin xyz='0 0 1'/><axis xyz='0 0 1'/></joint>"
        for parent, child in itertools.pairwise(names)
    )
    drive = (
        "<gazebo><plugin name='p' filename='f'><odometryFrame>o</odometryFrame></plugin></gazebo>"
    )
    text = f"<robot name='r'>{links}{joints}{PAIR}{drive}</robot>"
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text.encode())
    urdf = read_urdf(xml)
    return without_frames(xml, urdf, read_tags(xml, urdf)), xml


@pytest.mark.parametrize("frames", ["odom", "map odom", "o", ""])
def test_frames_that_a_robot_moves_in_are_no_part_of_it(frames: str) -> None:
    urdf, xml = within(frames)
    assert urdf.root == "base"
    assert sorted(urdf.links) == ["base", "left_wheel", "right_wheel"]
    assert [joint.parent for joint in urdf.joints.values()] == ["base", "base"]
    assert [name for name in ("map", "odom", "base_joint") if f'"{name}"' in urdf.text] == []
    assert len(texts(xml.notes)) == len(frames.split())


@pytest.mark.parametrize(
    ("frames", "kind"), [("world", "fixed"), ("stand", "fixed"), ("odom", "continuous")]
)
def test_other_roots_stay(frames: str, kind: str) -> None:
    urdf, xml = within(frames, kind=kind)
    assert urdf.root == frames
    assert not xml.notes
