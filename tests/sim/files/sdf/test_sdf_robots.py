"""SDF robots: how they load, stand and drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.check import is_robot
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.xml_file import root_tag
from tests.sim.builders import ROOM, run, simulator, texts

INERTIA = "<inertia><ixx>{i}</ixx><iyy>{i}</iyy><izz>{i}</izz></inertia>"
BASE = f"""<link name="base"><pose>0 0 0.1 0 0 0</pose>
<inertial><mass>3</mass>{INERTIA.format(i=0.02)}</inertial>
<collision name="c"><geometry><box><size>0.3 0.2 0.05</size></box></geometry></collision>
<visual name="v"><geometry><box><size>0.3 0.2 0.05</size></box></geometry>
<material><diffuse>1 0 0 1</diffuse></material></visual>
<sensor name="scanner" type="gpu_lidar"><pose relative_to="mast">0 0 0.05 0 0 0</pose>
<topic>scan</topic><update_rate>10</update_rate><lidar><scan><horizontal><samples>360</samples>
<min_angle>-3.1</min_angle><max_angle>3.1</max_angle></horizontal></scan><range><min>0.05</min>
<max>20</max></range></lidar></sensor></link>
<frame name="mast" attached_to="base"><pose>0.05 0 0.2 0 0 0</pose></frame>"""
WHEEL = """<link name="{name}"><pose>{x} {y} 0.05 -1.5707963267948966 0 0</pose>
<inertial><mass>0.3</mass>{inertia}</inertial>
<collision name="c"><geometry><cylinder><radius>0.05</radius><length>0.02</length></cylinder>
</geometry><surface><friction><ode><mu>1.2</mu></ode></friction></surface></collision></link>
<joint name="{name}_joint" type="revolute"><parent>base</parent><child>{name}</child>
<axis>{axis}</axis></joint>"""
AXES = (
    "<xyz>0 0 1</xyz>",
    "<xyz expressed_in='__model__'>0 1 0</xyz>"
    "<limit><lower>-1e16</lower><upper>1e16</upper></limit>",
    "<xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame>",
    "<xyz expressed_in='base'>0 1 0</xyz>",
)
DRIVE = """<plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
{joints}<wheel_separation>0.26</wheel_separation><wheel_radius>0.05</wheel_radius>
<topic>cmd_vel</topic></plugin>"""
CASTER = """<link name="ball"><pose>-0.12 0 0.02 0 0 0</pose><collision name="c"><geometry><sphere>
<radius>0.02</radius></sphere></geometry></collision></link>
<joint name="ball_joint" type="ball"><parent>base</parent><child>ball</child></joint>"""


def _wheels(axis: str, count: int = 4) -> str:
    positions = [(x, y) for x in (0.1, -0.1)[: count // 2] for y in (0.13, -0.13)]
    inertia = INERTIA.format(i=3e-4)
    return "".join(
        WHEEL.format(name=f"wheel_{i}", x=x, y=y, axis=axis, inertia=inertia)
        for i, (x, y) in enumerate(positions)
    )


def _robot(folder: Path, axis: str = AXES[0], extra: str = "", count: int = 4) -> Path:
    joints = "".join(
        f"<{'left' if i % 2 == 0 else 'right'}_joint>wheel_{i}_joint</"
        f"{'left' if i % 2 == 0 else 'right'}_joint>"
        for i in range(count)
    )
    inside = BASE + _wheels(axis, count) + DRIVE.format(joints=joints) + extra
    path = folder / "robot.sdf"
    path.write_text(f"<sdf version='1.9'><model name='bot'>{inside}</model></sdf>", "utf-8")
    return path


@pytest.mark.parametrize("axis", AXES)
def test_sdf_robot_drives_and_sees(tmp_path: Path, axis: str) -> None:
    path = _robot(tmp_path, axis)
    assert is_robot(path)
    sim = simulator(ROOM, robot=path)
    robot = sim.robot.model
    assert robot.urdf.name == "bot"
    assert '<robot name="bot">' in robot.urdf.text
    assert robot.drive.left == ("wheel_0_joint", "wheel_2_joint")
    assert robot.urdf.joints["wheel_0_joint"].kind == "continuous"
    assert robot.settings.friction["wheel_0"] == 1.2
    mount = robot.urdf.T_root("base") @ robot.settings.sensors[0].pose
    assert mount.position == pytest.approx((0.05, 0.0, 0.25), abs=1e-9)
    last = run(sim, 2.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.05)
    assert last.scan is not None
    assert np.isfinite(last.scan.ranges).all()


def test_frames_are_links_and_balls_are_casters(tmp_path: Path) -> None:
    robot = load_robot(_robot(tmp_path, extra=CASTER, count=2), SearchPath())
    assert robot.urdf.joints["mast_frame"].parent == "base"
    assert robot.urdf.T_root("mast").position == pytest.approx((0.05, 0.0, 0.2))
    assert not any("'ball" in note for note in texts(robot.notes))
    assert robot.settings.friction["ball"] < 0.05
    mu = "<surface><friction><ode><mu>1</mu></ode></friction></surface>"
    rough = CASTER.replace("</geometry>", f"</geometry>{mu}")
    robot = load_robot(_robot(tmp_path, extra=rough, count=2), SearchPath())
    assert robot.settings.friction["ball"] < 0.05  # it rolls, whatever its surface
    off = rough.replace("<geometry>", "<pose>0.01 0 0 0 0 0</pose><geometry>")
    robot = load_robot(_robot(tmp_path, extra=off, count=2), SearchPath())
    assert robot.settings.friction["ball"] == 1.0
    assert "joint 'ball_joint': type 'ball' is held fast" in texts(robot.notes)


def test_included_and_nested_models_are_parts_of_the_robot(tmp_path: Path) -> None:
    folder = tmp_path / "models" / "mount"
    folder.mkdir(parents=True)
    link = "<link name='plate'><pose>0 0 0.1 0 0 0</pose></link>"
    text = f"<sdf version='1.9'><model name='mount'>{link}</model></sdf>"
    (folder / "model.sdf").write_text(text, encoding="utf-8")
    nested = """<include><uri>model://mount</uri><name>top</name>
    <pose>0.1 0 0.2 0 0 1</pose></include>
    <joint name="j" type="fixed"><parent>base</parent><child>top::plate</child></joint>
    <include merge="true"><uri>model://mount</uri></include>"""
    robot = load_robot(_robot(tmp_path, extra=nested), SearchPath())
    expected = Pose3((0.1, 0.0, 0.2)) @ Pose3((0.0, 0.0, 0.0))
    above = np.array(robot.urdf.T_root("top/plate").position) - expected.position
    assert above == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert "link 'plate': no joint carries it: it is fixed to 'base'" in texts(robot.notes)


def test_sdf_file_without_a_model_is_no_robot(tmp_path: Path) -> None:
    path = tmp_path / "w.sdf"
    path.write_text("<sdf version='1.9'><world name='w'/></sdf>", encoding="utf-8")
    assert not is_robot(path)
    with pytest.raises(RobotError, match=r"is a world in which no model has a drive$"):
        load_robot(path)
    joint = "<joint name='j' type='fixed'><parent>base</parent><child>none</child></joint>"
    broken = _robot(tmp_path, extra=joint)
    with pytest.raises(RobotError, match="frame 'none' does not exist; valid: base"):
        load_robot(broken)


@pytest.mark.parametrize(
    ("root", "text"),
    [
        ("sdf", "<!-- made of a\n<robot> --><sdf version='1.6'/>"),
        ("robot", "<?xml version='1.0'?><!-- no <sdf> --><robot name='r'/>"),
        ("", "<!-- <sdf/> --><launch/>"),
    ],
)
def test_a_comment_does_not_say_what_a_file_is(root: str, text: str) -> None:
    assert root_tag(text.encode()) == root
