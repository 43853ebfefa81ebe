"""The robot's model, optical frames and URDF."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.inputs import footprint_of, named_robot
from arjuna_sim.model.optical import T_BODY_OPTICAL, SensorFrame, sensor_frame
from arjuna_sim.model.robot import footprint
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Hinge, Joint, Link, Mimic, Urdf

ASIDE = Pose3((0.0, 0.02, 0.0), T_BODY_OPTICAL.quaternion)


def robot(**children: Pose3) -> Urdf:
    """Return a robot with a link `camera` and fixed children of it."""
    links = {name: Link(name, None, (), ()) for name in ("camera", *children)}
    joints = {name: Joint(name, "fixed", "camera", name, T) for name, T in children.items()}
    return Urdf(Path("r.urdf"), "r", "", "camera", links, joints)


def camera(frame: str, pose: Pose3 = ORIGIN) -> CameraSettings:
    """Return a camera on the link `camera`."""
    return CameraSettings(
        link="camera",
        frame=frame,
        rate=30.0,
        name="front eye",
        pose=pose,
        width=64,
        height=48,
        horizontal_fov=1.0,
        near=0.1,
        far=10.0,
    )


def added(name: str, parent: str, T: Pose3 = ORIGIN) -> SensorFrame:
    """Return an optical frame that the simulation adds."""
    return SensorFrame(name, parent, T @ T_BODY_OPTICAL)


UP = Pose3((0.1, 0.0, 0.3))


@pytest.mark.parametrize(
    ("urdf", "named", "pose", "expected"),
    [
        (robot(), "camera", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(), "eye_optical", ORIGIN, added("eye_optical", "camera")),
        (robot(), "left_eye", ORIGIN, added("left_eye", "camera")),
        (robot(), "world", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(eye=ASIDE), "eye", ORIGIN, SensorFrame("eye")),
        (robot(eye=ASIDE), "camera", ORIGIN, SensorFrame("eye")),
        (robot(eye=Pose3()), "eye", ORIGIN, added("eye_optical_frame", "eye")),
        (robot(eye=Pose3()), "camera", ORIGIN, added("camera_optical_frame", "camera")),
        (robot(eye=UP @ T_BODY_OPTICAL), "eye", UP, SensorFrame("eye")),
        (robot(eye=ASIDE), "eye", UP, added("camera_front_eye_optical_frame", "camera", UP)),
        (robot(), "eye_optical", UP, added("eye_optical", "camera", UP)),
    ],
)
def test_frame_of_pictures(urdf: Urdf, named: str, pose: Pose3, expected: SensorFrame) -> None:
    assert sensor_frame(urdf, camera(named, pose)) == expected


@pytest.mark.parametrize(
    ("named", "pose", "expected"),
    [
        ("camera", ORIGIN, SensorFrame("camera")),
        ("scanner", ORIGIN, SensorFrame("scanner", "camera")),
        ("map", ORIGIN, SensorFrame("camera")),
        ("up", UP, SensorFrame("up")),
        ("camera", UP, SensorFrame("camera_top_lidar", "camera", UP)),
        ("scanner", UP, SensorFrame("scanner", "camera", UP)),
    ],
)
def test_an_offset_sensor_has_its_frame(named: str, pose: Pose3, expected: SensorFrame) -> None:
    sensor = SensorSettings(
        link="camera", frame=named, rate=5.0, topic="t", name="top lidar", pose=pose
    )
    assert sensor_frame(robot(up=UP), sensor) == expected


def test_optical_axes_are_right_down_and_ahead() -> None:
    assert T_BODY_OPTICAL.position == (0.0, 0.0, 0.0)
    axes = T_BODY_OPTICAL.rotation()
    np.testing.assert_allclose(axes, [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], atol=1e-12)
    assert T_BODY_OPTICAL.position == (0.0, 0.0, 0.0)


_ROBOT = """<robot name="r">
  <link name="base"><collision><origin xyz="0.1 0 0.2" rpy="0 0 {turn}"/>
    <geometry><box size="0.6 0.2 0.1"/></geometry></collision>
    <visual><geometry><box size="9 9 9"/></geometry></visual></link>
  <link name="mast"><collision><geometry><cylinder radius="0.05" length="1"/></geometry>
    </collision></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="mast"/>
    <origin xyz="0 {mast} 0"/></joint>
  {wheels}
