"""Robot and world files: what loads, and what is refused with a reason."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError, WorldError
from arjuna_core.se2 import IDENTITY
from arjuna_core.twist import Velocity
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.notes import NoteKind
from tests.sim.builders import ROBOT, ROOM, edited, run, simulator, texts

BOMB = """<?xml version="1.0"?>
<!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>
<robot name="&b;"/>"""
MESH = '<mesh filename="missing.stl"/>'
BODY = '<box size="0.45 0.30 0.10"/>'
SOLID = f"<collision>\n      <geometry>\n        {BODY}"
PLAIN = """<robot name="plain">
  <link name="base">
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.02"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.05"/></geometry></collision>
  </link>
  {wheels}
</robot>"""
WHEEL = """<link name="{name}">
    <inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="2e-4"/></inertial>
    <collision><geometry><cylinder radius="0.04" length="0.02"/></geometry></collision>
  </link>
  <joint name="{name}_joint" type="continuous">
    <parent link="base"/><child link="{name}"/>
    <origin xyz="{x} {y} 0" rpy="1.570796 0 0"/><axis xyz="0 0 {axis}"/>
  </joint>"""


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


def test_shipped_world_has_the_guides_walls_and_boxes() -> None:
    world = load_world(ROOM)
    assert world.notes == ()
    solid = {b.model: b.part for b in world.bodies if b.collides and b.model != "ground_plane"}
    assert sorted(solid) == sorted(
        [f"wall_{side}" for side in ("north", "south", "east", "west")]
        + [f"obstacle_{colour}" for colour in ("red", "green", "blue", "yellow")]
    )
    assert solid["obstacle_yellow"].pose.position == (3.0, -3.0, 0.3)


def test_robot_without_plugins_gets_its_wheels_from_its_joints(tmp_path: Path) -> None:
    wheels = [
        WHEEL.format(name=name, x=x, y=y, axis=axis)
        for name, x, y, axis in (
            ("fl", 0.08, 0.12, -1),
            ("fr", 0.08, -0.12, -1),
            ("rl", -0.08, 0.12, 1),
            ("rr", -0.08, -0.12, 1),
        )
    ]
    path = tmp_path / "plain.urdf"
    path.write_text(PLAIN.format(wheels="\n".join(wheels)), encoding="utf-8")
    sim = simulator(robot=path)
    assert any("no drive plugin" in note for note in sim.notes)
    assert sim.robot.model.drive.separation == pytest.approx(0.24)
    last = run(sim, 3.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.05)  # both axes' signs drive forward
    assert last.truth.z == pytest.approx(0.04, abs=0.002)  # stands on its wheels
    assert last.scan is None
    assert last.imu is None


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (
            '<mass value="5.0"/>',
            '<mass value="-1"/>',
            "link 'base_link' inertial mass.*valid: 0 to",
        ),
        ('<mass value="5.0"/>', '<mass value="nan"/>', "link 'base_link' inertial.*finite"),
        ('<mass value="5.0"/>', '<mass value="heavy"/>', "'heavy' is not 1 numbers"),
        ('ixx="0.05"', 'ixx="nan"', "link 'base_link' inertial ixx.*finite"),
        ('<mass value="5.0"/>', '<mass value="1e9"/>', "inertial mass.*valid: 0 to 1e.07"),
        (SOLID, SOLID.replace("0.45 ", ""), "has 2 numbers.*valid: 3"),
        (SOLID, SOLID.replace("box", "bux"), "<bux> is unknown; did you mean 'box'"),
        ('<parent link="base_link"/>', '<parent link="base_lnik"/>', "did you mean 'base_link'"),
        ('type="fixed"', 'type="screw"', "not simulated; valid: fixed, continuous"),
        ("<samples>360", "<samples>0", "<samples> is 0; valid: 1 to 100000"),
        ("front_left_joint</left", "front_lefft_joint</left", "did you mean 'front_left_joint'"),
        ('<link name="imu_link"/>', "", "link 'imu_link' does not exist"),
        ('<joint name="imu_joint"', '<joint name="lidar_joint"', "'lidar_joint': is there twice"),
    ],
)
def test_bad_robot_is_refused_with_its_place(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    with pytest.raises(RobotError, match=problem) as caught:
        load_robot(edited(ROBOT, tmp_path, old, new))
    assert "\n" not in str(caught.value)
    assert "arjuna.urdf" in str(caught.value)


def test_missing_truncated_and_foreign_robot_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=r"none\.urdf: cannot be read: No such file"):
        load_robot(tmp_path / "none.urdf")
    cut = tmp_path / "cut.urdf"
    cut.write_bytes(ROBOT.read_bytes()[:3000])
    with pytest.raises(RobotError, match=r"line .*broken XML"):
        load_robot(cut)
    with pytest.raises(RobotError, match="is no robot: <sdf> must hold one <model>"):
        load_robot(ROOM)
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(bytes(range(256)))
    with pytest.raises(RobotError, match=r"broken XML|no readable XML"):
        load_robot(binary)


def test_entity_bomb_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.urdf"
    path.write_text(BOMB, encoding="utf-8")
    with pytest.raises(RobotError, match="declares a DTD or entities"):
        load_robot(path)


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


def test_macro_that_cannot_be_expanded_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    source = ROBOT.with_suffix(".urdf.xacro")
    path = edited(source, tmp_path, 'value="0.05"', 'value="${nothing}"')
    with pytest.raises(RobotError, match=r"xacro cannot expand it.*nothing") as caught:
        load_robot(path)
    assert "\n" not in str(caught.value)


def test_entity_bomb_with_macros_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.xacro"
    path.write_text(BOMB, encoding="utf-8")
    with pytest.raises(RobotError, match="declares a DTD or entities"):
        load_robot(path)


def test_missing_collision_mesh_is_noted_not_fatal(tmp_path: Path) -> None:
    path = edited(ROBOT, tmp_path, BODY, "<box size='1 1 1'/>")
    robot = load_robot(edited(path, tmp_path, BODY, MESH))
    assert texts(robot.notes) == (
        "link 'base_link' collision: mesh 'missing.stl' does not exist, so it is left out",
    )


def test_ball_on_the_chassis_rolls_like_a_caster(tmp_path: Path) -> None:
    ball = """<link name="ball">
    <inertial><mass value="0.1"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5"/></inertial>
    <collision><geometry><sphere radius="0.02"/></geometry></collision>
  </link>
  <joint name="ball_joint" type="fixed">
    <parent link="base"/><child link="ball"/><origin xyz="-0.08 0 -0.02"/>
  </joint>"""
    wheels = [
        WHEEL.format(name=name, x=0.05, y=y, axis=-1) for name, y in (("l", 0.12), ("r", -0.12))
    ]
    path = tmp_path / "caster.urdf"
    path.write_text(PLAIN.format(wheels="\n".join([*wheels, ball])), encoding="utf-8")
    last = run(simulator(robot=path), 3.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.05)


def test_missing_inertial_is_computed_from_the_shapes_and_noted(tmp_path: Path) -> None:
    text = ROBOT.read_text(encoding="utf-8")
    start = text.index("<inertial>", text.index('<link name="front_left_wheel">'))
    end = text.index("</inertial>", start) + len("</inertial>")
    robot = load_robot(edited(ROBOT, tmp_path, text[start:end], ""))
    assert len(robot.notes) == 1
    assert "'front_left_wheel': has no <inertial>" in texts(robot.notes)[0]
    wheel = robot.urdf.links["front_left_wheel"]
    radius, width = wheel.collisions[0].shape.size
    assert wheel.inertial is not None
    assert wheel.inertial.mass == pytest.approx(500.0 * np.pi * radius**2 * width)
    largest = np.linalg.eigvalsh(wheel.inertial.inertia)[2]
    assert largest == pytest.approx(wheel.inertial.mass * radius**2 / 2, rel=1e-6)


def test_inertia_that_no_body_has_is_computed_and_noted(tmp_path: Path) -> None:
    robot = load_robot(edited(ROBOT, tmp_path, 'ixx="0.05"', 'ixx="-1"'))
    assert len(robot.notes) == 1
    assert "'base_link' inertial: the inertia is not positive definite" in texts(robot.notes)[0]
    inertial = robot.urdf.links["base_link"].inertial
    assert inertial is not None
    assert inertial.mass == 5.0
    assert np.diag(inertial.inertia) == pytest.approx(
        5.0 / 12 * np.array([0.3**2 + 0.1**2, 0.45**2 + 0.1**2, 0.45**2 + 0.3**2]), rel=1e-6
    )


def test_robot_without_wheels_loads_and_stands_still(tmp_path: Path) -> None:
    path = tmp_path / "plain.urdf"
    path.write_text(PLAIN.format(wheels=""), encoding="utf-8")
    sim = simulator(robot=path)
    assert sim.robot.model.wheel_joints == ()
    assert any("has no drive" in note for note in sim.notes)
    last = run(sim, 1.0, Velocity(0.5, yaw_rate=0.5))
    assert last.truth.pose.distance(IDENTITY) < 1e-3
    assert last.odometry.T_odom_base.distance(IDENTITY) == 0.0


def test_broken_mesh_is_refused(tmp_path: Path) -> None:
    (tmp_path / "missing.stl").write_text("solid nothing\nendsolid", encoding="utf-8")
    path = edited(ROBOT, tmp_path, BODY, MESH)
    path = edited(path, tmp_path, BODY, MESH)
    with pytest.raises(RobotError, match=r"collision: mesh 'missing\.stl' is a broken mesh"):
        load_robot(path)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("2.5 0 0.3 0 0 0", "nan 0 0.3 0 0 0", "model 'obstacle_red' pose.*finite"),
        ("2.5 0 0.3 0 0 0", "2.5 0 0.3", "has 3 numbers.*valid: 6"),
        ("10.2 0.2 1.0", "10.2 -0.2 1.0", "model 'wall_north' collision <size>.*above zero"),
        ("<size>10.2 0.2 1.0</size>", "", "<box> lacks <size>"),
    ],
)
def test_bad_piece_of_a_world_is_left_out_with_its_place(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    whole = load_world(ROOM)
    world = load_world(edited(ROOM, tmp_path, old, new))
    assert 0 < len(whole.bodies) - len(world.bodies) <= 2
    (note,) = world.notes
    assert note.kind is NoteKind.BROKEN
    assert re.search(problem, note.text)
    assert "\n" not in note.text


def test_bad_world_is_refused(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="broken XML") as caught:
        load_world(edited(ROOM, tmp_path, "<world ", "<wurld "))
    assert "\n" not in str(caught.value)


def test_missing_model_is_noted_not_fatal(tmp_path: Path) -> None:
    world = load_world(edited(ROOM, tmp_path, "model://sun", "model://oak_tree"))
    assert any("model 'model://oak_tree' does not exist" in note for note in texts(world.notes))


def test_models_that_include_each_other_are_left_out(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        (tmp_path / name).mkdir()
        include = f"<include><uri>model://{other}</uri></include>"
        text = f"<sdf><model name='{name}'>{include}</model></sdf>"
        (tmp_path / name / "model.sdf").write_text(text, encoding="utf-8")
    notes = texts(load_world(tmp_path / "a" / "model.sdf").notes)
    assert any("include 'model://a' is left out: model 'model://a' includes" in n for n in notes)


def test_missing_world_is_refused_and_missing_mesh_is_noted(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="No such file"):
        load_world(tmp_path / "none.world")
    mesh = "<mesh><uri>model://hall/hall.stl</uri></mesh>"
    text = "<box><size>10.2 0.2 1.0</size></box>"
    room = ROOM.read_text(encoding="utf-8").split("<geometry>")[1].split("</geometry>")[0].strip()
    assert "".join(room.split()) == "".join(text.split())
    world = load_world(edited(ROOM, tmp_path, room, mesh))
    assert any("mesh 'model://hall/hall.stl' does not exist" in note for note in texts(world.notes))


def test_what_is_not_simulated_becomes_a_note(tmp_path: Path) -> None:
    world = load_world(edited(ROOM, tmp_path, "<static>", "<blink>1</blink><static>"))
    assert texts(world.notes) == ("model 'wall_north': <blink>: not simulated",)
