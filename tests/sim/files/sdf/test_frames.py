"""Frames of SDF and joints of worlds."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.frames import Scope, base_of, raw_pose
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.world import World
from tests.sim.builders import run, saved_world, simulator, texts

AT = "<pose>{} 0 0 0 0 0</pose>"


def file(inside: str, version: str = "1.9") -> XmlFile:
    text = f"<sdf version='{version}'><model name='m'>{inside}</model></sdf>"
    return XmlFile(Path("w.sdf"), "sdf", WorldError, text.encode())


def scope(inside: str, version: str = "1.9") -> Scope:
    xml = file(inside, version)
    return Scope(xml, xml.root[0], "model 'm'")


def read(pose: str) -> Pose3:
    xml = file(pose)
    return raw_pose(xml, xml.root[0], "here")


def x_of(inside: str, name: str) -> float:
    """Return where a named thing is along x."""
    return scope(inside).find(name).position[0]


@pytest.mark.parametrize("pose", ["", "<pose/>", "<pose> </pose>"])
def test_no_pose_is_the_origin(pose: str) -> None:
    assert read(pose) == ORIGIN


def test_angles_are_radians_by_default_and_quaternions_any_length() -> None:
    right = Pose3.from_rpy((1.0, 2.0, 3.0), (0.0, 0.0, math.pi / 2))
    for pose in (
        f"<pose>1 2 3 0 0 {math.pi / 2}</pose>",
        "<pose degrees='true'>1 2 3 0 0 90</pose>",
        "<pose rotation_format='quat_xyzw'>1 2 3 0 0 2 2</pose>",
        "<pose rotation_format='quat_xyzw'>1 2 3 0 0 1e200 1e200</pose>",
    ):
        assert read(pose).position == (1.0, 2.0, 3.0)
        assert read(pose).quaternion == pytest.approx(right.quaternion)
    x, y, z, w = (0.1, 0.2, 0.3, 0.927361849)
    found = read(f"<pose rotation_format='quat_xyzw'>0 0 0 {x} {y} {z} {w}</pose>")
    assert found.quaternion == pytest.approx((w, x, y, z))


@pytest.mark.parametrize("numbers", ["0 0 0 0", "inf 0 0 1"])
def test_a_quaternion_that_is_no_rotation_is_refused(numbers: str) -> None:
    with pytest.raises(WorldError, match="here pose"):
        read(f"<pose rotation_format='quat_xyzw'>0 0 0 {numbers}</pose>")


def test_a_pose_is_relative_in_the_words_of_any_version() -> None:
    for tag, expected in (
        ("", ""),
        ("<pose/>", ""),
        ("<pose relative_to=' a '/>", "a"),
        ("<pose frame='b'/>", "b"),
        ("<pose relative_to='a' frame='b'/>", "a"),
    ):
        assert base_of(file(tag).root[0]) == expected


@pytest.mark.parametrize("name", ["__model__", "__root__", "world", ""])
def test_the_scopes_own_frame_is_the_origin(name: str) -> None:
    assert scope(f"<link name='a'>{AT.format(1)}</link>").find(name) == ORIGIN


@pytest.mark.parametrize("tag", ["link", "frame", "joint", "model"])
def test_poses_are_relative_to_what_they_name(tag: str) -> None:
    inside = (
        f"<{tag} name='a'>{AT.format(1)}</{tag}>"
        "<link name='b'><pose relative_to='a'>10 0 0 0 0 0</pose></link>"
        "<link name='c'><pose relative_to='b'>100 0 0 0 0 0</pose></link>"
    )
    assert [x_of(inside, name) for name in "abc"] == [1.0, 11.0, 111.0]


def test_an_include_is_called_by_the_name_that_it_gives() -> None:
    assert x_of(f"<include><name> i </name>{AT.format(4)}</include>", "i") == 4.0


def test_a_pose_without_a_base_is_relative_to_its_parent() -> None:
    xml = file(f"<link name='l'>{AT.format(1)}</link>")
    own = Scope(xml, xml.root[0], "m")
    parent = Pose3((5.0, 0.0, 0.0))
    assert own.pose(xml.root[0][0], "l").position[0] == 1.0
    assert own.pose(xml.root[0][0], "l", parent).position[0] == 6.0
    given = file("<link name='l'><pose relative_to='__model__'>1 0 0 0 0 0</pose></link>")
    own = Scope(given, given.root[0], "m")
    assert own.pose(given.root[0][0], "l", parent).position[0] == 1.0


def test_frames_move_with_what_they_are_attached_to_and_joints_with_their_child() -> None:
    inside = (
        f"<link name='a'>{AT.format(1)}</link>"
        f"<frame name='f' attached_to='a'>{AT.format(10)}</frame>"
        f"<joint name='j'><child>f</child>{AT.format(100)}</joint>"
        f"<frame name='g' attached_to='j'><pose relative_to='a'>1000 0 0 0 0 0</pose></frame>"
    )
    assert [x_of(inside, name) for name in "fjg"] == [11.0, 111.0, 1001.0]


def test_a_name_of_a_link_and_of_its_joint_is_the_link_s() -> None:
    link = f"<link name='a'>{AT.format(1)}</link>"
    joint = "<joint name='a'><child>a</child></joint>"
    for inside in (link + joint, joint + link, f"<frame name='a'/>{link}{joint}"):
        assert x_of(inside, "a") == 1.0


@pytest.mark.parametrize(("base", "x"), [("", 11.0), ("a", 101.0), ("none", 11.0), ("m::n", 11.0)])
def test_a_part_of_a_link_is_in_it_where_its_base_does_not_exist(base: str, x: float) -> None:
    part = f"<sensor name='s'><pose relative_to='{base}'>1 0 0 0 0 0</pose></sensor>"
    xml = file(f"<link name='l'>{part}</link><frame name='a'>{AT.format(100)}</frame>")
    sensor = xml.child(xml.root, "model/link/sensor", "l")
    found = Scope(xml, xml.root[0], "model 'm'").in_link(sensor, "sensor", Pose3((10.0, 0.0, 0.0)))
    assert found.position[0] == x
    lost = f"sensor: is relative to '{base}', which does not exist: its pose is in its link"
    assert texts(tuple(xml.notes)) == ((lost,) if base in ("none", "m::n") else ())


def test_names_lead_into_nested_models_and_out_of_merged_ones() -> None:
    inner = f"<model name='n'{{}}>{AT.format(1)}<link name='l'>{AT.format(10)}</link></model>"
    assert x_of(inner.format(""), "n::l") == 11.0
    assert x_of(inner.format(" merge='true'"), "l") == 11.0
    with pytest.raises(WorldError, match="frame 'l' does not exist; valid: n"):
        x_of(inner.format(""), "l")
    deep = f"<model name='o'>{AT.format(100)}{inner.format('')}</model>"
    assert x_of(deep, "o::n::l") == 111.0
    assert x_of(f"<link name='n::l'>{AT.format(7)}</link>{inner.format('')}", "n::l") == 7.0


@pytest.mark.parametrize(
    ("inside", "name", "problem"),
    [
        ("", "a", "frame 'a' does not exist"),
        (
            "<link name='a'><pose relative_to='b'/></link>"
            "<link name='b'><pose relative_to='a'/></link>",
            "a",
            "frame 'a' is relative to itself: a -> b -> a",
        ),
        ("<frame name='a' attached_to='a'/>", "a", "frame 'a' is relative to itself: a -> a"),
        (
            "<model name='a' merge='true'><pose relative_to='l'/><link name='l'/></model>",
            "l",
            "is relative to itself",
        ),
    ],
)
def test_an_invalid_frame_is_refused(inside: str, name: str, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        scope(inside).find(name)


def test_chains_end_at_a_hundred_frames() -> None:
    links = "".join(
        f"<link name='{i + 1}'><pose relative_to='{i}'>1 0 0 0 0 0</pose></link>"
        for i in range(102)
    )
    inside = f"<link name='0'/>{links}"
    assert x_of(inside, "100") == 100.0
    with pytest.raises(WorldError, match="ends a chain of more than 100 frames"):
        x_of(inside, "102")


@pytest.mark.parametrize(
    ("axis", "version", "expected"),
    [
        ("<axis/>", "1.9", 5.0),
        ("<axis><xyz>1 0 0</xyz></axis>", "1.9", 5.0),
        ("<axis><xyz>1 0 0</xyz></axis>", "1.5", 5.0),
        ("<axis><xyz>1 0 0</xyz></axis>", "1.4", 0.0),
        ("<axis><xyz expressed_in='l'>1 0 0</xyz></axis>", "1.9", 1.0),
        ("<axis><use_parent_model_frame> True </use_parent_model_frame></axis>", "1.5", 0.0),
        ("<axis><use_parent_model_frame>0</use_parent_model_frame></axis>", "1.5", 5.0),
    ],
)
def test_an_axis_is_in_its_joints_frame(axis: str, version: str, expected: float) -> None:
    xml = file(f"<link name='l'>{AT.format(1)}</link>{axis}", version)
    own = Scope(xml, xml.root[0], "m")
    assert own.axis(xml.root[0][1], Pose3((5.0, 0.0, 0.0))).position[0] == expected


_INERTIAL = "<inertial><mass>4</mass></inertial>"
_LEAF = "<geometry><box><size>0.05 1 1</size></box></geometry>"


def _model(name: str, pose: str, static: bool = False) -> str:
    inside = f"<link name='l'>{_INERTIAL}<collision name='c'>{_LEAF}</collision></link>"
    given = f"<static>{str(static).lower()}</static>"
    return f"<model name='{name}'>{given}<pose>{pose}</pose>{inside}</model>"


def _joint(kind: str, parent: str, child: str, inside: str = "") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    axis = "<axis><xyz>0 0 1</xyz></axis>" if kind == "revolute" else ""
    return f"<joint name='j' type='{kind}'>{ends}{axis}{inside}</joint>"


def _world(folder: Path, inside: str) -> Path:
    ground = "<include><uri>model://ground_plane</uri></include>"
    return saved_world(folder, ground + inside)


def _read(folder: Path, inside: str) -> World:
    return load_world(_world(folder, inside))


@pytest.mark.parametrize(
    ("parent", "child"), [("world", "door::l"), ("post::l", "door"), ("post", "door::l")]
)
def test_a_door_of_the_world_turns_on_its_hinge(tmp_path: Path, parent: str, child: str) -> None:
    post = _model("post", "2 -2 0.5 0 0 0", static=True)
    hinge = _joint("revolute", parent, child, "<pose>0 -0.5 0 0 0 0</pose>")
    world = _read(tmp_path, post + _model("door", "2 0 0.6 0 0 1.2") + hinge)
    assert texts(world.notes) == ()
    found = world.movable["door::l"].hinge
    assert found is not None
    assert found.axis == pytest.approx((0.0, 0.0, 1.0))
    assert found.anchor == pytest.approx((0.0, -0.5, 0.0))


def test_what_is_fixed_to_the_world_stays_in_the_air(tmp_path: Path) -> None:
    joint = _joint("fixed", "world", "sign")
    sim = simulator(_world(tmp_path, _model("sign", "2 0 2 0 0 0") + joint))
    run(sim, 1.0)
    assert sim.stage.motion("sign").pose == Pose3((2.0, 0.0, 2.0))


def test_a_joint_of_two_that_move_is_left_out_by_name(tmp_path: Path) -> None:
    models = _model("a", "2 0 0.5 0 0 0") + _model("b", "4 0 0.5 0 0 0")
    world = _read(tmp_path, models + _joint("fixed", "a::l", "b::l"))
    assert "joint 'j': connects no model to what stands fast: not simulated" in texts(world.notes)
    assert set(world.movable) == {"a", "b"}


def test_a_joint_whose_link_does_not_exist_costs_no_model(tmp_path: Path) -> None:
    world = _read(tmp_path, _model("a", "2 0 0.5 0 0 0") + _joint("fixed", "world", "c::l"))
    assert set(world.movable) == {"a"}
    assert any(note.startswith("joint 'j' is left out") for note in texts(world.notes))