</robot>"""
_WHEEL = """<link name="{side}_wheel"><visual><geometry><cylinder radius="0.05" length="0.04"/>
    </geometry></visual></link>
  <joint name="{side}_wheel_joint" type="continuous"><parent link="base"/>
    <child link="{side}_wheel"/><axis xyz="0 0 1"/><origin xyz="0 {y} 0" rpy="-1.5707963 0 0"/>
  </joint>"""


def _outline(folder: Path, turn: float = 0.0, mast: float = 0.0, wheels: bool = False) -> set[str]:
    path = folder / "r.urdf"
    pair = (_WHEEL.format(side="left", y=0.2) + _WHEEL.format(side="right", y=-0.2)) * wheels
    path.write_text(_ROBOT.format(turn=turn, mast=mast, wheels=pair), encoding="utf-8")
    return {f"{x:.2f} {y:.2f}" for x, y in footprint(named_robot(str(path), ""), "base")}


def test_it_is_the_hull_of_what_is_solid(tmp_path: Path) -> None:
    assert _outline(tmp_path) == {"0.40 0.10", "0.40 -0.10", "-0.20 0.10", "-0.20 -0.10"}
    turned = {one.split()[1] for one in _outline(tmp_path, turn=np.pi / 2)}
    assert {"0.30", "-0.30"} <= turned


def test_what_stands_out_widens_it(tmp_path: Path) -> None:
    ys = [float(one.split()[1]) for one in _outline(tmp_path, mast=0.4)]
    assert max(ys) == pytest.approx(0.45, abs=0.003)


def test_wheels_without_a_solid_shape_count_by_their_looks(tmp_path: Path) -> None:
    ys = [float(one.split()[1]) for one in _outline(tmp_path, wheels=True)]
    assert max(ys) == pytest.approx(0.22, abs=0.003)


def test_it_is_in_the_frame_that_is_asked_for(tmp_path: Path) -> None:
    _outline(tmp_path, mast=0.4)
    robot = named_robot(str(tmp_path / "r.urdf"), "")
    low = footprint(robot, "mast").min(axis=0) - footprint(robot, "base").min(axis=0)
    np.testing.assert_allclose(low, (0.0, -0.4), atol=1e-3)
    assert footprint_of(robot, "nowhere") == footprint_of(robot, "base")


def test_a_robot_without_a_solid_shape_has_none(tmp_path: Path) -> None:
    path = tmp_path / "none.urdf"
    path.write_text('<robot name="r"><link name="base"/></robot>', encoding="utf-8")
    assert footprint_of(named_robot(str(path), ""), "base") == ""


AT = Pose3.from_rpy((1.0, 2.0, 3.0), (0.3, -0.2, 0.9))
AXIS = (0.36, 0.48, 0.8)


@pytest.mark.parametrize("position", [0.0, 0.5, -2.0])
def test_a_prismatic_joint_slides_along_its_axis(position: float) -> None:
    found = Joint("j", "prismatic", "a", "b", AT, AXIS).at(position)
    expected = np.array(AT.position) + AT.rotation() @ AXIS * position
    assert found.position == pytest.approx(tuple(expected))
    np.testing.assert_allclose(found.rotation(), AT.rotation(), atol=1e-12)


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("position", [0.0, 0.5, -2.0])
def test_a_joint_turns_about_its_axis(kind: str, position: float) -> None:
    """By Rodrigues' formula."""
    found = Joint("j", kind, "a", "b", AT, AXIS).at(position)
    x, y, z = AXIS
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned = np.eye(3) + math.sin(position) * K + (1.0 - math.cos(position)) * K @ K
    np.testing.assert_allclose(found.rotation(), AT.rotation() @ turned, atol=1e-12)
    assert found.position == pytest.approx(AT.position)


@pytest.mark.parametrize(
    ("kind", "has"),
    [
        *(("fixed", False), ("floating", False), ("planar", False)),
        *(("revolute", True), ("continuous", True), ("prismatic", True)),
    ],
)
def test_one_number_moves_what_turns_or_slides(kind: str, has: bool) -> None:
    assert Joint("j", kind, "a", "b", ORIGIN).has_position == has


def test_joints_and_hinges_neither_brake_nor_end_by_default() -> None:
    joint, hinge = Joint("j", "revolute", "a", "b", ORIGIN), Hinge(False, (1.0, 0.0, 0.0))
    assert (joint.damping, joint.friction, joint.limits) == (0.0, 0.0, None)
    assert (hinge.damping, hinge.friction, hinge.limits) == (0.0, 0.0, None)
    assert hinge.anchor == (0.0, 0.0, 0.0)
    assert joint.axis == (1.0, 0.0, 0.0)  # URDF's own
    assert (Mimic("k").multiplier, Mimic("k").offset) == (1.0, 0.0)
