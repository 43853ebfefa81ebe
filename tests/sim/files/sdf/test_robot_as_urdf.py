"""An SDF robot's links, joints and tags as URDF tells them, element by element."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pytest
from defusedxml.ElementTree import fromstring

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.robot_as_urdf import robot_as_urdf
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Urdf
from tests.sim.builders import texts

BALL = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
SOLID = f"<collision name='c'><pose>0 0 0.5 0 0 0</pose>{BALL}</collision>"
MU = "<surface><friction><ode><mu>{}</mu></ode></friction></surface>"
AXIS = "<axis><xyz>0 0 1</xyz>{}</axis>"


def link(name: str, inside: str = "", pose: str = "") -> str:
    told = f"<pose>{pose}</pose>" if pose else ""
    return f"<link name='{name}'>{told}{inside}</link>"


def joint(
    name: str, parent: str, child: str, kind: str = "fixed", inside: str = "", pose: str = ""
) -> str:
    told = f"<pose>{pose}</pose>" if pose else ""
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='{name}' type='{kind}'>{told}{ends}{inside}</joint>"


def xml_of(*inside: str) -> XmlFile:
    text = f"<sdf version='1.9'><model name='bot'>{''.join(inside)}</model></sdf>"
    return XmlFile(Path("r.sdf"), "sdf", RobotError, text.encode())


def told(*inside: str) -> Element:
    root: Element = fromstring(robot_as_urdf(xml_of(*inside)))
    return root


def one(root: Element, path: str) -> Element:
    found = root.find(path)
    assert found is not None
    return found


def read(*inside: str) -> Urdf:
    text = robot_as_urdf(xml_of(*inside))
    return read_urdf(XmlFile(Path("r.urdf"), "robot", RobotError, text))


def turning(
    limits: str = "", kind: str = "revolute", dynamics: str = "", mimic: str = ""
) -> Element:
    """Return the joint `j` of an arm on a base."""
    axis = AXIS.format(limits + dynamics + mimic)
    return one(told(link("base"), link("arm"), joint("j", "base", "arm", kind, axis)), "joint")


@pytest.mark.parametrize(
    ("kind", "limits", "expected"),
    [
        ("revolute", "<limit><lower>-1</lower><upper>2</upper></limit>", ("revolute", -1.0, 2.0)),
        ("revolute", "", ("continuous",)),
        ("revolute", "<limit><lower>-1e6</lower><upper>1e16</upper></limit>", ("continuous",)),
        ("revolute", "<limit><lower>-9e5</lower></limit>", ("revolute", -9e5, 1e6)),
        ("revolute", "<limit><upper>9e5</upper></limit>", ("revolute", -1e6, 9e5)),
        ("continuous", "<limit><lower>-1</lower><upper>2</upper></limit>", ("continuous",)),
        ("revolute", "<limit><velocity>7</velocity></limit>", ("continuous",)),
        ("prismatic", "", ("prismatic", -1e6, 1e6)),
        ("prismatic", "<limit><lower>0</lower><upper>.5</upper></limit>", ("prismatic", 0.0, 0.5)),
    ],
)
def test_limits_say_how_far_a_joint_moves(
    kind: str, limits: str, expected: tuple[object, ...]
) -> None:
    found = turning(limits, kind)
    limit = one(found, "limit")
    bounds = tuple(float(limit.get(key, "")) for key in ("lower", "upper") if key in limit.attrib)
    assert (found.get("type"), *bounds) == expected


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_greatest_speed_of_a_wheels_joint_is_kept(kind: str) -> None:
    given = "<limit><effort>2</effort><velocity>7.5</velocity></limit>"
    assert one(turning(given, kind), "limit").get("velocity") == "7.5"


def test_what_slows_a_joint_is_never_negative() -> None:
    given = "<dynamics><damping>0.5</damping><friction>-2</friction></dynamics>"
    assert one(turning(dynamics=given), "dynamics").attrib == {"damping": "0.5", "friction": "0.0"}
    assert one(turning(), "dynamics").attrib == {"damping": "0.0", "friction": "0.0"}


@pytest.mark.parametrize(
    ("inside", "multiplier", "offset"),
    [
        ("", 1.0, 0.0),
        ("<multiplier>3</multiplier>", 3.0, 0.0),
        ("<multiplier>3</multiplier><offset>0.5</offset>", 3.0, 0.5),
        # SDF: position = multiplier * (other - reference) + offset.
        ("<multiplier>3</multiplier><offset>0.5</offset><reference>0.2</reference>", 3.0, -0.1),
    ],
)
def test_a_joint_follows_another_as_told(inside: str, multiplier: float, offset: float) -> None:
    mimic = one(turning(mimic=f"<mimic joint='k'>{inside}</mimic>"), "mimic")
    assert mimic.get("joint") == "k"
    assert float(mimic.get("multiplier", "")) == multiplier
    assert float(mimic.get("offset", "")) == pytest.approx(offset)


def test_a_link_that_turns_lies_where_its_joint_is_and_its_shapes_stay() -> None:
    arm = link(
        "arm",
        SOLID + "<inertial><pose>0.1 0 0 0 0 0</pose><mass>2</mass></inertial>",
        f"1 2 3 0 0 {math.pi / 2}",
    )
    elbow = joint("j", "base", "arm", "revolute", AXIS.format(""), "0.5 0 0 0 0 0")
    urdf = read(link("base", pose="0 0 1 0 0 0"), arm, elbow)
    # The joint's pose is in its child's frame, a quarter turned: 0.5 m along y from (1, 2, 3).
    assert urdf.T_root("arm").position == pytest.approx((1.0, 2.5, 2.0))
    own = urdf.links["arm"]
    ball = urdf.T_root("arm") @ own.collisions[0].pose
    assert ball.position == pytest.approx((1.0, 2.0, 2.5))
    assert own.inertial is not None
    assert own.inertial.mass == 2.0
    (place,) = urdf.T_root("arm").apply(np.array([own.inertial.center]))
    assert place == pytest.approx((1.0, 2.1, 2.0))


@pytest.mark.parametrize(
    ("frame", "xyz", "in_model"),
    [
        ("", "0 -1 0", (1.0, 0.0, 0.0)),
        (" expressed_in='__model__'", "0 1 0", (0.0, 1.0, 0.0)),
        (" expressed_in='base'", "1 0 0", (0.0, -1.0, 0.0)),
    ],
)
def test_an_axis_is_told_in_any_frame(frame: str, xyz: str, in_model: tuple[float, ...]) -> None:
    """Of an arm that lies a quarter to the left, on a base that lies a quarter to the right."""
    quarter = math.pi / 2
    root = told(
        *(link("base", pose=f"0 0 0 0 0 {-quarter}"), link("arm", pose=f"0 0 0 0 0 {quarter}")),
        joint("j", "base", "arm", "revolute", f"<axis><xyz{frame}>{xyz}</xyz></axis>"),
    )
    found = [float(word) for word in one(root, "joint/axis").get("xyz", "").split()]
    T_arm = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, quarter))
    assert T_arm.rotation() @ found == pytest.approx(in_model, abs=1e-9)


def test_friction_is_that_of_the_first_shape_that_says_one() -> None:
    shapes = "".join(
        f"<collision name='c{i}'>{BALL}{told_mu}</collision>"
        for i, told_mu in enumerate(("", MU.format(0.3), MU.format(0.7)))
    )
    gazebo = one(told(link("base", shapes)), "gazebo")
    assert gazebo.get("reference") == "base"
    assert [tag.text for tag in gazebo.findall("mu1")] == ["0.3"]
    assert told(link("base", SOLID)).find("gazebo") is None


def test_a_sensor_sits_where_its_pose_says_in_the_links_new_frame() -> None:
    eye = "<sensor name='s' type='imu'>{}</sensor>"
    plain = one(told(link("base", eye.format(""), "1 2 3 0 0 0")), "gazebo/sensor")
    assert plain.find("pose") is None
    placed = eye.format("<pose>0.1 0.2 0.3 0 0 0.4</pose>")
    pose = one(told(link("base", placed, "1 2 3 0 0 0")), "gazebo/sensor/pose")
    assert [float(word) for word in (pose.text or "").split()] == pytest.approx(
        (0.1, 0.2, 0.3, 0.0, 0.0, 0.4)
    )
    elbow = joint("j", "base", "arm", "revolute", AXIS.format(""), "0.5 0 0 0 0 0")
    moved = told(link("base"), link("arm", eye.format("")), elbow)
    pose = one(moved, "gazebo/sensor/pose")
    assert [float(word) for word in (pose.text or "").split()] == pytest.approx((-0.5, *[0.0] * 5))


def test_frames_are_fixed_to_what_they_are_attached_to() -> None:
    frame = "<frame name='{}'{}><pose>0 0 {} 0 0 0</pose></frame>"
    inside = (
        *(link("base"), link("arm", pose="1 0 0 0 0 0"), joint("j", "base", "arm")),
        frame.format("free", "", 1),
        frame.format("mast", " attached_to='arm'", 2),
        frame.format("top", " attached_to='mast'", 3),
    )
    urdf = read(*inside)
    parents = {name: urdf.joints[f"{name}_frame"].parent for name in ("free", "mast", "top")}
    assert parents == {"free": "base", "mast": "arm", "top": "mast"}
    heights = {name: urdf.T_root(name).position for name in parents}
    assert heights == {"free": (0, 0, 1), "mast": (1, 0, 2), "top": (1, 0, 5)}


def test_nested_models_prefix_their_names_unless_they_are_merged() -> None:
    inner = "<model name='in'{}><pose>0 0 1 0 0 0</pose>{}{}</model>"
    parts = link("a", pose="0 1 0 0 0 0"), joint("ab", "a", "b") + link("b")
    urdf = read(link("base"), inner.format("", *parts), joint("j", "base", "in::a"))
    assert list(urdf.links) == ["base", "in/a", "in/b"]
    assert set(urdf.joints) == {"in/ab", "j"}
    assert urdf.T_root("in/a").position == pytest.approx((0.0, 1.0, 1.0))


def test_plugins_name_joints_as_the_robot_does() -> None:
    plugin = "<plugin name='p' filename='f'><joint> j </joint><topic>j2</topic></plugin>"
    inner = f"<model name='in'>{link('a')}{link('b')}{joint('j', 'a', 'b')}{plugin}</model>"
    found = one(told(inner), "gazebo/plugin")
    assert one(found, "joint").text == "in/j"
    assert one(found, "topic").text == "j2"


def test_what_no_joint_carries_is_fixed_to_what_carries_most() -> None:
    lone, chain = link("lone"), link("base") + link("a") + link("b")
    joints = joint("j", "base", "a") + joint("k", "a", "b")
    xml = xml_of(lone, chain, joints)
    root = fromstring(robot_as_urdf(xml))
    tied = one(root, "joint[@name='lone_fixed']")
    assert (one(tied, "parent").get("link"), one(tied, "child").get("link")) == ("base", "lone")
    assert "link 'lone': no joint carries it: it is fixed to 'base'" in texts(xml.notes)
    assert len(root.findall("joint")) == 3
    held = read(lone, chain, joints, joint("w", "world", "lone"))
    assert held.root == "world"
    assert held.joints["base_fixed"].parent == "world"


def test_what_urdf_has_not_is_held_or_left_out_and_said() -> None:
    three = "".join(link(name) for name in "abc")
    joints = joint("ab", "a", "b", "ball") + joint("bc", "b", "c", "fixed")
    xml = xml_of(three, joints, joint("ca", "a", "c"))
    root = fromstring(robot_as_urdf(xml))
    assert [one(root, f"joint[@name='{name}']").get("type") for name in ("ab", "bc")] == [
        *("fixed", "fixed")
    ]
    assert root.find("joint[@name='ca']") is None
    assert [(note.kind, note.text) for note in xml.notes] == [
        (NoteKind.UNSUPPORTED, "joint 'ab': type 'ball' is held fast"),
        (NoteKind.UNSUPPORTED, "joint 'ca': closes a loop of links, so it is left out"),
    ]


def test_what_has_no_mass_tells_none() -> None:
    bare = told(link("base", "<inertial><pose>1 0 0 0 0 0</pose></inertial>"))
    assert bare.find("link/inertial") is None
    assert told(link("base")).find("link/inertial") is None


def test_shapes_are_told_with_their_sizes_and_colours() -> None:
    shapes = (
        "<box><size>1 2 3</size></box>",
        "<cylinder><radius>0.1</radius><length>0.2</length></cylinder>",
        "<capsule><radius>0.1</radius><length>0.2</length></capsule>",
        "<sphere><radius> 0.3 </radius></sphere>",
        "<mesh><uri> none.stl </uri><scale>1 2 3</scale></mesh>",
        "<mesh><uri>none.stl</uri></mesh>",
    )
    red = "<material><diffuse>1 0 0 1</diffuse></material>"
    for tag, extra in (("collision", ""), ("visual", red)):
        part = "<{0} name='p{1}'><geometry>{2}</geometry>{3}</{0}>"
        inside = (part.format(tag, i, shape, extra) for i, shape in enumerate(shapes))
        root = told(link("base", "".join(inside)))
        found = [geometry[0] for geometry in root.iter("geometry")]
        assert [(shape.tag, shape.attrib) for shape in found] == [
            ("box", {"size": "1 2 3"}),
            ("cylinder", {"radius": "0.1", "length": "0.2"}),
            ("capsule", {"radius": "0.1", "length": "0.2"}),
            ("sphere", {"radius": "0.3"}),
            ("mesh", {"filename": "none.stl", "scale": "1 2 3"}),
            ("mesh", {"filename": "none.stl", "scale": "1 1 1"}),
        ]
        assert [each.get("name") for each in root.findall(f"link/{tag}")] == [
            f"p{i}" for i in range(len(shapes))
        ]
        colours = [colour.get("rgba") for colour in root.iter("color")]
        assert colours == (["1.0 0.0 0.0 1.0"] * len(shapes) if tag == "visual" else [])


def test_shapes_that_urdf_has_not_are_noted_but_empty_ones() -> None:
    geometries = ("<empty/>", "", "<plane/>")
    xml = xml_of(
        link("base", "".join(f"<visual><geometry>{g}</geometry></visual>" for g in geometries))
    )
    assert one(fromstring(robot_as_urdf(xml)), "link").find("visual") is None
    assert [(note.kind, note.text) for note in xml.notes] == [
        (NoteKind.UNSUPPORTED, "link 'base' visual: an empty <geometry> is left out of a robot"),
        (NoteKind.UNSUPPORTED, "link 'base' visual: <plane> is left out of a robot"),
    ]


def test_an_inertia_is_told_number_by_number_zero_where_it_says_none() -> None:
    tensor = "<inertia><ixx> 1 </ixx><iyy>2</iyy><izz>2.5</izz><ixz>0.1</ixz></inertia>"
    root = told(link("base", f"<inertial><mass> 3 </mass>{tensor}</inertial>"))
    assert one(root, "link/inertial/mass").get("value") == "3"
    assert one(root, "link/inertial/inertia").attrib == {
        "ixx": "1",
        "iyy": "2",
        "izz": "2.5",
        "ixy": "0",
        "ixz": "0.1",
        "iyz": "0",
    }
