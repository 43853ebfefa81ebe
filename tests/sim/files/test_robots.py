"""Robots of all kinds: joints, drives by any spelling, guesses, and robots that lie or stand."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.robot import RobotModel
from tests.sim.builders import run, simulator, texts
from tests.sim.robot_files import tags

INERTIAL = '<inertial><mass value="{}"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>'
BASE = f"""<link name="base">{INERTIAL.format(2)}
<collision><geometry><box size="0.3 0.2 0.05"/></geometry></collision></link>"""
WHEEL = """<link name="{name}">
<inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="2e-4"/></inertial>
<collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
<joint name="{name}_joint" type="continuous"><parent link="base"/><child link="{name}"/>
<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/></joint>"""
FOUR = "".join(
    WHEEL.format(name=f"{end}_{side}_wheel", xyz=f"{x} {y} 0", rpy="-1.5707963 0 0")
    for end, x in (("front", 0.1), ("rear", -0.1))
    for side, y in (("left", 0.13), ("right", -0.13))
)
LEFT = ("front_left_wheel_joint", "rear_left_wheel_joint")


TWO = """<link name="ball">
<collision><geometry><sphere radius="0.02"/></geometry></collision></link>
<joint name="ball_joint" type="fixed"><parent link="base"/><child link="ball"/>
<origin xyz="-0.1 0 -0.03"/></joint>""" + "".join(
    WHEEL.format(name=f"{side}_wheel", xyz=f"0.1 {y} 0", rpy="-1.5707963 0 0")
    for side, y in (("left", 0.08), ("right", -0.08))
).replace('length="0.02"', 'length="0.025"')


def _robot(folder: Path, inside: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r">{BASE}{inside}</robot>', encoding="utf-8")
    return path


def _load(folder: Path, inside: str) -> RobotModel:
    return load_robot(_robot(folder, inside), SearchPath())


def _joint(kind: str, extra: str = "", name: str = "tool") -> str:
    return f"""<link name="{name}">{INERTIAL.format(0.1)}</link>
<joint name="{name}_joint" type="{kind}"><parent link="base"/><child link="{name}"/>
<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>{extra}</joint>"""


@pytest.mark.parametrize(
    ("kind", "extra", "moving"),
    [
        ("fixed", "", False),
        ("continuous", "", True),
        ("revolute", '<limit lower="-1" upper="1"/>', True),
        ("prismatic", '<limit lower="-0.1" upper="0.1"/>', True),
        ("floating", "", False),
        ("planar", "", False),
    ],
)
def test_all_joint_types_load(tmp_path: Path, kind: str, extra: str, moving: bool) -> None:
    sim = simulator(robot=_robot(tmp_path, FOUR + _joint(kind, extra)))
    assert ("tool_joint" in sim.robot.model.moving_joints) == moving
    last = run(sim, 1.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.1)
    assert np.isfinite(last.joints.positions).all()
    is_loose = kind in ("floating", "planar")
    assert any("moves freely" in note for note in sim.notes) == is_loose


@pytest.mark.parametrize(("kind", "drives"), [("floating", True), ("fixed", False)])
def test_a_robot_that_floats_in_its_world_is_free(tmp_path: Path, kind: str, drives: bool) -> None:
    held = f"<link name='world'/><joint name='held' type='{kind}'><parent link='world'/>"
    held += "<child link='base'/></joint>"
    sim = simulator(robot=_robot(tmp_path, FOUR + held))
    last = run(sim, 1.0, Velocity(0.3))
    assert last.truth.v == pytest.approx(0.3 if drives else 0.0, abs=0.03)


IMU = """<gazebo><plugin name="imu" filename="libhector_gazebo_ros_imu.so">
<updateRate>25</updateRate><bodyName>base</bodyName><topicName>imu/raw</topicName><frameId>imu_frame</frameId></plugin>
</gazebo>"""


@pytest.mark.parametrize(
    ("inside", "topics"),
    [
        (None, {"imu/raw"}),
        ("<always_on>true</always_on>", {"imu/raw"}),
        ("<topic>own</topic>", {"imu/raw", "own"}),
    ],
)
def test_imu_of_a_plugin_is_one_with_a_silent_sensor_of_its_link(
    tmp_path: Path, inside: str | None, topics: set[str]
) -> None:
    """As old TurtleBot3's, whose bare `<sensor>` says nothing on ROS."""
    sensor = f"<sensor name='imu' type='imu'>{inside}</sensor>" if inside else ""
    text = f"<gazebo reference='base'>{sensor}</gazebo>"
    settings = _load(tmp_path, FOUR + text + IMU).settings
    found = {imu.topic: imu for imu in settings.sensors if isinstance(imu, ImuSettings)}
    assert found.keys() == topics
    imu = found["imu/raw"]
    assert (imu.link, imu.frame, imu.rate) == ("base", "imu_frame", 25.0)


REALSENSE = """<gazebo reference="base">
<sensor name="eyecolor" type="camera"/><sensor name="eyedepth" type="depth"/></gazebo>
<gazebo><plugin name="eye" filename="librealsense_gazebo_plugin.so"><prefix>eye</prefix>
<depthTopicName>depth/raw</depthTopicName><colorOpticalframeName>lens</colorOpticalframeName>
<pointCloud>true</pointCloud><pointCloudTopicName>cloud</pointCloudTopicName></plugin></gazebo>"""


