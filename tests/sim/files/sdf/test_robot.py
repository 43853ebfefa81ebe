"""SDF models as robots."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.robot import read_sdf_robot
from arjuna_sim.files.sensor_tag import SensorTag, Tags
from arjuna_sim.files.urdf.gazebo import read_tags
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.urdf.written import urdf_text
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.geometry.shapes import GREY, Kind
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Joint, Urdf
from tests.sim.builders import texts

BALL = "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
SOLID = f"<collision name='c'><pose>0 0 0.5 0 0 0</pose>{BALL}</collision>"
MU = "<surface><friction><ode><mu>{}</mu></ode></friction></surface>"
AXIS = "<axis><xyz>0 0 1</xyz>{}</axis>"


def link(name: str, inside: str = "", pose: str = "") -> str:
    wanted = f"<pose>{pose}</pose>" if pose else ""
    return f"<link name='{name}'>{wanted}{inside}</link>"


def joint(
    name: str, parent: str, child: str, kind: str = "fixed", inside: str = "", pose: str = ""
) -> str:
    wanted = f"<pose>{pose}</pose>" if pose else ""
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='{name}' type='{kind}'>{wanted}{ends}{inside}</joint>"


def xml_of(*inside: str) -> XmlFile:
    text = f"<sdf version='1.9'><model name='bot'>{''.join(inside)}</model></sdf>"
    return XmlFile(Path("r.sdf"), "sdf", RobotError, text.encode())


def read_tagged(*inside: str) -> tuple[Urdf, Tags]:
    return read_sdf_robot(xml_of(*inside))


def read(*inside: str) -> Urdf:
    return read_tagged(*inside)[0]


def turning(limits: str = "", kind: str = "revolute", dynamics: str = "", mimic: str = "") -> Joint:
    """Return the joint `j` of an arm on a base, which may follow the joint `k`."""
    axis = AXIS.format(limits + dynamics + mimic)
    other = joint("k", "base", "hand", "revolute", AXIS.format(""))
    links = link("base"), link("arm"), link("hand")
    return read(*links, joint("j", "base", "arm", kind, axis), other).joints["j"]


@pytest.mark.parametrize(
    ("kind", "limits", "expected"),
    [
        ("revolute", "<limit><lower>-1</lower><upper>2</upper></limit>", ("revolute", -1.0, 2.0)),
        ("revolute", "", ("continuous",)),
        ("revolute", "<limit><lower>-1e6</lower><upper>1e16</upper></limit>", ("continuous",)),
        ("revolute", "<limit><lower>-9e5</lower></limit>", ("continuous",)),
        ("revolute", "<limit><lower>-9</lower><upper>9</upper></limit>", ("revolute", -9.0, 9.0)),
        ("continuous", "<limit><lower>-1</lower><upper>2</upper></limit>", ("continuous",)),
        ("revolute", "<limit><velocity>7</velocity></limit>", ("continuous",)),
        ("prismatic", "", ("prismatic", -1e6, 1e6)),
        ("prismatic", "<limit><lower>0</lower><upper>.5</upper></limit>", ("prismatic", 0.0, 0.5)),
    ],
)
def test_limits_bound_a_joint(kind: str, limits: str, expected: tuple[object, ...]) -> None:
    found = turning(limits, kind)
    assert (found.kind, *(found.limits or ())) == expected


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_greatest_speed_of_a_wheels_joint_is_kept(kind: str) -> None:
    given = "<limit><effort>2</effort><velocity>7.5</velocity></limit>"
    assert turning(given, kind).max_speed == 7.5


def test_what_slows_a_joint_is_never_negative() -> None:
    given = "<dynamics><damping>0.5</damping><friction>-2</friction></dynamics>"
    slow, free = turning(dynamics=given), turning()
    assert (slow.damping, slow.friction, free.damping, free.friction) == (0.5, 0.0, 0.0, 0.0)


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
def test_a_joint_mimics_another(inside: str, multiplier: float, offset: float) -> None:
    mimic = turning(mimic=f"<mimic joint='k'>{inside}</mimic>").mimic
    assert mimic is not None
    assert (mimic.joint, mimic.multiplier) == ("k", multiplier)
    assert mimic.offset == pytest.approx(offset)


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
    (point,) = urdf.T_root("arm").apply(np.array([own.inertial.center]))
    assert point == pytest.approx((1.0, 2.1, 2.0))


@pytest.mark.parametrize(
    ("frame", "xyz", "in_model"),
    [
        ("", "0 -1 0", (1.0, 0.0, 0.0)),
        (" expressed_in='__model__'", "0 1 0", (0.0, 1.0, 0.0)),
        (" expressed_in='base'", "1 0 0", (0.0, -1.0, 0.0)),
    ],
)
def test_an_axis_may_be_in_any_frame(frame: str, xyz: str, in_model: tuple[float, ...]) -> None:
    """Of an arm that lies a quarter to the left, on a base that lies a quarter to the right."""
    quarter = math.pi / 2
    urdf = read(
        *(link("base", pose=f"0 0 0 0 0 {-quarter}"), link("arm", pose=f"0 0 0 0 0 {quarter}")),
        joint("j", "base", "arm", "revolute", f"<axis><xyz{frame}>{xyz}</xyz></axis>"),
    )
    found = urdf.joints["j"].axis
    T_arm = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, quarter))
    assert T_arm.rotation() @ found == pytest.approx(in_model, abs=1e-9)


@pytest.mark.parametrize(
    ("solid", "found"),
    [
        (((0.0, None), (0.0, 0.3), (0.0, 0.7)), {"base": 0.3}),
        (((0.0, 0.3), (-0.2, 0.7)), {"base": 0.7}),
        (((0.0, 0.3), (-0.2, None)), {}),
        (((0.0, None),), {}),
        ((), {}),
    ],
)
def test_friction_is_that_of_the_lowest_shape(
    solid: tuple[tuple[float, float | None], ...], found: dict[str, float]
) -> None:
    """A caster may be a shape of the chassis: it is what touches the ground."""
    shapes = "".join(
        f"<collision name='c{i}'><pose>0 0 {z} 0 0 0</pose>{BALL}"
        f"{'' if mu is None else MU.format(mu)}</collision>"
        for i, (z, mu) in enumerate(solid)
    )
    assert read_tagged(link("base", shapes))[1].friction == found


def test_a_sensor_sits_where_its_pose_says_in_the_links_new_frame() -> None:
    eye = "<sensor name='s' type='imu'>{}</sensor>"

    def pose(*inside: str) -> Pose3:
        (tag,) = read_tagged(*inside)[1].items
        assert isinstance(tag, SensorTag)
        mounted: Pose3 = tag.mount(1.0, "topic")["pose"]
        return mounted

    assert pose(link("base", eye.format(""), "1 2 3 0 0 0")) == ORIGIN
    placed = pose(link("base", eye.format("<pose>0.1 0.2 0.3 0 0 0.4</pose>"), "1 2 3 0 0 0"))
    assert (*placed.position, *placed.rpy()) == pytest.approx((0.1, 0.2, 0.3, 0.0, 0.0, 0.4))
    elbow = joint("j", "base", "arm", "revolute", AXIS.format(""), "0.5 0 0 0 0 0")
    moved = pose(link("base"), link("arm", eye.format("")), elbow)
    assert (*moved.position, *moved.rpy()) == pytest.approx((-0.5, *[0.0] * 5))


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
    control = "<ros2_control><joint name='j'/><joint name='other'/></ros2_control>"
    parts = link("a"), link("b"), joint("j", "a", "b"), plugin, control
    xml = xml_of(f"<model name='in'>{''.join(parts)}</model>")
    (found,) = read_sdf_robot(xml)[1].plugins
    assert [found.findtext(tag) for tag in ("joint", "topic")] == ["in/j", "j2"]
    names = [tag.get("name") for tag in xml.root.iterfind(".//ros2_control/joint")]
    assert names == ["in/j", "other"]


def test_what_no_joint_carries_is_fixed_to_what_carries_most() -> None:
    lone, chain = link("lone"), link("base") + link("a") + link("b")
    joints = joint("j", "base", "a") + joint("k", "a", "b")
    xml = xml_of(lone, chain, joints)
    found, _ = read_sdf_robot(xml)
    tied = found.joints["lone_fixed"]
    assert (tied.parent, tied.child) == ("base", "lone")
    assert "link 'lone': no joint carries it: it is fixed to 'base'" in texts(xml.notes)
    assert len(found.joints) == 3
    held = read(lone, chain, joints, joint("w", "world", "lone"))
    assert held.root == "world"
    assert held.joints["base_fixed"].parent == "world"


def test_what_urdf_has_not_is_held_or_left_out_and_said() -> None:
    three = "".join(link(name) for name in "abc")
    joints = joint("ab", "a", "b", "ball") + joint("bc", "b", "c", "fixed")
    xml = xml_of(three, joints, joint("ca", "a", "c"))
    found, _ = read_sdf_robot(xml)
    assert {name: each.kind for name, each in found.joints.items()} == {
        "ab": "fixed",
        "bc": "fixed",
    }
    assert [(note.kind, note.text) for note in xml.notes] == [
        (NoteKind.UNSUPPORTED, "joint 'ab': type 'ball' is held fast"),
        (NoteKind.UNSUPPORTED, "joint 'ca': closes a loop of links, so it is left out"),
    ]


def test_a_joint_of_what_is_missing_is_left_out_too() -> None:
    eye = "<include><uri>model://eye</uri></include>"
    xml = xml_of(link("base"), eye, joint("neck", "base", "eye::lens"))
    found, _ = read_sdf_robot(xml)
    assert found.links.keys() == {"base", "eye"}
    assert found.joints.keys() == {"eye_frame"}
    assert texts(xml.notes)[-1] == "joint 'neck': is left out, as 'eye/lens' is"
    with pytest.raises(RobotError, match="link 'base/lens' does not exist"):
        read(link("base"), joint("neck", "base", "base::lens"))


def test_what_has_no_mass_has_no_inertial() -> None:
    bare = read(link("base", "<inertial><pose>1 0 0 0 0 0</pose></inertial>"))
    assert bare.links["base"].inertial is None
    assert read(link("base")).links["base"].inertial is None


def test_shapes_keep_their_sizes_and_colours() -> None:
    shapes = (
        "<box><size>1 2 3</size></box>",
        "<cylinder><radius>0.1</radius><length>0.2</length></cylinder>",
        "<capsule><radius>0.1</radius><length>0.2</length></capsule>",
        "<sphere><radius> 0.3 </radius></sphere>",
        "<ellipsoid><radii>1 2 3</radii></ellipsoid>",
    )
    red = "<material><diffuse>1 0 0 1</diffuse></material>"
    for tag, extra in (("collision", ""), ("visual", red)):
        part = "<{0} name='p{1}'><geometry>{2}</geometry>{3}</{0}>"
        inside = (part.format(tag, i, shape, extra) for i, shape in enumerate(shapes))
        base = read(link("base", "".join(inside))).links["base"]
        parts = base.collisions if tag == "collision" else base.visuals
        assert [(each.shape.kind, each.shape.size) for each in parts] == [
            (Kind.BOX, (1.0, 2.0, 3.0)),
            (Kind.CYLINDER, (0.1, 0.2)),
            (Kind.CYLINDER, (0.1, 0.2)),
            (Kind.SPHERE, (0.3,)),
            (Kind.ELLIPSOID, (1.0, 2.0, 3.0)),
        ]
        assert {each.rgba for each in parts} == {(1.0, 0.0, 0.0, 1.0) if extra else GREY}


@pytest.mark.parametrize(
    ("geometry", "kind", "problem"),
    [
        ("<empty/>", NoteKind.IGNORED, "<empty> is left out"),
        ("", NoteKind.BROKEN, "is left out: <geometry> is empty"),
        ("<plane/>", NoteKind.UNSUPPORTED, "<plane> is left out of a robot"),
        ("<box><size>1 0 1</size></box>", NoteKind.BROKEN, "must be above zero"),
        ("<mesh><uri>none.stl</uri></mesh>", NoteKind.MISSING, "'none.stl' does not exist"),
    ],
)
def test_looks_without_effect_are_noted(geometry: str, kind: NoteKind, problem: str) -> None:
    xml = xml_of(link("base", f"<visual><geometry>{geometry}</geometry></visual>"))
    assert read_sdf_robot(xml)[0].links["base"].visuals == ()
    (note,) = xml.notes
    assert note.text.startswith("link 'base' visual")
    assert (note.kind, problem in note.text) == (kind, True)


def test_a_solid_shape_that_is_broken_is_refused() -> None:
    with pytest.raises(RobotError, match=r"link 'base' collision <size>.*must be above zero"):
        read(
            link(
                "base", "<collision><geometry><box><size>1 0 1</size></box></geometry></collision>"
            )
        )


def test_an_inertia_is_zero_where_it_says_none() -> None:
    tensor = "<inertia><ixx> 1 </ixx><iyy>2</iyy><izz>2.5</izz><ixz>0.1</ixz></inertia>"
    own = (
        read(link("base", f"<inertial><mass> 3 </mass>{tensor}</inertial>")).links["base"].inertial
    )
    assert own is not None
    assert own.mass == 3.0
    assert own.inertia.tolist() == [[1.0, 0.0, 0.1], [0.0, 2.0, 0.0], [0.1, 0.0, 2.5]]


def test_its_description_is_a_urdf_of_the_same_robot() -> None:
    mass = "<inertial><mass>3</mass><inertia><ixx>1</ixx><iyy>2</iyy><izz>2</izz></inertia>"
    mass += "</inertial>"
    eye = "<sensor name='s' type='imu'><pose>0.1 0.2 0.3 0 0 0.4</pose></sensor>"
    plugin = "<plugin name='p' filename='f'><topic>t</topic></plugin>"
    limits = "<limit><lower>-1</lower><upper>2</upper><velocity>7</velocity></limit>"
    arm = joint("j", "base", "arm", "revolute", AXIS.format(limits), "0.5 0 0 0 0 0")
    follow = AXIS.format("<mimic joint='j'><multiplier>2</multiplier></mimic>")
    links = link("base", SOLID + mass + eye), link("arm", SOLID), link("hand")
    urdf, tags = read_tagged(*links, arm, joint("k", "arm", "hand", "revolute", follow), plugin)
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, urdf_text(urdf, tags).encode())
    again = read_urdf(xml)
    assert (again.name, again.root, again.joints) == (urdf.name, urdf.root, urdf.joints)
    for name, one in urdf.links.items():
        other = again.links[name]
        assert (other.collisions, other.visuals) == (one.collisions, one.visuals)
        assert (other.inertial is None) == (one.inertial is None)
    read_again = read_tags(xml, again)
    assert [item.element.tag for item in read_again.items] == ["sensor", "plugin"]
    sensor = read_again.items[0]
    assert isinstance(sensor, SensorTag)
    assert sensor.mount(1.0, "t")["pose"].position == pytest.approx((0.1, 0.2, 0.3))