def test_cameras_that_one_plugin_of_the_model_publishes(tmp_path: Path) -> None:
    robot = _load(tmp_path, FOUR + REALSENSE)
    cameras = [s for s in robot.settings.sensors if isinstance(s, CameraSettings)]
    color, depth = cameras
    assert (color.topic, color.frame) == ("eye/color/image_raw", "lens")
    assert color.info_topic == "eye/color/camera_info"
    assert (depth.depth_topic, depth.cloud_topic) == ("eye/depth/raw", "eye/cloud")
    assert (depth.info_topic, depth.frame) == ("eye/depth/camera_info", "base")
    assert not any("not simulated" in note for note in texts(robot.notes))


@pytest.mark.parametrize("given", ["{0}, {1}", "{0},{1}", "{0}</joint_name><joint_name>{1}"])
def test_joints_whose_states_a_plugin_publishes(tmp_path: Path, given: str) -> None:
    named = ("front_left_wheel_joint", "rear_right_wheel_joint")
    tag = f"<joint_name>{given.format(*named)}</joint_name>"
    file = "libgazebo_ros_joint_state_publisher.so"
    plugin = f"<gazebo><plugin name='j' filename='{file}'>{tag}</plugin></gazebo>"
    robot = _load(tmp_path, FOUR + plugin)
    assert robot.settings.reported == named
    assert not any("does not move" in note for note in texts(robot.notes))
    also = "rear_left_wheel_joint"  # a controllers' broadcaster publishes it
    control = "<ros2_control name='c' type='system'>{}</ros2_control>"
    held = "".join(f"<joint name='{name}'/>" for name in (also, "elsewhere", named[0]))
    robot = _load(tmp_path, FOUR + plugin + control.format(held))
    assert robot.settings.reported == (*named, also)


@pytest.mark.parametrize("flag", ["publish_wheel_tf", "publishWheelJointState", "publish_odom"])
def test_a_drive_publishes_its_wheels_beside_the_joints_of_another_plugin(
    tmp_path: Path, flag: str
) -> None:
    """As on a robot whose other plugin names the joints of its arm alone."""
    plugin = "<gazebo><plugin name='j' filename='libgazebo_ros_joint_state_publisher.so'>{}"
    named = "<joint_name>front_left_wheel_joint</joint_name></plugin></gazebo>"
    inside = f"{tags.sides('front', 'rear')}<{flag}>true</{flag}>"
    text = FOUR + plugin.format(named) + tags.plugin("libgazebo_ros_diff_drive.so", inside)
    reported = _load(tmp_path, text).settings.reported
    assert len(set(reported)) == (1 if flag == "publish_odom" else 4)


CONTROLLERS = """
/**:
  controller_manager:
    ros__parameters:
      update_rate: 100
      base_control: {type: diff_drive_controller/DiffDriveController}
      joint_state_broadcaster: {type: joint_state_broadcaster/JointStateBroadcaster}
  base_control:
    ros__parameters:
      left_wheel_names: [front_left_wheel_joint, rear_left_wheel_joint]
      right_wheel_names: [front_right_wheel_joint, rear_right_wheel_joint]
      wheel_separation: 0.26
      wheel_separation_multiplier: 1.5
      wheel_radius: 0.05
      base_frame_id: base
      enable_odom_tf: false
      publish_rate: 25.0
      linear: {x: {max_velocity: 0.7, max_acceleration: 1.5}}
"""


@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize("stamped", [True, False])
@pytest.mark.parametrize("kind", ["gz_ros2_control-system", "libgazebo_ros2_control.so"])
def test_ros2_control_names_a_drive(tmp_path: Path, kind: str, stamped: bool, nested: bool) -> None:
    text = CONTROLLERS if nested else textwrap.dedent(CONTROLLERS.replace("/**:\n", ""))
    if not stamped:
        text = text.replace("publish_rate", "use_stamped_vel: false\n      publish_rate")
        text = text if nested else text.replace("      publish_rate", "    publish_rate")
    (tmp_path / "controllers.yaml").write_text(text, encoding="utf-8")
    remapping = "<ros><remapping>/base_control/odom:=/wheel/odom</remapping></ros>"
    parameters = f"<parameters>{tmp_path}/controllers.yaml</parameters>"
    plugin = f"<plugin filename='{kind}' name='control'>{parameters}{remapping}</plugin>"
    robot = _load(tmp_path, f"{FOUR}<gazebo>{plugin}</gazebo>")
    drive = robot.drive
    assert drive.left == LEFT
    assert drive.separation == pytest.approx(0.39)
    assert drive.command_topic == f"/base_control/cmd_vel{'' if stamped else '_unstamped'}"
    assert (drive.odometry_topic, drive.stamped) == ("/wheel/odom", stamped)
    assert (drive.max_velocity, drive.max_acceleration, drive.rate) == (0.7, 1.5, 25.0)
    assert drive.publishes == ("odom",)
    assert not any("guessed" in note for note in texts(robot.notes))


def test_missing_or_broken_controllers_leave_the_drive_to_a_guess(tmp_path: Path) -> None:
    (tmp_path / "broken.yaml").write_text("a: [", encoding="utf-8")
    files = "".join(f"<parameters>{name}.yaml</parameters>" for name in ("none", "broken"))
    plugin = f"<gazebo><plugin filename='gz_ros2_control-system' name='c'>{files}</plugin></gazebo>"
    robot = _load(tmp_path, FOUR + plugin)
    notes = " ".join(texts(robot.notes))
    assert robot.drive.left == LEFT
    for part in ("'none.yaml' does not exist", "'broken.yaml' are left out", "guessed are"):
        assert part in notes
